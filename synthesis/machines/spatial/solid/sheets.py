"""The walls of a body in sectors: where they lie, and where they leave the blank.

A sector lies between two lines, half-planes through the cam's axis at which no wall crosses an end
of the blank. Walls are numbered across the blank: 2g and 2g + 1 are those of groove g. Along a
sector a wall is a sequence of pieces, each below the blank, in it, or above it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import elementwise

from synthesis.machines.spatial.blank import Blank
from synthesis.machines.spatial.grooves import GrooveSections
from synthesis.machines.spatial.machine import LEFT, RIGHT, Seat
from synthesis.numerics.piecewise import Array
from synthesis.units import FULL_TURN

ROWS = 360  # at which walls are sampled
PREFERRED = 60  # rows of a sector, where there is a line to end it
WIDEST = 300  # rows of a sector: closed faces around the axis are not made
PAD = 2  # rows between a line and a wall's exit from the blank
LEVELS = 5  # depths at which walls are sampled
MAX_STEP = 0.3  # rad: between exits of a wall at neighbouring depths
LOW, IN, HIGH = -1, 0, 1
TURNS = FULL_TURN * np.arange(2 * ROWS) / ROWS  # of the rows over two turns [rad]


class NotSmooth(Exception):
    """The body has no smooth boundary; the message says why."""


class TooFewDepths(NotSmooth):
    """A finer grid in depth may help."""


@dataclass(frozen=True, eq=False)
class Stop:
    """The end of a wall's piece: at a sector line, or at an end of the blank.

    Attributes:
        key: its name. turn: (m,) cam angle of the row, at every depth of the blank [rad].
    """

    key: tuple[object, ...]
    turn: Array


@dataclass(frozen=True, eq=False)
class Piece:
    """A wall between two stops, with its state: LOW, IN or HIGH."""

    wall: int
    state: int
    first: Stop
    last: Stop


@dataclass(frozen=True, eq=False)
class WallStates:
    """Sampled states of the walls.

    Attributes:
        states: (walls, rows of two turns, depths): LOW, IN or HIGH.
        shift: wall w after a turn is wall w + shift.
    """

    states: NDArray[np.int64]
    shift: int

    @classmethod
    def of(cls, cuts: GrooveSections, blank: Blank) -> WallStates:
        """The states at some depths of a blank.

        Raises:
            NotSmooth: a rib or groove has no width somewhere.
            InputError: as ``GrooveSections.grooves``.
        """
        picks = np.linspace(0, len(blank.depth) - 1, LEVELS).round().astype(int)
        found = cuts.grooves(TURNS[:ROWS], blank.depth[picks])
        walls = np.stack([found.low, found.high], axis=1).reshape(-1, ROWS, LEVELS)
        low, high = blank.low[picks], blank.high[picks]
        states = np.where(walls <= low, LOW, np.where(walls >= high, HIGH, IN))
        inside = (states[1:] != LOW) & (states[:-1] != HIGH)
        if np.any(inside & (np.clip(walls[1:], low, high) <= np.clip(walls[:-1], low, high))):
            raise NotSmooth("a rib ends where the grooves beside it meet")
        shift = 2 * found.shift
        after = np.full_like(states, HIGH if shift > 0 else LOW)
        for i in range(max(0, -shift), min(len(states), len(states) - shift)):
            after[i] = states[i + shift]
        return cls(np.concatenate([states, after], axis=1), shift)


@dataclass(frozen=True, eq=False)
class WallSheets:
    """All walls of a body.

    Attributes:
        cuts, blank: of the cam. seen: states of its walls.
    """

    cuts: GrooveSections
    blank: Blank
    seen: WallStates

    @cached_property
    def seats(self) -> list[Seat]:
        """The rollers of the grooves, in order."""
        return self.cuts.seats()

    @property
    def states(self) -> NDArray[np.int64]:
        """As in ``WallStates``."""
        return self.seen.states

    @property
    def shift(self) -> int:
        """As in ``WallStates``."""
        return self.seen.shift

    @cached_property
    def lines(self) -> list[int]:
        """Rows at which sectors start, and the end of the last one.

        Raises:
            NotSmooth: walls leave the blank all around.
        """
        states = self.states[:, :ROWS]
        mixed = np.any(states != states[:, :, :1], axis=(0, 2))
        changed = np.any(states != np.roll(states, 1, axis=1), axis=(0, 2))
        if self.shift:  # at the seam compare with the shifted walls of the next turn
            later = self.states[:, ROWS : ROWS + 1]
            changed[0] = bool(np.any(self.states[:, ROWS - 1 : ROWS] != later))
        busy = mixed | changed
        for _ in range(PAD):
            busy = busy | np.roll(busy, 1) | np.roll(busy, -1)
        free = np.flatnonzero(~busy)
        if len(free) == 0:
            raise NotSmooth("walls leave the blank all around the cam")
        first = int(free[0])
        after = np.concatenate([free, [first + ROWS]])
        found = [first]
        while found[-1] < first + ROWS:
            ahead = after[after > found[-1]]
            near = ahead[ahead <= found[-1] + PREFERRED]
            found.append(int(near[-1] if len(near) else ahead[0]))
            if found[-1] - found[-2] > WIDEST:
                raise NotSmooth("walls leave the blank nearly all around the cam")
        return found

    @property
    def sectors(self) -> int:
        """Number of sectors."""
        return len(self.lines) - 1

    def line(self, j: int) -> Stop:
        """A sector line; after a turn, the first one again."""
        at = FULL_TURN * self.lines[j] / ROWS
        return Stop(("line", j), np.full(len(self.blank.depth), at))

    @cached_property
    def pieces(self) -> list[list[list[Piece]]]:
        """By sector and wall, in order along the turn."""
        return [
            [list(self._pieces(j, wall)) for wall in range(len(self.states))]
            for j in range(self.sectors)
        ]

    def _pieces(self, j: int, wall: int) -> Iterator[Piece]:
        first, last = self.lines[j], self.lines[j + 1]
        states = self.states[wall, first : last + 1]
        runs = [_runs(states[:, k]) for k in range(LEVELS)]
        names = [run[0] for run in runs]
        if any(each != names[0] for each in names):
            raise NotSmooth("a wall leaves the blank and comes back at some depths only")
        stops = [self.line(j)]
        for k, (a, b) in enumerate(pairwise(names[0])):
            rows = [run[1][k] for run in runs]
            bracket = TURNS[first + min(rows) - 1], TURNS[first + max(rows)]
            end = LOW if LOW in (a, b) else HIGH
            if IN not in (a, b):
                raise NotSmooth("a wall crosses the whole blank at once")
            stops.append(Stop(("out", j, wall, k), self._feasible_root(wall, end, bracket)))
        stops.append(self.line(j + 1))
        for state, (start, stop) in zip(names[0], pairwise(stops), strict=True):
            yield Piece(wall, state, start, stop)

    def _feasible_root(self, wall: int, end: int, bracket: tuple[float, float]) -> Array:
        """Cam angle at which a wall crosses an end of the blank, at every depth [rad]."""
        edge = self.blank.low if end == LOW else self.blank.high
        depth = self.blank.depth

        def off(turn: Array, index: Array) -> Array:
            i = index.astype(int)
            return np.asarray(self.across(wall, turn, depth[i]) - edge[i])

        index = np.arange(len(depth)).astype(float)
        room = FULL_TURN / ROWS
        ends = (np.full(len(depth), bracket[0] - room), np.full(len(depth), bracket[1] + room))
        found = elementwise.find_root(off, ends, args=(index,), tolerances={"xatol": 1e-13})
        if not np.all(found.success):
            raise NotSmooth("the exit of a wall from the blank was not found")
        if np.max(np.abs(np.diff(found.x))) > MAX_STEP:
            raise NotSmooth("a wall follows the end of the blank")
        return np.asarray(found.x)

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
        found, sound = self.cuts.walls(seat, (LEFT, RIGHT)[wall % 2], turn, depth)
        if not (np.all(sound) and np.all(np.isfinite(found))):
            raise NotSmooth("below the rollers' ends a wall is not regular")
        return found


def _runs(states: NDArray[np.int64]) -> tuple[list[int], list[int]]:
    """Run-length encoding: the states, and the rows at which each but the first starts."""
    changes = np.flatnonzero(np.diff(states)) + 1
    return [int(states[0]), *(int(states[i]) for i in changes)], changes.tolist()
