"""Exact curves of a cam: B-splines, or arcs, within a stated distance of the true curve.

In: a design, which curve, a tolerance. Out: STEP, IGES, DXF or JSON with the largest distance as
metadata. ``exact`` describes a cam's curve span by span; ``numerics/geometry`` fits splines or arcs
to it within the tolerance. Open ``exact`` first.
"""
