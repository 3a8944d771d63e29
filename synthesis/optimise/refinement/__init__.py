"""Refinement: the mesh of the next relaxation.

In: a solution and its dual bound. Out: knots where the law costs more than the ideal one, and
collocation points where rows are violated between theirs.

``mesh.py`` chooses knots, ``polish.py`` moves them onto the switches of the best law, and
``row_violations.py`` finds points.
"""
