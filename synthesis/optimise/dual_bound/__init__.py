"""Lower bounds over all motion laws, from the multipliers of a cone program over splines.

In: a ``ConicModel`` and any multipliers of it. Out: a ``Bound``. Open ``bound`` first: it derives
why the bound is valid. ``batch`` does the same for hundreds of quantities at once; ``dual_ascent``
and ``multiplier_density`` look for better multipliers; all else are the terms and their sums.
"""
