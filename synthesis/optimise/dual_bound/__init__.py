"""Lower bounds over all motion laws, from the multipliers of a cone program over splines.

In: a ``ConicModel`` and any multipliers of it. Out: a ``Bound``. Open ``bound`` first: it derives
why the bound is valid. ``batch`` does the same for hundreds of quantities at once;
``multiplier_density`` spreads multipliers along arcs; ``costates`` and ``dual_ascent`` look for
better ones; ``row_functionals``, ``lagrangian`` and ``switching`` are the terms, their sum, and its
minimum over the laws.
"""
