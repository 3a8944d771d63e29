"""Rows of points in fixed decimals."""

from __future__ import annotations

from synthesis.exporters.options import PointOptions
from synthesis.numerics.piecewise import Array


def point_rows(points: Array, options: PointOptions, row: str, numbered: bool = False) -> bytes:
    """One row for each point (n, 2), in ASCII.

    Args:
        row: with {x}, {y} and {z} where these stand, and {n} for the number, from 1 on.
    """
    places = options.decimals
    z = round(options.z_mm or 0.0, places) + 0.0
    number = f"%.{places}f"
    pattern = row.format(n="%d", x=number, y=number, z=f"{z:.{places}f}")
    values = points.ravel().tolist()
    if numbered:
        values = [v for n, (x, y) in enumerate(points.tolist(), 1) for v in (n, x, y)]
    return (pattern * len(points) % tuple(values)).encode("ascii")
