"""The walls of a body in sectors: where they lie and leave the blank, and B-splines through them.

A sector lies between two lines, half-planes through the cam's axis at which no wall crosses an end
of the blank. Walls are numbered across the blank: 2g and 2g + 1 are those of groove g. Along a
sector a wall is a sequence of pieces, each below the blank, in it, or above it.

A piece in the blank becomes a B-spline surface whose boundary curves are the edges of the faces. It
extends from one stop to the other at every depth: u along the turn, v from the rib's top to the
floor, both from 0 to 1. It is interpolated on a grid that is refined until the surface is within
the tolerance of the wall midway between the grid lines. The lines of depth are the same for all
pieces, so that neighbours share the curve between them to the bit.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import NdBSpline
from scipy.optimize import elementwise

from synthesis.machines.spatial.body import Blank
from synthesis.machines.spatial.grooves import GrooveSections, shifted
from synthesis.machines.spatial.machine import LEFT, RIGHT, Seat
from synthesis.machines.spatial.solid.geometry import NotSmooth, interpolate_surface
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE, FULL_TURN

ROWS = 360  # at which walls are sampled
PREFERRED = 60  # rows of a sector, where there is a line to end it
WIDEST = 300  # rows of a sector: closed faces around the axis are not made
PAD = 2  # rows between a line and a wall's exit from the blank
LEVELS = 5  # depths at which walls are sampled
MAX_STEP = 0.3  # rad: between exits of a wall at neighbouring depths
CUBIC = 3  # degree of the splines
FIRST_STEP = 5.0 * DEGREE  # between lines of a piece's first grid
MAX_LINES = 1025  # of a grid along the turn
LOW, IN, HIGH = -1, 0, 1  # below, within and above the blank
TURNS = FULL_TURN * np.arange(2 * ROWS) / ROWS  # of the rows over two turns [rad]


class TooFewDepths(NotSmooth):
    """A finer grid in depth may help."""


@dataclass(frozen=True, eq=False)
class Stop:
    """The end of a wall's piece: at a sector line, or at an end of the blank.

    Attributes:
        key: its name, the same from either side. leaves: whether the wall leaves the blank there.
        turn: (m,) cam angle of the row, at every depth of the blank [rad].
    """

    key: tuple[object, ...]
    turn: Array
    leaves: bool = False


@dataclass(frozen=True, eq=False)
class Piece:
    """A wall between two stops along the turn, with its state: LOW, IN or HIGH."""

    wall: int
    state: int
    ends: tuple[Stop, Stop]


@dataclass(frozen=True, eq=False)
class WallSheets:
    """All walls of a body; wall w after a turn is wall w + shift.

    ``states`` are (walls, rows of two turns, depths) at samples: LOW, IN or HIGH.
    """

    cuts: GrooveSections
    blank: Blank
    states: NDArray[np.int64]
    shift: int

    @classmethod
    def of(cls, cuts: GrooveSections, blank: Blank) -> WallSheets:
        """The walls with their states at some depths of the blank.

        Raises:
            NotSmooth: a rib or groove has no width somewhere.
            InputError: as ``GrooveSections.grooves``.
        """
        picks = np.linspace(0, len(blank.depth) - 1, LEVELS).round().astype(int)
        grooves, shift = cuts.grooves(TURNS[:ROWS], blank.depth[picks])
        walls = np.swapaxes(grooves, 0, 1).reshape(-1, ROWS, LEVELS)
        low, high = blank.low[picks], blank.high[picks]
        states = np.where(walls <= low, LOW, np.where(walls >= high, HIGH, IN))
        inside = (states[1:] != LOW) & (states[:-1] != HIGH)
        if np.any(inside & (np.clip(walls[1:], low, high) <= np.clip(walls[:-1], low, high))):
            raise NotSmooth("a rib ends where the grooves beside it meet")
        after = shifted(states, 2 * shift, HIGH if shift > 0 else LOW)
        return cls(cuts, blank, np.concatenate([states, after], axis=1), 2 * shift)

    @cached_property
    def seats(self) -> list[Seat]:
        """The rollers of the grooves, in order."""
        return self.cuts.seats()

    @cached_property
    def lines(self) -> list[int]:
        """Rows at which sectors start, and the end of the last one.

        Raises:
            NotSmooth: walls leave the blank all around.
        """
        # No line may lie near a row where some wall enters or leaves the blank at some depth.
        states, later = self.states[:, :ROWS], self.states[:, 1 : ROWS + 1]
        mixed = np.any(states != states[:, :, :1], axis=(0, 2))
        busy = mixed | np.roll(np.any(states != later, axis=(0, 2)), 1)
        for _ in range(PAD):
            busy = busy | np.roll(busy, 1) | np.roll(busy, -1)
        free = np.flatnonzero(~busy)
        if len(free) == 0:
            raise NotSmooth("walls leave the blank all around the cam")
        # From one free row to the farthest that is not too far ahead, around the cam.
        first = int(free[0])
        after = np.concatenate([free, [first + ROWS]])
        rows = [first]
        while rows[-1] < first + ROWS:
            ahead = after[after > rows[-1]]
            near = ahead[ahead <= rows[-1] + PREFERRED]
            rows.append(int(near[-1] if len(near) else ahead[0]))
            if rows[-1] - rows[-2] > WIDEST:
                raise NotSmooth("walls leave the blank nearly all around the cam")
        return rows

    def line(self, j: int, wall: int | None = None) -> Stop:
        """A wall's end at a sector line, or a place on no wall there."""
        key: tuple[object, ...] = "line", j, wall
        if j == len(self.lines) - 1:  # after a turn it is the first line, of the shifted wall
            key = "line", 0, None if wall is None else wall + self.shift
        return Stop(key, np.full(len(self.blank.depth), FULL_TURN * self.lines[j] / ROWS))

    @cached_property
    def pieces(self) -> list[list[list[Piece]]]:
        """By sector and wall, in order along the turn."""
        return [
            [list(self._pieces(j, wall)) for wall in range(len(self.states))]
            for j in range(len(self.lines) - 1)
        ]

    def _pieces(self, j: int, wall: int) -> Iterator[Piece]:
        # At every sampled depth the wall passes through the same states in the same order.
        first, last = self.lines[j], self.lines[j + 1]
        states = self.states[wall, first : last + 1]
        starts = [(np.flatnonzero(np.diff(column)) + 1).tolist() for column in states.T]
        names = [
            [int(column[row]) for row in (0, *rows)]
            for column, rows in zip(states.T, starts, strict=True)
        ]
        if any(each != names[0] for each in names):
            raise NotSmooth("a wall leaves the blank and comes back at some depths only")
        # Between two states it crosses an end of the blank, at each depth at a row of its own.
        stops = [self.line(j, wall)]
        for k, (a, b) in enumerate(pairwise(names[0])):
            rows = [each[k] for each in starts]
            bracket = TURNS[first + min(rows) - 1], TURNS[first + max(rows)]
            end = LOW if LOW in (a, b) else HIGH
            if IN not in (a, b):
                raise NotSmooth("a wall crosses the whole blank at once")
            stops.append(Stop(("out", j, wall, k), self._crossing(wall, end, bracket), True))
        stops.append(self.line(j + 1, wall))
        for state, ends in zip(names[0], pairwise(stops), strict=True):
            yield Piece(wall, state, ends)

    def _crossing(self, wall: int, end: int, bracket: tuple[float, float]) -> Array:
        """Cam angle at which a wall crosses an end of the blank, at every depth [rad]."""

        def off(turn: Array, *at: Array) -> Array:
            depth, edge = at
            return self.across(wall, turn, depth) - edge

        depth, room = self.blank.depth, FULL_TURN / ROWS
        ends = np.full(len(depth), bracket[0] - room), np.full(len(depth), bracket[1] + room)
        args = (depth, self.end(end))
        root = elementwise.find_root(off, ends, args=args, tolerances={"xatol": 1e-13})
        if not np.all(root.success):
            raise NotSmooth("the exit of a wall from the blank was not found")
        if np.max(np.abs(np.diff(root.x))) > MAX_STEP:
            raise NotSmooth("a wall follows the end of the blank")
        return np.asarray(root.x)

    def end(self, state: int) -> Array:
        """Places across (m,) of an end of the blank, LOW or HIGH."""
        return self.blank.low if state == LOW else self.blank.high

    def points(self, turn: Array, depth: Array, across: Array) -> Array:
        """Points (3, …) of the cam's frame [mm]."""
        return self.blank.chart.points(-self.hand * turn, depth, across)

    @property
    def hand(self) -> int:
        """χ of the cam: rows follow each other in the sense −hand about its axis."""
        return self.cuts.cam.swept.hand

    def across(self, wall: int, turn: Array, depth: Array) -> Array:
        """Places across of a wall at (n,) turns and depths.

        Raises:
            NotSmooth: there is no regular wall.
        """
        seat = self.seats[wall // 2]
        across, sound = self.cuts.walls(seat, (LEFT, RIGHT)[wall % 2], turn, depth)
        if not (np.all(sound) and np.all(np.isfinite(across))):
            raise NotSmooth("below the rollers' ends a wall is not regular")
        return across


def fit_patch(
    sheets: WallSheets, piece: Piece, tolerance: float, stride: int
) -> tuple[NdBSpline, float]:
    """A piece of a wall over u and v, and its measured distance from the wall [mm].

    At every ``stride``-th depth of the blank they are compared, every other of these is
    interpolated.

    Raises:
        TooFewDepths: it takes more depths. NotSmooth: or too many lines along the turn.
    """
    span = np.max(piece.ends[1].turn - piece.ends[0].turn)
    count = max(5, int(np.ceil(span / FIRST_STEP)) + 1)
    depth, (first, last) = sheets.blank.depth[::stride], (s.turn[::stride] for s in piece.ends)
    v = (depth - depth[0]) / (depth[-1] - depth[0])
    while count <= MAX_LINES:
        u = np.linspace(0.0, 1.0, 2 * count - 1)
        turn = first + u[:, None] * (last - first)
        turn[-1] = last
        at = np.broadcast_to(depth, turn.shape)
        across = sheets.across(piece.wall, turn.ravel(), at.ravel()).reshape(turn.shape)
        true = np.moveaxis(sheets.points(turn, at, across), 0, -1)
        surface = interpolate_surface(u[::2], v[::2], true[::2, ::2], (CUBIC, CUBIC))
        away = _deviation(surface, u, v, true)
        error = float(np.max(away))
        if error <= tolerance:
            return surface, error
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
