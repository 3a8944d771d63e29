"""Measured quantities of the finished cam and their enclosure, from the path of the traced point.

A point p(θ) of the machine frame traces its curve on the turning cam. With D = d/dθ + J,
J (x, y) = (y, −x), the curve's tangent is T = D p and its second derivative is D T, both with
components in the machine frame. Every follower is measured by these formulas; none of the closed
forms that the optimiser uses occurs here, so that an error in one cannot confirm the other.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from synthesis.catalogue.followers.base import paths
from synthesis.catalogue.followers.flat_face import flat_face
from synthesis.catalogue.followers.kinematics import TracePoint, Vector2
from synthesis.catalogue.followers.sizing import prime_radius
from synthesis.catalogue.limits.base import Claim, Machine
from synthesis.certify.piecewise_motion import Indices, Jump, PiecewiseMotion
from synthesis.numerics.enclosure import Extremum, ExtremumQuery, enclose
from synthesis.numerics.piecewise import Array
from synthesis.numerics.taylor import Taylor

Size = tuple[float, ...]
Box = tuple[Indices, Array, Array]  # piece, lower and upper end [rad]
Points = tuple[Indices, Array]  # piece and cam angle [rad]


@dataclass(frozen=True, eq=False)
class TracedPoint:
    """A traced point and its tangent at given s, s', s'', s''' (numbers, arrays or Taylor models).

    Terms that several quantities share are computed once.
    """

    trace: TracePoint
    size: Size
    s: tuple[Any, ...]

    @cached_property
    def position(self) -> tuple[Vector2, ...]:
        """p and its derivatives with respect to θ in the machine frame."""
        return self.trace.position(self.s, self.size)

    @cached_property
    def tangent(self) -> Vector2:
        """T = D p."""
        (px, py), (dx, dy), *_ = self.position
        return dx + py, dy - px

    @cached_property
    def moment(self) -> Any:
        """(n · p) |T|, n the unit normal of the curve: the moment of T about the cam's axis."""
        (px, py), *_ = self.position
        tx, ty = self.tangent
        return py * tx - px * ty

    @cached_property
    def tangent_squared(self) -> Any:
        """|T|²."""
        tx, ty = self.tangent
        return tx * tx + ty * ty

    @cached_property
    def tangent_length(self) -> Any:
        """|T|."""
        return np.sqrt(self.tangent_squared)


Formula = Callable[[TracedPoint], Any]


def pressure_angle(at: TracedPoint) -> Any:
    """α from the outward normal of the profile to the direction g in which the cam drives [rad]."""
    nx, ny = at.trace.normal(at.tangent, at.s, at.size)
    (gx, gy), _ = at.trace.drive_direction(at.s, at.size)
    return np.arctan2(gx * ny - gy * nx, gx * nx + gy * ny)


def pitch_curvature(at: TracedPoint) -> Any:
    """κ = T × D T / |T|³ of the traced curve, which runs clockwise: convex positive [1/mm]."""
    _, (dx, dy), (ax, ay), *_ = at.position
    tx, ty = at.tangent
    # D T = T' + J T, so that T × D T = T × T' + |T|²
    return (at.tangent_squared + ty * (ax + dy) - tx * (ay - dx)) / (
        at.tangent_squared * at.tangent_length
    )


def pitch_radius(at: TracedPoint) -> Any:
    """|p|, the distance of the traced curve from the cam's axis [mm]."""
    (px, py), *_ = at.position
    return np.sqrt(px * px + py * py)


def face_radius(at: TracedPoint) -> Any:
    """Signed radius of the profile under a flat face, ρ = T·m / m·m with m = n' + J n [mm].

    n is the face's unit normal at the contact point. The profile is the envelope of the face, so
    that ρ is negative where T runs against the turning of the face, which is undercut, and passes
    through 0 at a cusp. The curvature from T alone would lose the sign.
    """
    tx, ty = at.tangent
    face = flat_face(at.trace)
    assert face is not None
    mx, my = face.face_normal_rate(at.s, at.size)
    return (tx * mx + ty * my) / (mx * mx + my * my)


def contact(at: TracedPoint) -> Any:
    """Position of the contact point along the face, from the face's reference point [mm]."""
    (px, py), *_ = at.position
    face = flat_face(at.trace)
    assert face is not None
    (mx, my), (ax, ay) = face.face_axis(at.s, at.size)
    return (px - mx) * ax + (py - my) * ay


def _derivative(order: int) -> Formula:
    return lambda at: at.s[order]


class Quantity(Protocol):
    """A function of the cam angle that can be enclosed."""

    @property
    def order(self) -> int:
        """Highest derivative of s that it uses."""

    @property
    def continuous_below(self) -> int:
        """If a derivative of s below this order jumps, the quantity is infinite there."""

    @property
    def absolute_width(self) -> float:
        """Width of an enclosure that suffices, besides 1e-10 of the value; in its own unit."""

    @property
    def width_per_size(self) -> float:
        """The same as a share of the cam's size, for lengths that may vanish."""

    @property
    def infinite_at_corners(self) -> bool:
        """Whether a corner of the traced curve makes it infinite, with the sign of the corner."""

    def model(self, point: TracedPoint, box: Box) -> Any:
        """Its Taylor models on boxes, from those of s and at least the derivatives it uses."""

    def values(self, point: TracedPoint, points: Points) -> Array:
        """Its values (n,) at cam angles, from s to s''' there."""


@dataclass(frozen=True)
class GeometricQuantity:
    """A quantity that one formula gives from the traced point; attributes as of ``Quantity``."""

    formula: Formula
    order: int
    continuous_below: int = 0
    absolute_width: float = 0.0
    width_per_size: float = 0.0
    infinite_at_corners: bool = False

    def model(self, point: TracedPoint, box: Box) -> Taylor:
        """Its Taylor models on boxes."""
        found = self.formula(point)
        return found if isinstance(found, Taylor) else point.s[0].constant(found)

    def values(self, point: TracedPoint, points: Points) -> Array:
        """Its values at cam angles."""
        return np.asarray(self.formula(point))


# Widths: 1e-10 rad of a pressure angle is 6e-9°; the shares of the cam's size are a hundred times
# the rounding errors of a radius or a contact position, and the rounding error itself of travel.
QUANTITIES = {
    "travel": GeometricQuantity(_derivative(0), 0, width_per_size=1e-14),
    "displacement": GeometricQuantity(_derivative(0), 0),
    "velocity": GeometricQuantity(_derivative(1), 1, 1),
    "acceleration": GeometricQuantity(_derivative(2), 2, 2),
    "jerk": GeometricQuantity(_derivative(3), 3, 3),
    "pressure_angle": GeometricQuantity(pressure_angle, 1, absolute_width=1e-10),
    "pitch_curvature": GeometricQuantity(pitch_curvature, 2, infinite_at_corners=True),
    "pitch_radius": GeometricQuantity(pitch_radius, 1),
    "face_radius": GeometricQuantity(face_radius, 2, 2, width_per_size=1e-12),
    "contact": GeometricQuantity(contact, 1, 1, width_per_size=1e-12),
    "contact_left": GeometricQuantity(lambda at: -contact(at), 1, 1, width_per_size=1e-12),
    "contact_right": GeometricQuantity(contact, 1, 1, width_per_size=1e-12),
}


def tangent_clearance(depth: float) -> GeometricQuantity:
    """(n · p − depth) |T|: positive where the tangent passes the axis at more than ``depth`` [mm].

    The axis lies on the inner side of the curve there.
    """
    return GeometricQuantity(lambda at: at.moment - depth * at.tangent_length, 1)


def trace_of(machine: Machine, path: str = "") -> TracePoint:
    """The traced curve of this name; the first one if the name is empty."""
    traces = paths(machine.follower)
    return traces[path] if path else next(iter(traces.values()))


def enclose_quantities(
    subjects: Sequence[tuple[Quantity, str]],
    motion: PiecewiseMotion,
    machine: Machine,
    size: Size,
    questions: Sequence[ExtremumQuery],
) -> list[Extremum]:
    """Enclose extremes of quantities over the cam angle, one-sided at junctions.

    Args:
        subjects: quantity and name of its traced curve; the functions that the questions refer to.
        motion, machine, size: the cam.
        questions: which extremes. The width that suffices is the larger of the question's own and
            the quantity's.
    """
    traces = {path: trace_of(machine, path) for path in {path for _, path in subjects}}
    scale = prime_radius(machine.follower, size)

    def models(piece: Indices, lo: Array, hi: Array, wanted: Sequence[int]) -> list[Taylor]:
        highest = max(subjects[k][0].order for k in wanted)
        s = motion.jets.models(piece, lo, hi, highest) + (0.0,) * (3 - highest)
        points = {path: TracedPoint(trace, size, s) for path, trace in traces.items()}
        chosen = (subjects[k] for k in wanted)
        return [quantity.model(points[path], (piece, lo, hi)) for quantity, path in chosen]

    def values(piece: Indices, x: Array, wanted: Sequence[int]) -> list[Array]:
        s = tuple(motion.curve.jet(x, piece, 3))
        points = {path: TracedPoint(trace, size, s) for path, trace in traces.items()}
        chosen = (subjects[k] for k in wanted)
        return [quantity.values(points[path], (piece, x)) for quantity, path in chosen]

    widths = [quantity.absolute_width + quantity.width_per_size * scale for quantity, _ in subjects]
    return enclose(models, motion.curve.breaks, motion.initial_boxes, questions, values, widths)


def infinite_by_jump(
    quantity: Quantity,
    motion: PiecewiseMotion,
    segments: Sequence[int],
    part: tuple[float, float] | None = None,
) -> Jump | None:
    """The jump of s, s', … of lowest order that makes the quantity infinite on these segments."""
    if motion.is_continuous_below(quantity.continuous_below):
        return None
    junctions = motion.junctions_of(segments, part)
    for order in range(quantity.continuous_below):
        jumps = motion.discontinuities(order, junctions)
        if len(jumps):
            return motion.largest_jump(order, jumps)
    return None


def infinite_at_corner(
    quantity: Quantity, motion: PiecewiseMotion, machine: Machine, size: Size, claim: Claim
) -> Jump | None:
    """A jump of the velocity at which the traced curve has a corner of the sense the claim bounds.

    At a corner the curvature is +∞ or −∞, by the sense in which the tangent turns there. A claim
    with an upper bound excludes the first, one with a lower bound the second.
    """
    if not quantity.infinite_at_corners or motion.is_continuous_below(2):
        return None
    trace = trace_of(machine, claim.path)
    for junction in motion.discontinuities(1, motion.junctions_of(claim.segments, claim.interval)):
        before, after = (
            TracedPoint(trace, size, s).tangent for s in motion.one_sided_values(int(junction))
        )
        turn = before[1] * after[0] - before[0] * after[1]
        if (turn > 0.0 and claim.upper is not None) or (turn < 0.0 and claim.lower is not None):
            return motion.largest_jump(1, np.array([junction]))
    return None
