"""Relaxation: linear rows that nonconvex limits imply over a box of sizes.

In: a problem and ranges of its sizes. Out: rows on the size that every cam of the box satisfies
(``size_rows.py``). Rows on free laws are made in ``conic.tangent_cuts``, and for limits on a traced
point in ``propagation.improving_region``.
"""
