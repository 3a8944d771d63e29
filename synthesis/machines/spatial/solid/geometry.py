"""Curves and surfaces of a boundary representation: points, normals, STEP entities and files."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline, NdBSpline, make_interp_spline

from synthesis.exporters.curves.step import Entities, many, real
from synthesis.numerics.piecewise import Array

UP = np.array([0.0, 0.0, 1.0])


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
class Plane(Surface):
    """A plane perpendicular to the cam's axis at a height [mm], normal up (1) or down (−1)."""

    height: float
    way: int

    def normal(self, place: Array) -> Array:
        return self.way * UP

    def to_step(self, data: Entities) -> str:
        placed = placement(data, self.height * UP, self.way * UP, np.array([1.0, 0.0, 0.0]))
        return data.add("PLANE", "''", placed)


@dataclass(frozen=True, eq=False)
class Cylinder(Surface):
    """A cylinder about the cam's axis [mm]."""

    radius: float

    def normal(self, place: Array) -> Array:
        return np.array([place[0], place[1], 0.0])

    def to_step(self, data: Entities) -> str:
        return data.add("CYLINDRICAL_SURFACE", "''", upright(data), real(self.radius))


@dataclass(frozen=True, eq=False)
class Ring(Surface):
    """A torus about the cam's axis: major and minor radius [mm]."""

    middle: float
    tube: float

    def normal(self, place: Array) -> Array:
        away = float(np.hypot(place[0], place[1]))
        return np.asarray(place - self.middle / away * np.array([place[0], place[1], 0.0]))

    def to_step(self, data: Entities) -> str:
        return data.add("TOROIDAL_SURFACE", "''", upright(data), real(self.middle), real(self.tube))


@dataclass(frozen=True, eq=False)
class Cone(Surface):
    """A cone about the cam's axis: its radius at a height [mm], and d radius/d height."""

    height: float
    radius: float
    slope: float

    def normal(self, place: Array) -> Array:
        away = np.hypot(place[0], place[1])
        return np.array([place[0] / away, place[1] / away, -self.slope])

    def to_step(self, data: Entities) -> str:
        way = math.copysign(1.0, self.slope)  # STEP's cones widen along their axis
        placed = placement(data, self.height * UP, way * UP, np.array([1.0, 0.0, 0.0]))
        angle = math.atan(abs(self.slope))
        return data.add("CONICAL_SURFACE", "''", placed, real(self.radius), real(angle))


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


def direction(data: Entities, way: Array) -> str:
    """Writes a direction."""
    return data.add("DIRECTION", "''", many(map(real, way.tolist())))


def placement(data: Entities, origin: Array, axis: Array, x: Array) -> str:
    """Writes a placement: origin, axis, x direction."""
    return data.add("AXIS2_PLACEMENT_3D", "''", point(data, origin), direction(data, axis),
                    direction(data, x))  # fmt: skip


def upright(data: Entities) -> str:
    """Writes the cam's own frame."""
    return placement(data, np.zeros(3), UP, np.array([1.0, 0.0, 0.0]))
