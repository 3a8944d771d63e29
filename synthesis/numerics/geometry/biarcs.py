"""A closed curve as circular arcs that go over into each other without a corner.

Between two nodes of the curve with its tangents there t0, t1 stand two arcs that touch in between
(Bolton 1975), here with equal distances d from the nodes to the corners of their tangents:

    d = v·v / (v·t + √((v·t)² + 2 (1 − t0·t1) v·v)),   v = p1 − p0,  t = t0 + t1
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from synthesis.errors import InputError
from synthesis.numerics.geometry.closed_curve import ClosedCurve, Mesh
from synthesis.numerics.piecewise import Array

PROBES = np.linspace(0.0, 1.0, 33)[1::2]
BEYOND = 1.02  # what may lie between the probes
MOST_ARCS = 20_000  # of one curve
MAX_ITERATIONS = 40  # of spreading arcs by their departures anew
MERGING = 4  # iterations in which pieces of a span may be merged too
POWER = 3  # of a piece's length, in proportion to which it departs
FLAT = 1e-12  # half the angle of an arc that is a straight line [rad]


@dataclass(frozen=True, eq=False)
class Arcs:
    """A closed chain of arcs, each from one of the points (n, 2) to the next [mm].

    ``bulges``: (n,) tan(φ/4) of the angle φ that each turns by, left positive; 0 where straight.
    ``error``: largest distance from the true curve [mm].
    """

    points: Array
    bulges: Array
    error: float


def fit_biarcs(curve: ClosedCurve, tolerance: float) -> Arcs:
    """The arcs of a closed curve; ``tolerance``: largest distance from it [mm].

    Raises:
        InputError: the tolerance needs more arcs than anybody could want.
    """
    mesh = Mesh.initial(curve.span_sizes)
    for iteration in range(MAX_ITERATIONS):
        found, departures = _through(curve, mesh)
        if iteration and found.error <= tolerance:
            return found
        if len(mesh.span) > MOST_ARCS:
            break
        mesh = mesh.equidistribute(departures / tolerance, POWER, growing=iteration >= MERGING)
    raise InputError(
        "/tolerance_um",
        float(f"{tolerance * 1e3:.12g}"),
        f"{2 * len(mesh.span)} arcs came as near as {found.error * 1e3:.3g} µm.",
        "Allow a larger tolerance, or take the curve as a spline.",
    )


def _through(curve: ClosedCurve, mesh: Mesh) -> tuple[Arcs, Array]:
    """The arcs through a mesh's nodes, and the largest departure on every piece [mm]."""
    course = curve.at(*mesh.points_at(np.array([0.0, 1.0])))
    (p0, p1), (t0, t1) = (
        each.reshape(-1, 2, 2).swapaxes(0, 1) for each in (course.points, course.tangent)
    )
    true = curve.at(*mesh.points_at(PROBES)).points.reshape(len(p0), -1, 2)
    v, t = p1 - p0, t0 + t1
    along = _dot(v, t)
    root = np.sqrt(along**2 + 2.0 * (1.0 - _dot(t0, t1)) * _dot(v, v))
    reach = (_dot(v, v) / (along + root))[:, None]
    middle = 0.5 * (p0 + p1 + reach * (t0 - t1))
    halves = np.stack([_half(t0, middle - p0), -_half(t1, middle - p1, backwards=True)], axis=1)
    halves[np.abs(halves) < FLAT] = 0.0
    chord = np.stack([middle - p0, p1 - middle], axis=1)
    bends = 2.0 * np.sin(halves) / np.hypot(chord[..., 0], chord[..., 1])
    second = _dot(true - middle[:, None], (v - reach * t)[:, None]) > 0.0
    near = np.where(
        second,
        _off(true - p1[:, None], t1[:, None], bends[:, 1:]),
        _off(true - p0[:, None], t0[:, None], bends[:, :1]),
    )
    departures = BEYOND * np.max(np.abs(near), axis=1)
    points = np.stack([p0, middle], axis=1).reshape(-1, 2)
    return Arcs(points, np.tan(0.5 * halves).ravel(), float(np.max(departures))), departures


def _half(tangent: Array, chord: Array, backwards: bool = False) -> Array:
    """Angle from the tangent, or its opposite, to the chord: half of what the arc turns by."""
    sign = -1.0 if backwards else 1.0
    cross = tangent[:, 0] * chord[:, 1] - tangent[:, 1] * chord[:, 0]
    return np.asarray(np.arctan2(sign * cross, sign * _dot(tangent, chord)))


def _off(place: Array, tangent: Array, bend: Array) -> Array:
    """Distance from the circle through the origin with a tangent and a signed curvature there."""
    normal = tangent[..., 0] * place[..., 1] - tangent[..., 1] * place[..., 0]
    g = bend * _dot(place, place) - 2.0 * normal
    return np.asarray(g / (1.0 + np.sqrt(np.maximum(1.0 + bend * g, 0.0))))


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1])
