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
    """Builds the shell of a body from its walls, within a tolerance [mm]; see ``fit_patch``."""

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
        for j in range(len(self.sheets.pieces)):
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

    def _wall(self, piece: Piece) -> None:
        surface, error = fit_patch(self.sheets, piece, self.tolerance, self.stride)
        self.errors.append(error)
        ends = [stop.key for stop in piece.ends]
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
        start, stop = (_corner(each, end, level) for each in (first, last))
        radius, height = self._end(end, level)
        y = np.array([0.0, -float(self.sheets.hand), 0.0])
        turn = float(first.turn[level]), float(last.turn[level])
        curve = geometry.circle(height * geometry.UP, geometry.X, y, radius, *turn)
        return self.shell.join(("arc", end, level, start, stop), start, stop, curve)

    def _lift(self, span: Span, k: int, level: int) -> list[Key]:
        """The edge across the body at a sector line where a span starts (k = 0) or stops (1).

        None where it ends in a point.
        """
        stop = span.ends[k]
        if stop.leaves:
            return []
        first, last = (
            _corner(piece.ends[k] if piece and state == IN else stop, state, level)
            for piece, state in zip(span.walls, span.states, strict=True)
        )
        # Corners on walls exist already.
        start, end = (
            self._place(key) if state == IN else float(self.sheets.end(state)[level])
            for key, state in zip((first, last), span.states, strict=True)
        )
        blank, turn = self.sheets.blank, stop.turn[level]
        ring, away = blank.chart.torus_radii(blank.depth[level]), self._away(stop)
        if ring is None:
            ends = (self.sheets.points(turn, blank.depth[level], np.array(at))
                    for at in (start, end))  # fmt: skip
            curve = geometry.line(*ends)
        else:
            curve = geometry.circle(ring[0] * away, -away, geometry.UP, ring[1], start, end)
        return [self.shell.join(("lift", first, last), first, last, curve)]

    def _away(self, line: Stop) -> Array:
        """Unit vector (3,) away from the cam's axis at a sector line."""
        angle = -self.sheets.hand * float(line.turn[0])
        return np.array([np.cos(angle), np.sin(angle), 0.0])

    def _place(self, corner: Key) -> float:
        """Place across of a vertex."""
        x, y, z = self.shell.vertices[corner]
        return float(self.sheets.blank.chart.from_meridian(np.hypot(x, y), z)[1])

    def _level(self, j: int, level: int) -> None:
        for low, high in pairs(self.sheets, level):
            for run in runs(spans(self.sheets, j, low, high, level)):
                self._region(run, level)

    def _region(self, run: list[Span], level: int) -> None:
        edges = self._lift(run[0], 0, level) + self._lift(run[-1], 1, level)
        for k in (0, 1):
            for piece, state, first, last in bounds(run, k):
                if state == IN:
                    edges.append((piece, level))
                else:
                    edges.append(self._border(first, last, state, level))
        turn = np.array(0.5 * (run[0].ends[0].turn[level] + run[-1].ends[1].turn[level]))
        corners = {key for edge in edges for key in self.shell.edges[edge][:2]}
        across = np.array(np.mean([self._place(key) for key in corners]))
        depth = self.sheets.blank.depth[level]
        place, deeper = (self.sheets.points(turn, at, across) for at in (depth, depth + STEP))
        # The turned surface of one depth is a torus or a cylinder.
        ring, (radius, _) = self.sheets.blank.chart.torus_radii(depth), self._end(LOW, level)
        surface = geometry.cylinder(radius) if ring is None else geometry.torus(*ring)
        self.shell.add(surface, edges, place, (place - deeper) / STEP)

    def _sections(self, j: int) -> None:
        """Sections of ribs by the blank's ends."""
        for low, high in pairs(self.sheets, TOP):
            tops, roots = (list(spans(self.sheets, j, low, high, level)) for level in LEVELS)
            if [span.walls for span in tops] != [span.walls for span in roots]:
                raise NotSmooth("a rib's end changes its order from top to floor")
            for run in runs(tops):
                for k, end in enumerate(BLANK_ENDS):
                    for _, state, first, last in bounds(run, k):
                        if state == end:
                            self._section(first, last, end)

    def _section(self, first: Stop, last: Stop, end: int) -> None:
        edges = [self._border(first, last, end, level) for level in LEVELS]
        for stop in (first, last):
            if stop.leaves:
                edges.append(("down", *stop.key))
                continue
            top, root = (_corner(stop, end, level) for level in LEVELS)
            away, sides = self._away(stop), (self._end(end, level) for level in LEVELS)
            ends = (radius * away + height * geometry.UP for radius, height in sides)
            edges.append(self.shell.join(("edge", top, root), top, root, geometry.line(*ends)))
        middle = len(first.turn) // 2
        turn = np.array(0.5 * float(first.turn[middle] + last.turn[middle]))
        depth, across = self.sheets.blank.depth[middle], self.sheets.end(end)[middle]
        place = self.sheets.points(turn, depth, across)
        out = end * self._across_direction(place)
        surface = geometry.cone(self._end(end, TOP), self._end(end, ROOT), out)
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


def _corner(stop: Stop, state: int, level: int) -> Key:
    """Key of the vertex of a region's bound at a stop: on a wall, or at the blank's end."""
    return (*stop.key, level) if stop.leaves or state == IN else (*stop.key, state, level)


@dataclass(frozen=True, eq=False)
class Span:
    """A part of a region between two stops in which no bound enters or leaves the blank.

    ``walls`` are the pieces that bound it below and above; None: it extends to the blank's end.
    """

    walls: tuple[Piece | None, Piece | None]
    ends: tuple[Stop, Stop]

    @property
    def states(self) -> tuple[int, int]:
        low, high = self.walls
        return low.state if low else LOW, high.state if high else HIGH

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
        walls = lows[a], highs[b]
        stops = [piece.ends[1] for piece in walls if piece and piece.ends[1].leaves]
        last = min(stops, key=lambda stop: float(stop.turn[level]), default=end)
        yield Span(walls, (first, last))
        if last is end:
            return
        low_ends, high_ends = (piece is not None and piece.ends[1] is last for piece in walls)
        first, a, b = last, a + low_ends, b + high_ends


def runs(spans: Iterable[Span]) -> Iterator[list[Span]]:
    """Runs of neighbouring open spans."""
    return (list(run) for there, run in groupby(spans, lambda span: span.open) if there)


def bounds(run: Iterable[Span], k: int) -> Iterator[tuple[Piece | None, int, Stop, Stop]]:
    """The pieces that bound a run below (0) or above (1), with their states and ends."""
    for piece, group in groupby(run, lambda span: span.walls[k]):
        spans = list(group)
        yield piece, spans[0].states[k], spans[0].ends[0], spans[-1].ends[1]
