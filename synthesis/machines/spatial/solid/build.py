"""The faces of a body: walls, tops and floors, sections at the blank's ends, and the hub."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import chain, groupby

import numpy as np
from scipy.interpolate import BSpline

from synthesis.machines.spatial.solid import geometry
from synthesis.machines.spatial.solid.geometry import Key, NotSmooth, Shell
from synthesis.machines.spatial.solid.sheets import (
    CUBIC,
    HIGH,
    IN,
    LOW,
    Piece,
    Stop,
    WallSheets,
    fit_patch,
)
from synthesis.numerics.piecewise import Array

BLANK_ENDS = (LOW, HIGH)
TOP, ROOT = LEVELS = 0, -1  # depths of the blank
STEP = 1e-4  # mm or rad: to a neighbouring point, for a direction out of the body


@dataclass(frozen=True, eq=False)
class Builder:
    """Builds the shell of a body.

    Attributes:
        sheets: its walls. tolerance: of its walls [mm]. stride: as in ``fit_patch``.
    """

    sheets: WallSheets
    tolerance: float
    stride: int
    shell: Shell = field(default_factory=Shell)
    errors: list[float] = field(default_factory=list)

    def build(self) -> Shell:
        """The closed shell.

        Raises:
            NotSmooth: the body has no boundary of this kind.
        """
        for j in range(self.sheets.sectors):
            # Walls first: their boundary curves are the edges of all other faces.
            for piece in chain(*self.sheets.pieces[j]):
                if piece.state == IN:
                    self._wall(piece)
            self._level(j, TOP)
            self._level(j, ROOT)
            self._sections(j)
        self._hub()
        self.shell.check()
        return self.shell

    # -- names --------------------------------------------------------------------------------

    def _stop(self, stop: Stop, wall: int | None) -> Key:
        """Key of a wall's end or a sector line; after a turn of the first line and shifted wall."""
        if stop.key[0] == "out":
            return stop.key
        j = int(str(stop.key[1]))
        if j < self.sheets.sectors:
            return ("line", j, wall)
        return ("line", 0, None if wall is None else wall + self.sheets.shift)

    def _corner(self, stop: Stop, piece: Piece | None, state: int, level: int) -> Key:
        """Key of the vertex of a region's bound at a stop: on a wall, or at the blank's end."""
        if stop.key[0] == "out":
            return (*stop.key, level)
        if state == IN:
            assert piece is not None
            return (*self._stop(stop, piece.wall), level)
        return (*self._stop(stop, None), "end", state, level)

    # -- edges --------------------------------------------------------------------------------

    def _wall(self, piece: Piece) -> None:
        surface, error = fit_patch(self.sheets, piece, self.tolerance, self.stride)
        self.errors.append(error)
        ends = [self._stop(stop, piece.wall) for stop in (piece.first, piece.last)]
        (along, down), points = surface.t, surface.c
        edges = [self.shell.join((piece, level), (*ends[0], level), (*ends[1], level),
                                 geometry.spline_curve(BSpline(along, points[:, level], CUBIC)))
                 for level in LEVELS]  # fmt: skip
        edges += [self.shell.join(("down", *end), (*end, TOP), (*end, ROOT),
                                  geometry.spline_curve(BSpline(down, points[k], CUBIC)))
                  for end, k in zip(ends, (0, -1), strict=True)]  # fmt: skip
        place = surface(np.array([0.5, 0.5]))
        out = self._across_direction(place) * (1.0 if piece.wall % 2 == 0 else -1.0)
        self.shell.add(geometry.spline_surface(surface), edges, place, out)

    def _across_direction(self, place: Array) -> Array:
        """Unit vector (3,) across the blank at a point (3,)."""
        x, y, z = place
        chart, turn = self.sheets.blank.chart, np.arctan2(y, x)
        depth, across = chart.from_meridian(np.hypot(x, y), z)
        low, high = (chart.points(turn, depth, across + off) for off in (-STEP, STEP))
        return np.asarray((high - low) / np.linalg.norm(high - low))

    def _end(self, end: int, level: int) -> tuple[float, float]:
        """Radius and height of an end of the blank at a level [mm]."""
        blank = self.sheets.blank
        radius, height = blank.chart.meridian(blank.depth[level], self.sheets.end(end)[level])
        return float(radius), float(height)

    def _border(self, first: Stop, last: Stop, end: int, level: int) -> Key:
        """The edge of a region along an end of the blank: an arc about the axis."""
        start, stop = (self._corner(each, None, end, level) for each in (first, last))
        radius, height = self._end(end, level)
        y = np.array([0.0, -float(self.sheets.hand), 0.0])
        turn = float(first.turn[level]), float(last.turn[level])
        curve = geometry.circle(height * geometry.UP, geometry.X, y, radius, *turn)
        return self.shell.join(("arc", end, level, start, stop), start, stop, curve)

    def _lift(self, stop: Stop, span: Span, level: int) -> list[Key]:
        """The edge across the body at a sector line; none where the span ends in a point."""
        if stop.key[0] == "out":
            return []
        low, high = span.states
        first = self._corner(stop, span.low, low, level)
        last = self._corner(stop, span.high, high, level)
        # Corners on walls exist already.
        start, end = (
            self._place(key) if state == IN else float(self.sheets.end(state)[level])
            for key, state in ((first, low), (last, high))
        )
        chart, depth = self.sheets.blank.chart, float(self.sheets.blank.depth[level])
        angle = -self.sheets.hand * float(stop.turn[level])
        ring = chart.torus_radii(depth)
        curve: geometry.Curve
        if ring is None:
            ends = (chart.points(np.array(angle), np.array(depth), np.array(at))
                    for at in (start, end))  # fmt: skip
            curve = geometry.line(*ends)
        else:
            away = np.array([np.cos(angle), np.sin(angle), 0.0])
            curve = geometry.circle(ring[0] * away, -away, geometry.UP, ring[1], start, end)
        return [self.shell.join(("lift", first, last), first, last, curve)]

    def _place(self, corner: Key) -> float:
        """Place across of a vertex."""
        x, y, z = self.shell.vertices[corner]
        return float(self.sheets.blank.chart.from_meridian(np.hypot(x, y), z)[1])

    # -- regions ------------------------------------------------------------------------------

    def _level(self, j: int, level: int) -> None:
        for low, high in pairs(self.sheets, level):
            for run in runs(spans(self.sheets, j, low, high, level)):
                self._region(run, level)

    def _region(self, run: list[Span], level: int) -> None:
        edges = self._lift(run[0].first, run[0], level) + self._lift(run[-1].last, run[-1], level)
        for k in (0, 1):
            for piece, state, first, last in bounds(run, k):
                if state == IN:
                    edges.append((piece, level))
                else:
                    edges.append(self._border(first, last, state, level))
        turn = np.array(0.5 * (run[0].first.turn[level] + run[-1].last.turn[level]))
        corners = {key for edge in edges for key in self.shell.edges[edge][:2]}
        across = np.array(np.mean([self._place(key) for key in corners]))
        chart, depth = self.sheets.blank.chart, float(self.sheets.blank.depth[level])
        place, deeper = (
            self.sheets.points(turn, np.array(d), across) for d in (depth, depth + STEP)
        )
        # The turned surface of one depth is a torus or a cylinder.
        ring, (radius, _) = chart.torus_radii(depth), chart.meridian(np.array(depth), np.array(0.0))
        surface = geometry.cylinder(float(radius)) if ring is None else geometry.torus(*ring)
        self.shell.add(surface, edges, place, (place - deeper) / STEP)

    # -- ends ---------------------------------------------------------------------------------

    def _sections(self, j: int) -> None:
        """Sections of ribs by the blank's ends."""
        for low, high in pairs(self.sheets, TOP):
            tops, roots = (list(spans(self.sheets, j, low, high, level)) for level in LEVELS)
            if [(s.low, s.high) for s in tops] != [(s.low, s.high) for s in roots]:
                raise NotSmooth("a rib's end changes its order from top to floor")
            for run in runs(tops):
                for k, end in enumerate(BLANK_ENDS):
                    for _, state, first, last in bounds(run, k):
                        if state == end:
                            self._section(first, last, end)

    def _section(self, first: Stop, last: Stop, end: int) -> None:
        edges = [self._border(first, last, end, level) for level in LEVELS]
        for stop in (first, last):
            if stop.key[0] == "out":
                edges.append(("down", *stop.key))
                continue
            top, root = (self._corner(stop, None, end, level) for level in LEVELS)
            angle = -self.sheets.hand * float(stop.turn[0])
            away = np.array([np.cos(angle), np.sin(angle), 0.0])
            ends = (r * away + z * geometry.UP for r, z in (self._end(end, k) for k in LEVELS))
            edges.append(self.shell.join(("edge", top, root), top, root, geometry.line(*ends)))
        middle = len(first.turn) // 2
        turn = np.array(0.5 * float(first.turn[middle] + last.turn[middle]))
        depth, across = self.sheets.blank.depth[middle], self.sheets.end(end)[middle]
        place = self.sheets.points(turn, depth, across)
        out = end * self._across_direction(place)
        # A section is a plane, a cylinder or a cone about the axis.
        (r0, z0), (r1, z1) = self._end(end, TOP), self._end(end, ROOT)
        surface = geometry.cone(z0, r0, (r1 - r0) / (z1 - z0 or np.inf))
        if abs(z1 - z0) < 1e-9 * abs(r1 - r0):
            surface = geometry.plane(z0, int(np.sign(out[2])))
        elif abs(r1 - r0) < 1e-9 * abs(z1 - z0):
            surface = geometry.cylinder(r0)
        self.shell.add(surface, edges, place, out)

    def _hub(self) -> None:
        bore = self.sheets.blank.bore
        for end in BLANK_ENDS:
            radius, height = self._end(end, ROOT)
            edges = [key for key in self.shell.edges if key[:3] == ("arc", end, ROOT)]
            holes = [self._bore(end)] if bore else []
            out = end * geometry.UP
            place = np.array([radius, 0.0, height])
            self.shell.add(geometry.plane(height, end), edges, place, out, holes)
        if not bore:
            return
        heights = [self._end(end, ROOT)[1] for end in BLANK_ENDS]
        for half in (0, 1):
            sides = []
            for k in (0, 1):
                at = np.array([bore * (1.0 - 2.0 * k), 0.0, 0.0])
                ends = [at + z * geometry.UP for z in heights]
                sides.append(self.shell.join(("bore", k), ("bore", LOW, k), ("bore", HIGH, k),
                                             geometry.line(*ends)))  # fmt: skip
            rims = [("bore", end, "half", half) for end in BLANK_ENDS]
            place = np.array([0.0, bore * (1.0 - 2.0 * half), 0.5 * sum(heights)])
            out = -np.array([0.0, place[1], 0.0])
            self.shell.add(geometry.cylinder(bore), [*sides, *rims], place, out)

    def _bore(self, end: int) -> list[Key]:
        centre, radius = self._end(end, ROOT)[1] * geometry.UP, self.sheets.blank.bore
        y = np.array([0.0, 1.0, 0.0])
        halves = (
            geometry.circle(centre, geometry.X, y, radius, half * np.pi, (half + 1) * np.pi)
            for half in (0, 1)
        )
        return [
            self.shell.join(("bore", end, "half", k), ("bore", end, k), ("bore", end, 1 - k), curve)
            for k, curve in enumerate(halves)
        ]


@dataclass(frozen=True, eq=False)
class Span:
    """A part of a region in which neither bound enters or leaves the blank.

    Attributes:
        low, high: the pieces that bound it; None: it extends to the blank's end.
        first, last: its ends along the turn.
    """

    low: Piece | None
    high: Piece | None
    first: Stop
    last: Stop

    @property
    def states(self) -> tuple[int, int]:
        low = LOW if self.low is None else self.low.state
        return low, HIGH if self.high is None else self.high.state

    @property
    def open(self) -> bool:
        """Whether the region has an area here."""
        low, high = self.states
        return low != HIGH and high != LOW


def pairs(sheets: WallSheets, level: int) -> Iterator[tuple[int, int]]:
    """Pairs of walls that bound regions: rib tops at TOP, groove floors at ROOT."""
    count = len(sheets.states)
    if level == TOP:
        return ((k - 1, k) for k in range(0, count + 1, 2))
    return ((k, k + 1) for k in range(0, count, 2))


def spans(sheets: WallSheets, j: int, low: int, high: int, level: int) -> Iterator[Span]:
    """The spans between two walls in a sector, cut where either enters or leaves the blank."""
    # Below the first wall and above the last there are no pieces.
    lows, highs = (
        [*sheets.pieces[j][wall]] if 0 <= wall < len(sheets.states) else [None]
        for wall in (low, high)
    )
    first, end = sheets.line(j), sheets.line(j + 1)
    a = b = 0
    while True:
        here = [piece.last for piece in (lows[a], highs[b]) if piece is not None]
        stops = [stop for stop in here if stop.key[0] == "out"]
        last = min(stops, key=lambda stop: float(stop.turn[level]), default=end)
        yield Span(lows[a], highs[b], first, last)
        if last is end:
            return
        low_ends, high_ends = (p is not None and p.last is last for p in (lows[a], highs[b]))
        first, a, b = last, a + low_ends, b + high_ends


def runs(spans: Iterable[Span]) -> Iterator[list[Span]]:
    """Runs of neighbouring open spans."""
    return (list(run) for there, run in groupby(spans, lambda span: span.open) if there)


def bounds(run: Iterable[Span], k: int) -> Iterator[tuple[Piece | None, int, Stop, Stop]]:
    """The pieces that bound a run below (0) or above (1), with their states and ends."""
    for _, spans in groupby(run, lambda span: id((span.low, span.high)[k])):
        all_ = list(spans)
        piece = (all_[0].low, all_[0].high)[k]
        yield piece, all_[0].states[k], all_[0].first, all_[-1].last
