"""Why nothing fits: limits that exclude one another, and the least that each has to give way.

It asks the ladder and the cone program themselves: every way out that it names works.
"""
