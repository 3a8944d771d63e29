"""Branching: nodes of the spatial branch and bound over sizes, and the tree of its leaves.

In: a ``SolveState`` with an incumbent whose gap is open. Out: the same with a better bound.

``node.py`` says what a node does: process, branch, conclude. ``traced_node.py`` has nodes for all
limits that imply rows over boxes, where the jerk of every free law is capped. ``pivot_node.py`` has
nodes for arms and faces in quick proofs, and where nothing caps the jerk. ``size_search.py`` is for
given laws: boxes of sizes, many at once.
"""
