"""Pieces of walls as B-spline surfaces whose boundary curves are the edges of the faces.

A piece extends from one stop to the other at every depth: u along the turn, v from the rib's top to
the floor, both from 0 to 1. It is interpolated on a grid that is refined until the surface is
within the tolerance of the wall midway between the grid lines. The lines of depth are the same for
all pieces, so that neighbours share the curve between them to the bit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline, NdBSpline, make_interp_spline

from synthesis.machines.spatial.solid.sheets import NotSmooth, Piece, TooFewDepths, WallSheets
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

CUBIC = 3
STEP = 5.0 * DEGREE  # between lines of the first grid
MAX_LINES = 1025  # of a grid along the turn


@dataclass(frozen=True, eq=False)
class Patch:
    """A piece of a wall.

    Attributes:
        surface: over u and v in [0, 1]. error: measured distance from the wall [mm].
    """

    surface: NdBSpline
    error: float

    def along(self, level: int) -> BSpline:
        """Its edge at the rib's top (0) or at the floor (−1), over u."""
        return BSpline(self.surface.t[0], self.surface.c[:, level], CUBIC)

    def down(self, end: int) -> BSpline:
        """Its edge at its start (0) or end (−1), over v."""
        return BSpline(self.surface.t[1], self.surface.c[end], CUBIC)


def fit_patch(sheets: WallSheets, piece: Piece, tolerance: float, stride: int) -> Patch:
    """A piece of a wall within a tolerance [mm].

    Args:
        stride: every so many depths of the blank are compared, and every other one of these is
            interpolated.

    Raises:
        TooCoarse: it takes more depths. NotSmooth: or too many lines along the turn.
    """
    first, last = piece.first.turn, piece.last.turn
    count = max(5, int(np.ceil(np.max(last - first) / STEP)) + 1)
    depth = sheets.blank.depth[::stride]
    v = (depth - depth[0]) / (depth[-1] - depth[0])
    while count <= MAX_LINES:
        u = np.linspace(0.0, 1.0, 2 * count - 1)
        true = _points(sheets, piece, u, stride)
        surface = _interpolate(u[::2], v[::2], true[::2, ::2])
        away = _deviation(surface, u, v, true)
        error = float(np.max(away))
        if error <= tolerance:
            return Patch(surface, error)
        if np.max(away[::2]) > tolerance:
            raise TooFewDepths(f"a wall is approximated to {np.max(away[::2]):.2g} mm only")
        count = 2 * count - 1
    raise NotSmooth(f"a wall is approximated to {error:.2g} mm only")


def cluster_at_ends(first: float, last: float, count: int) -> Array:
    """Depths clustered at both ends (Chebyshev spacing), where walls bend most."""
    return first + (last - first) * 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, count)))


def _deviation(surface: NdBSpline, u: Array, v: Array, true: Array) -> Array:
    """Distances from the wall: along its normal inside, in any direction on the edges."""
    places = np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1)
    off = surface(places) - true
    normal = np.cross(surface(places, nu=(1, 0)), surface(places, nu=(0, 1)))
    away = np.abs(np.sum(off * normal, axis=-1)) / np.linalg.norm(normal, axis=-1)
    whole = np.linalg.norm(off, axis=-1)
    away[:, [0, -1]], away[[0, -1]] = whole[:, [0, -1]], whole[[0, -1]]
    return np.asarray(away)


def _points(sheets: WallSheets, piece: Piece, u: Array, stride: int) -> Array:
    """Points (n, m, 3) of the wall in the cam's frame, at every so many depths [mm]."""
    first, last = piece.first.turn[::stride], piece.last.turn[::stride]
    turn = first + u[:, None] * (last - first)
    turn[-1] = last
    depth = np.broadcast_to(sheets.blank.depth[::stride], turn.shape)
    across = sheets.across(piece.wall, turn.ravel(), depth.ravel()).reshape(turn.shape)
    return np.moveaxis(sheets.points(turn, depth, across), 0, -1)


def _interpolate(u: Array, v: Array, points: Array) -> NdBSpline:
    by_u = make_interp_spline(u, points, k=CUBIC, axis=0)
    by_v = make_interp_spline(v, by_u.c, k=CUBIC, axis=1)
    return NdBSpline((by_u.t, by_v.t), np.moveaxis(by_v.c, 0, 1), CUBIC)
