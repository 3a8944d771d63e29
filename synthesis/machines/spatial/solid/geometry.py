"""A boundary representation: curves, surfaces, a closed shell of faces, and their STEP files.

Each edge of a shell is between two of its faces, which lie on the body's true surfaces. At the
ribs' tops and at the floor, the turned surface is divided into regions by the walls' edges and the
blank's ends. Between the two levels are the walls and, at the blank's ends, sections of ribs. A hub
closes the shell.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy.interpolate import BSpline, NdBSpline, make_interp_spline

from synthesis.exporters.curves.step import Entities, entity, many, real, write_spline
from synthesis.numerics.piecewise import Array

X, UP, ACROSS = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 0.0]])
Key = tuple[object, ...]
Run = tuple[Key, bool]  # an edge, and whether it is traversed in its own direction
SHARES = np.linspace(0.0, 1.0, 33)[:-1]  # of an edge, whose points give a loop's area
FLAG = {True: ".T.", False: ".F."}


class NotSmooth(Exception):
    """The body has no smooth boundary; the message says why."""


class Curve(NamedTuple):
    """A curve from one vertex to another.

    ``points`` gives points (n, 3) [mm] at shares (n,) between 0 and 1; ``to_step`` writes its STEP
    entity, with the same direction, and returns the reference.
    """

    points: Callable[[Array], Array]
    to_step: Callable[[Entities], str]


def circle(centre: Array, x: Array, y: Array, radius: float, start: float, end: float) -> Curve:
    """centre + radius (x cos φ + y sin φ), φ from ``start`` to a larger ``end`` [rad]."""

    def points(share: Array) -> Array:
        at = (start + share * (end - start))[:, None]
        return centre + radius * (np.cos(at) * x + np.sin(at) * y)

    def to_step(data: Entities) -> str:
        return data.add("CIRCLE", "''", placement(data, centre, np.cross(x, y), x), real(radius))

    return Curve(points, to_step)


def line(first: Array, last: Array) -> Curve:
    """A straight line."""
    span = last - first

    def to_step(data: Entities) -> str:
        along = entity(data, "DIRECTION", span / float(np.linalg.norm(span)))
        vector = data.add("VECTOR", "''", along, real(1.0))
        return data.add("LINE", "''", entity(data, "CARTESIAN_POINT", first), vector)

    return Curve(lambda share: first + share[:, None] * span, to_step)


def spline_curve(spline: BSpline) -> Curve:
    """A B-spline over [0, 1]."""
    whole = NdBSpline((spline.t,), np.asarray(spline.c), (spline.k,))
    return Curve(lambda share: spline(share), lambda data: write_spline(data, "''", whole))


class Surface(NamedTuple):
    """A surface that a face lies on; of a wall the spline.

    ``normal`` gives its normal, of any length, near a point (3,) of it; ``to_step`` writes its STEP
    entity and returns the reference.
    """

    normal: Callable[[Array], Array]
    to_step: Callable[[Entities], str]
    spline: NdBSpline | None = None


def _turned(normal: Callable[[Array], Array], kind: str, *sizes: float,
            height: float = 0.0, sense: float = 1.0) -> Surface:  # fmt: skip
    """A surface about the cam's axis: STEP entity and its numbers.

    Args:
        height, sense: of its placement on the axis [mm], and up (1) or down (−1) along it.
    """

    def to_step(data: Entities) -> str:
        placed = placement(data, height * UP, sense * UP, X)
        return data.add(kind, "''", placed, *map(real, sizes))

    return Surface(normal, to_step)


def cylinder(radius: float) -> Surface:
    """A cylinder about the axis [mm]."""
    return _turned(lambda place: place * ACROSS, "CYLINDRICAL_SURFACE", radius)


def torus(middle: float, tube: float) -> Surface:
    """A torus about the axis: major and minor radius [mm]."""

    def normal(place: Array) -> Array:
        return np.asarray(place - middle * (place * ACROSS) / np.hypot(place[0], place[1]))

    return _turned(normal, "TOROIDAL_SURFACE", middle, tube)


def plane(height: float, sense: int) -> Surface:
    """A plane across the axis at a height [mm], normal up (1) or down (−1)."""
    return _turned(lambda place: sense * UP, "PLANE", height=height, sense=sense)


def cone(first: tuple[float, float], last: tuple[float, float], out: Array) -> Surface:
    """The cone about the axis through two radii and heights [mm], or a plane, or a cylinder.

    Args:
        out: (3,) a direction out of the body; a plane's normal.
    """
    (radius, height), (run, rise) = first, np.subtract(last, first).tolist()
    if abs(rise) < 1e-9 * abs(run):
        return plane(height, int(np.sign(out[2])))
    if abs(run) < 1e-9 * abs(rise):
        return cylinder(radius)
    slope = run / rise

    def normal(place: Array) -> Array:
        return np.asarray(place * ACROSS / np.hypot(place[0], place[1]) - slope * UP)

    # STEP's cones widen along their axis.
    half, sense = math.atan(abs(slope)), math.copysign(1.0, slope)
    return _turned(normal, "CONICAL_SURFACE", radius, half, height=height, sense=sense)


def spline_surface(spline: NdBSpline) -> Surface:
    """A tensor product of B-splines over [0, 1] × [0, 1]."""
    middle = np.array([0.5, 0.5])
    normal = np.cross(spline(middle, nu=(1, 0)), spline(middle, nu=(0, 1)))
    return Surface(lambda place: normal, lambda data: write_spline(data, "''", spline), spline)


@dataclass(frozen=True, eq=False)
class Shell:
    """A boundary of faces.

    Attributes:
        vertices: (3,) by key. edges: first and last vertex, and curve, by key.
        faces: the surface, its loops, the outer one first, and whether the surface's normal points
            out of the body.
    """

    vertices: dict[Key, Array] = field(default_factory=dict)
    edges: dict[Key, tuple[Key, Key, Curve]] = field(default_factory=dict)
    faces: list[tuple[Surface, list[list[Run]], bool]] = field(default_factory=list)

    def join(self, key: Key, first: Key, last: Key, curve: Curve) -> Key:
        """An edge; made at its first use."""
        if key not in self.edges:
            self.edges[key] = first, last, curve
            for vertex, share in ((first, 0.0), (last, 1.0)):
                self.vertices.setdefault(vertex, curve.points(np.array([share]))[0])
        return key

    def add(self, surface: Surface, edges: Iterable[Key], place: Array, out: Array,
            holes: Iterable[Iterable[Key]] = ()) -> None:  # fmt: skip
        """Add a face from edges in any order, oriented counter-clockwise seen from outside.

        Args:
            place, out: (3,) a point of the face, and a direction out of the body there.
        """
        loops = [self._oriented(self.chained(edges), out)]
        loops += [self._oriented(self.chained(each), -out) for each in holes]
        self.faces.append((surface, loops, float(surface.normal(place) @ out) > 0.0))

    def chained(self, edges: Iterable[Key]) -> list[Run]:
        """The edges as one closed loop."""
        left = list(edges)
        at = left.pop(0)
        loop: list[Run] = [(at, True)]
        start, end, _ = self.edges[at]
        while left:
            key = next((key for key in left if end in self.edges[key][:2]), None)
            if key is None:
                raise NotSmooth("edges of a face do not meet")
            first, last, _ = self.edges[key]
            loop.append((key, first == end))
            end = last if first == end else first
            left.remove(key)
        if start != end:
            raise NotSmooth("edges of a face do not close")
        return loop

    def _oriented(self, loop: list[Run], out: Array) -> list[Run]:
        points = np.concatenate(
            [self.edges[key][2].points(SHARES if along else 1.0 - SHARES) for key, along in loop]
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
        runs = [run for _, loops, _ in self.faces for loop in loops for run in loop]
        if len(set(runs)) != len(runs) or len(runs) != 2 * len(self.edges):
            raise NotSmooth("the shell is not closed")

    def to_step(self, data: Entities) -> str:
        """Write the CLOSED_SHELL with all its entities; returns the reference."""
        corners = {
            key: data.add("VERTEX_POINT", "''", entity(data, "CARTESIAN_POINT", place))
            for key, place in self.vertices.items()
        }
        edges = {
            key: data.add("EDGE_CURVE", "''", corners[first], corners[last],
                          curve.to_step(data), ".T.")
            for key, (first, last, curve) in self.edges.items()
        }  # fmt: skip
        faces = []
        for surface, loops, outwards in self.faces:
            bounds = []
            for i, loop in enumerate(loops):
                runs = [data.add("ORIENTED_EDGE", "''", "*", "*", edges[key], FLAG[along])
                        for key, along in loop]  # fmt: skip
                ring = data.add("EDGE_LOOP", "''", many(runs))
                kind = "FACE_BOUND" if i else "FACE_OUTER_BOUND"
                bounds.append(data.add(kind, "''", ring, ".T."))
            reference, sense = surface.to_step(data), FLAG[outwards]
            faces.append(data.add("ADVANCED_FACE", "''", many(bounds), reference, sense))
        return data.add("CLOSED_SHELL", "''", many(faces))


def interpolate_surface(u: Array, v: Array, points: Array, degrees: tuple[int, int]) -> NdBSpline:
    """The tensor product of B-splines through points (n, m, 3) at u (n,) and v (m,)."""
    by_u = make_interp_spline(u, points, k=degrees[0], axis=0)
    by_v = make_interp_spline(v, by_u.c, k=degrees[1], axis=1)
    return NdBSpline((by_u.t, by_v.t), np.moveaxis(by_v.c, 0, 1), degrees)


def placement(data: Entities, origin: Array, axis: Array, x: Array) -> str:
    """Writes a placement: origin, axis, x direction."""
    place = entity(data, "CARTESIAN_POINT", origin)
    directions = (entity(data, "DIRECTION", each) for each in (axis, x))
    return data.add("AXIS2_PLACEMENT_3D", "''", place, *directions)
