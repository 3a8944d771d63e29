"""What the rounds of a search hand on: the best cam and bound so far, knots, points, beginnings.

Rounds of cone programs and local searches both go on from it.
"""
