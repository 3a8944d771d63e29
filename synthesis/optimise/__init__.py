"""Optimise: from a problem to a cam with a proven lower bound.

In: a ``Problem`` (motion with free laws, follower, limits, sizes, one objective), a tolerance and a
deadline. Out: a ``SolveState`` with the incumbent, the lower bound and what it holds for.

``driver.py`` is the one loop, a spatial branch and bound in immutable state; open it first. The
packages are its roles: ``problem`` and ``conic`` formulate, ``relaxation``, ``separation`` and
``propagation`` make and tighten rows, ``dual_bound`` bounds all motion laws, ``recovery`` and
``heuristics`` find cams, ``refinement`` chooses meshes, ``branching`` divides. ``parameters``
asks the driver about free angles, lifts and lengths.
"""
