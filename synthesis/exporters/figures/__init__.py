"""Figures in true shape: the cam with its follower, and the machine with parts that move."""
