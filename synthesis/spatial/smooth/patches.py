"""Pieces of walls as B-spline surfaces whose own edges are the pieces' edges.

A piece runs from one stop to the other at every depth: u along the turn, v down from the rib's top
to the floor, both from 0 to 1. It is interpolated on a grid that gets finer until it is near enough
to the wall midway between the grid's lines. The lines of depth are the same for all pieces, so that
neighbours share the curve between them to the last bit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline, NdBSpline, make_interp_spline

from synthesis.numerics.piecewise import Array
from synthesis.spatial.smooth.sheets import NotSmooth, Piece, Sheets, TooCoarse
from synthesis.units import DEGREE

CUBIC = 3
STEP = 5.0 * DEGREE  # between lines of a grid, to begin with
MOST = 1025  # lines of a grid


@dataclass(frozen=True, eq=False)
class Patch:
    """A piece of a wall.

    Attributes:
        surface: over u and v in [0, 1]. error: seen distance from the wall [mm].
    """

    surface: NdBSpline
    error: float

    def along(self, level: int) -> BSpline:
        """Its edge at the rib's top (0) or at the floor (−1), over u."""
        return BSpline(self.surface.t[0], self.surface.c[:, level], CUBIC)

    def down(self, end: int) -> BSpline:
        """Its edge where it begins (0) or ends (−1), over v."""
        return BSpline(self.surface.t[1], self.surface.c[end], CUBIC)


def patch_of(sheets: Sheets, piece: Piece, tolerance: float, stride: int) -> Patch:
    """A piece of a wall within a tolerance [mm].

    Args:
        stride: every so many depths of the blank are looked at, and every other one of these is
            interpolated.

    Raises:
        TooCoarse: it takes more depths. NotSmooth: or too many lines along the turn.
    """
    first, last = piece.first.turn, piece.last.turn
    count = max(5, int(np.ceil(np.max(last - first) / STEP)) + 1)
    depth = sheets.blank.depth[::stride]
    v = (depth - depth[0]) / (depth[-1] - depth[0])
    while count <= MOST:
        u = np.linspace(0.0, 1.0, 2 * count - 1)
        true = _points(sheets, piece, u, stride)
        surface = _interpolated(u[::2], v[::2], true[::2, ::2])
        away = _away(surface, u, v, true)
        error = float(np.max(away))
        if error <= tolerance:
            return Patch(surface, error)
        if np.max(away[::2]) > tolerance:
            raise TooCoarse(f"a wall comes to {np.max(away[::2]):.2g} mm only")
        count = 2 * count - 1
    raise NotSmooth(f"a wall comes to {error:.2g} mm only")


def crowded(first: float, last: float, count: int) -> Array:
    """Depths that crowd towards both ends, where walls bend most."""
    return first + (last - first) * 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, count)))


def _away(surface: NdBSpline, u: Array, v: Array, true: Array) -> Array:
    """Distances from the wall: across it, and on the edges any way."""
    places = np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1)
    off = surface(places) - true
    normal = np.cross(surface(places, nu=(1, 0)), surface(places, nu=(0, 1)))
    away = np.abs(np.sum(off * normal, axis=-1)) / np.linalg.norm(normal, axis=-1)
    whole = np.linalg.norm(off, axis=-1)
    away[:, [0, -1]], away[[0, -1]] = whole[:, [0, -1]], whole[[0, -1]]
    return np.asarray(away)


def _points(sheets: Sheets, piece: Piece, u: Array, stride: int) -> Array:
    """(n, m, 3) of the cam's frame at every so many depths of the blank [mm]."""
    first, last = piece.first.turn[::stride], piece.last.turn[::stride]
    turn = first + u[:, None] * (last - first)
    turn[-1] = last
    depth = np.broadcast_to(sheets.blank.depth[::stride], turn.shape)
    across = sheets.across(piece.wall, turn.ravel(), depth.ravel()).reshape(turn.shape)
    return np.moveaxis(sheets.points(turn, depth, across), 0, -1)


def _interpolated(u: Array, v: Array, points: Array) -> NdBSpline:
    by_u = make_interp_spline(u, points, k=CUBIC, axis=0)
    by_v = make_interp_spline(v, by_u.c, k=CUBIC, axis=1)
    return NdBSpline((by_u.t, by_v.t), np.moveaxis(by_v.c, 0, 1), CUBIC)
