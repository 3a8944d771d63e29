"""Strategies: problems that are solved as others by the same driver.

``dimension_search.py`` fixes a dimension at one value after the other,
``pressure_angle_bisection.py`` bisects an objective that is itself a limit, ``phase_one.py``
minimises the excess of limits where a mesh has no feasible law, ``tight_laws.py`` fixes the laws
that limits leave no slack, ``coarser_tolerance.py`` proves again at a coarser tolerance where a
budget has ended, ``unmodelled_limits.py`` names what a bound leaves out.
"""
