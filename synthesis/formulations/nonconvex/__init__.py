"""Local optima under limits that are not convex: rows of the cone program, smooth limits, IPOPT.

What comes from here is a cam and never a bound.
"""
