"""Branching: nodes of the spatial branch and bound over sizes, and the tree of its leaves.

In: a ``SolveState`` with an incumbent whose gap is open. Out: the same with a better bound.

``node.py`` says what a node does: process, branch, conclude. ``traced_node.py`` has nodes for
limits on a traced point (curvature, Hertz pressure), ``pivot_node.py`` nodes for arms and faces
whose pivot is free. ``size_search.py`` is for given laws: boxes of sizes, many at once.
"""
