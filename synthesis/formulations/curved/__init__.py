"""Proofs where limits are curved: boxes, hulls and tubes in which every better cam has to lie.

Motion and size together make such limits not convex; inside a box they imply rows that are, and
these raise the bound or leave the box empty.
"""
