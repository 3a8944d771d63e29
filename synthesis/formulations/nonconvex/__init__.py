"""Local optima under limits that are not convex: cone programs one after the other, or IPOPT.

What comes from here is a cam and never a bound.
"""
