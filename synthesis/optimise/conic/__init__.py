"""The relaxation as one cone program over the splines of all free laws and the size together.

In: a ``Problem``, one ``Grid`` for each free law, and the region in which nonconvex limits are to
be relaxed. Out: ``program.ConicModel``, the matrix with the meaning of its rows and columns. Open
``program`` first. Linear limits become rows in ``linear_rows``; nonconvex ones, the pressure angle
of an arm among them, in ``tangent_cuts``.
"""
