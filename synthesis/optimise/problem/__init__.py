"""The problem: motion laws that are partly free, sizes that are free, one objective, all limits.

``problem.Problem`` is what all other packages of the optimiser read; the first file to open.
``grid`` holds the spline spaces and the points of rows, ``boundary`` what neighbours fix of a free
law, ``mean_square`` and ``residual_vibration`` the objective and the limits that are integrals.

Units: specs are made nondimensional before they are solved (``nondimensional``), so that a length
is in the spec's own unit, its longest travel. Docstrings write [length] for it; angles are in rad.
"""
