"""Exact curves of a cam: B-splines within a stated distance of the true curve."""
