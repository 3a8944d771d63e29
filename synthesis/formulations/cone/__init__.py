"""The cone program over all free laws' coefficients and the follower's size together.

Rows of every kind of limit, the matrix they are written into, and what is read off the plan.
"""
