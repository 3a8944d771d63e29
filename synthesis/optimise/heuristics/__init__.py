"""Heuristics: local optima, by sequential convex programming and by IPOPT.

In: a ``SolveState`` and a start. Out: the state, perhaps with a better incumbent. They propose cams
and prove nothing.

Open ``local_search.py`` first; ``scp.py`` has the method, ``ipopt_search.py`` the fallback,
``perturbed_optimum.py`` optima of slightly changed problems for sensitivities.
"""
