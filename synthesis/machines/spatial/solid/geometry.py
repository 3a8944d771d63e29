"""A boundary representation: curves, surfaces, a closed shell of faces, and their STEP files.

Each edge of a shell is between two of its faces, which lie on the body's true surfaces. At the
ribs' tops and at the floor, the turned surface is divided into regions by the walls' edges and the
blank's ends. Between the two levels are the walls and, at the blank's ends, sections of ribs. A hub
closes the shell.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import BSpline, NdBSpline, make_interp_spline

from synthesis.exporters.curves.step import Entities, many, real
from synthesis.numerics.piecewise import Array

X, UP, ACROSS = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 0.0]])
Key = tuple[object, ...]
Run = tuple[Key, bool]  # an edge, and whether it is traversed in its own direction
SHARES = np.linspace(0.0, 1.0, 33)[:-1]  # of an edge, whose points give a loop's area
FLAG = {True: ".T.", False: ".F."}


class NotSmooth(Exception):
    """The body has no smooth boundary; the message says why."""


class Curve(ABC):
    """A curve from one vertex to another."""

    @abstractmethod
    def points(self, share: Array) -> Array:
        """Points (n, 3) at shares from 0 to 1 [mm]."""

    @abstractmethod
    def to_step(self, data: Entities) -> str:
        """Writes its STEP entity, with the same direction; returns the reference."""


@dataclass(frozen=True, eq=False)
class Circle(Curve):
    """centre + radius (x cos φ + y sin φ), φ from ``start`` to a larger ``end`` [rad]."""

    centre: Array
    x: Array
    y: Array
    radius: float
    start: float
    end: float

    def points(self, share: Array) -> Array:
        at = (self.start + share * (self.end - self.start))[:, None]
        return self.centre + self.radius * (np.cos(at) * self.x + np.sin(at) * self.y)

    def to_step(self, data: Entities) -> str:
        placed = placement(data, self.centre, np.cross(self.x, self.y), self.x)
        return data.add("CIRCLE", "''", placed, real(self.radius))


@dataclass(frozen=True, eq=False)
class Line(Curve):
    """A straight line."""

    first: Array
    last: Array

    def points(self, share: Array) -> Array:
        return self.first + share[:, None] * (self.last - self.first)

    def to_step(self, data: Entities) -> str:
        way = self.last - self.first
        length = float(np.linalg.norm(way))
        vector = data.add("VECTOR", "''", direction(data, way / length), real(1.0))
        return data.add("LINE", "''", point(data, self.first), vector)


@dataclass(frozen=True, eq=False)
class SplineCurve(Curve):
    """A B-spline over [0, 1]."""

    spline: BSpline

    def points(self, share: Array) -> Array:
        return np.asarray(self.spline(share))

    def to_step(self, data: Entities) -> str:
        knots, times = np.unique(self.spline.t, return_counts=True)
        points = many([point(data, each) for each in np.asarray(self.spline.c)])
        return data.add(
            "B_SPLINE_CURVE_WITH_KNOTS", "''", str(self.spline.k), points,
            ".UNSPECIFIED.", ".F.", ".F.",
            many(map(str, times.tolist())), many(map(real, knots.tolist())), ".UNSPECIFIED.",
        )  # fmt: skip


class Surface(ABC):
    """A surface that a face lies on."""

    @abstractmethod
    def normal(self, place: Array) -> Array:
        """Its normal near a point (3,) of it, of any length."""

    @abstractmethod
    def to_step(self, data: Entities) -> str:
        """Writes its STEP entity; returns the reference."""


@dataclass(frozen=True, eq=False)
class TurnedSurface(Surface):
    """A surface about the cam's axis.

    Attributes:
        kind: STEP entity. sizes: its numbers. normal_at: its normal at a point (3,).
        height, way: of its placement on the axis [mm], and up (1) or down (−1) along it.
    """

    kind: str
    sizes: tuple[float, ...]
    normal_at: Callable[[Array], Array]
    height: float = 0.0
    way: float = 1.0

    def normal(self, place: Array) -> Array:
        return self.normal_at(place)

    def to_step(self, data: Entities) -> str:
        placed = placement(data, self.height * UP, self.way * UP, X)
        return data.add(self.kind, "''", placed, *map(real, self.sizes))


def plane(height: float, way: int) -> TurnedSurface:
    """A plane across the axis at a height [mm], normal up (1) or down (−1)."""
    return TurnedSurface("PLANE", (), lambda place: way * UP, height, way)


def cylinder(radius: float) -> TurnedSurface:
    """A cylinder about the axis [mm]."""
    return TurnedSurface("CYLINDRICAL_SURFACE", (radius,), lambda place: place * ACROSS)


def torus(middle: float, tube: float) -> TurnedSurface:
    """A torus about the axis: major and minor radius [mm]."""
    return TurnedSurface(
        "TOROIDAL_SURFACE", (middle, tube),
        lambda place: place - middle * (place * ACROSS) / np.hypot(place[0], place[1]),
    )  # fmt: skip


def cone(height: float, radius: float, slope: float) -> TurnedSurface:
    """A cone about the axis: its radius at a height [mm], and d radius/d height."""
    way = math.copysign(1.0, slope)  # STEP's cones widen along their axis
    return TurnedSurface(
        "CONICAL_SURFACE", (radius, math.atan(abs(slope))),
        lambda place: place * ACROSS / np.hypot(place[0], place[1]) - slope * UP, height, way,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class SplineSurface(Surface):
    """A tensor product of B-splines over [0, 1] × [0, 1]."""

    spline: NdBSpline

    def normal(self, place: Array) -> Array:
        middle = np.array([0.5, 0.5])
        along, down = self.spline(middle, nu=(1, 0)), self.spline(middle, nu=(0, 1))
        return np.asarray(np.cross(along, down))

    def to_step(self, data: Entities) -> str:
        return spline_surface(data, "''", self.spline)


@dataclass(frozen=True, eq=False)
class Edge:
    """An edge between two vertices."""

    first: Key
    last: Key
    curve: Curve


@dataclass(frozen=True, eq=False)
class Face:
    """A part of a surface.

    Attributes:
        loops: the outer one first. outwards: whether the surface's normal points out of the body.
    """

    surface: Surface
    loops: list[list[Run]]
    outwards: bool


@dataclass(frozen=True, eq=False)
class Shell:
    """Vertices (3,), edges and faces by key."""

    vertices: dict[Key, Array] = field(default_factory=dict)
    edges: dict[Key, Edge] = field(default_factory=dict)
    faces: list[Face] = field(default_factory=list)

    def join(self, key: Key, first: Key, last: Key, curve: Curve) -> Key:
        """An edge; made at its first use."""
        if key not in self.edges:
            self.edges[key] = Edge(first, last, curve)
            for vertex, share in ((first, 0.0), (last, 1.0)):
                self.vertices.setdefault(vertex, curve.points(np.array([share]))[0])
        return key

    def ends(self, key: Key) -> tuple[Key, Key]:
        """An edge's vertices."""
        return self.edges[key].first, self.edges[key].last

    def add(self, surface: Surface, edges: Iterable[Key], place: Array, out: Array,
            holes: Iterable[Iterable[Key]] = ()) -> None:  # fmt: skip
        """Add a face from edges in any order, oriented counter-clockwise seen from outside.

        Args:
            place, out: (3,) a point of the face, and a direction out of the body there.
        """
        loops = [self._oriented(self.chained(edges), out)]
        loops += [self._oriented(self.chained(each), -out) for each in holes]
        self.faces.append(Face(surface, loops, float(surface.normal(place) @ out) > 0.0))

    def chained(self, edges: Iterable[Key]) -> list[Run]:
        """The edges as one closed loop."""
        left = list(edges)
        at = left.pop(0)
        loop: list[Run] = [(at, True)]
        start, end = self.edges[at].first, self.edges[at].last
        while left:
            for key in left:
                edge = self.edges[key]
                if end in (edge.first, edge.last):
                    along = edge.first == end
                    end = edge.last if along else edge.first
                    loop.append((key, along))
                    left.remove(key)
                    break
            else:
                raise NotSmooth("edges of a face do not meet")
        if start != end:
            raise NotSmooth("edges of a face do not close")
        return loop

    def _oriented(self, loop: list[Run], out: Array) -> list[Run]:
        points = np.concatenate(
            [self.edges[key].curve.points(SHARES if along else 1.0 - SHARES) for key, along in loop]
        )
        points = points - np.mean(points, axis=0)
        area = np.sum(np.cross(points, np.roll(points, -1, axis=0)), axis=0)
        if area @ out >= 0.0:
            return loop
        return [(key, not along) for key, along in reversed(loop)]

    def check(self) -> None:
        """Check that every edge is traversed once in each direction.

        Raises:
            NotSmooth: the shell is not closed.
        """
        runs = [run for face in self.faces for loop in face.loops for run in loop]
        if len(set(runs)) != len(runs) or len(runs) != 2 * len(self.edges):
            raise NotSmooth("the shell is not closed")

    def to_step(self, data: Entities) -> str:
        """Write the CLOSED_SHELL with all its entities; returns the reference."""
        corners = {
            key: data.add("VERTEX_POINT", "''", point(data, place))
            for key, place in self.vertices.items()
        }
        edges = {
            key: data.add("EDGE_CURVE", "''", corners[edge.first], corners[edge.last],
                          edge.curve.to_step(data), ".T.")
            for key, edge in self.edges.items()
        }  # fmt: skip
        faces = []
        for face in self.faces:
            bounds = []
            for i, loop in enumerate(face.loops):
                runs = [data.add("ORIENTED_EDGE", "''", "*", "*", edges[key], FLAG[along])
                        for key, along in loop]  # fmt: skip
                ring = data.add("EDGE_LOOP", "''", many(runs))
                kind = "FACE_BOUND" if i else "FACE_OUTER_BOUND"
                bounds.append(data.add(kind, "''", ring, ".T."))
            surface, sense = face.surface.to_step(data), FLAG[face.outwards]
            faces.append(data.add("ADVANCED_FACE", "''", many(bounds), surface, sense))
        return data.add("CLOSED_SHELL", "''", many(faces))


def interpolate_surface(u: Array, v: Array, points: Array, degrees: tuple[int, int]) -> NdBSpline:
    """The tensor product of B-splines through points (n, m, 3) at u (n,) and v (m,)."""
    by_u = make_interp_spline(u, points, k=degrees[0], axis=0)
    by_v = make_interp_spline(v, by_u.c, k=degrees[1], axis=1)
    return NdBSpline((by_u.t, by_v.t), np.moveaxis(by_v.c, 0, 1), degrees)


def spline_surface(data: Entities, name: str, spline: NdBSpline) -> str:
    """Writes a tensor product of B-splines."""
    rows = [many([point(data, each) for each in row]) for row in spline.c]
    each = [np.unique(knots, return_counts=True) for knots in spline.t]
    return data.add(
        "B_SPLINE_SURFACE_WITH_KNOTS", name, *map(str, spline.k), many(rows),
        ".UNSPECIFIED.", ".F.", ".F.", ".F.",
        *(many(map(str, times.tolist())) for _, times in each),
        *(many(map(real, knots.tolist())) for knots, _ in each), ".UNSPECIFIED.",
    )  # fmt: skip


def point(data: Entities, place: Array) -> str:
    """Writes a point."""
    return data.add("CARTESIAN_POINT", "''", many(map(real, place.tolist())))


def placement(data: Entities, origin: Array, axis: Array, x: Array) -> str:
    """Writes a placement: origin, axis, x direction."""
    return data.add("AXIS2_PLACEMENT_3D", "''", point(data, origin), direction(data, axis),
                    direction(data, x))  # fmt: skip


def direction(data: Entities, way: Array) -> str:
    """Writes a direction."""
    return data.add("DIRECTION", "''", many(map(real, way.tolist())))
