"""What is measured, and how: from the path of the traced point, for every follower alike.

A point p(θ) of the machine frame draws its curve on the turning cam. With D = d/dθ + J,
J (x, y) = (y, −x), its tangent is T = D p and its second derivative S = D T, both seen in the
machine frame. Nothing here comes from the closed forms that the formulations use.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from synthesis.certify.course import Course, Indices, Jump
from synthesis.followers.trace import Trace, Vector2
from synthesis.limits.base import Claim, Machine
from synthesis.numerics.enclosure import Answer, Question, enclose
from synthesis.numerics.piecewise import Array
from synthesis.numerics.taylor import Taylor

Size = tuple[float, ...]
Formula = Callable[[Trace, Size, tuple[Any, ...]], Any]


def tangent(follower: Trace, size: Size, s: tuple[Any, ...]) -> Vector2:
    """T = D p."""
    (px, py), (dx, dy), *_ = follower.traced_point(s, size)
    return dx + py, dy - px


def pressure_angle(follower: Trace, size: Size, s: tuple[Any, ...]) -> Any:
    """α from the outward normal, the curve's own or a face's, to the direction of drive g [rad]."""
    nx, ny = follower.normal(tangent(follower, size, s), s, size)
    (gx, gy), _ = follower.direction(s, size)
    return np.arctan2(gx * ny - gy * nx, gx * nx + gy * ny)


def pitch_curvature(follower: Trace, size: Size, s: tuple[Any, ...]) -> Any:
    """κ = T × S / |T|³ of the curve, run clockwise round the cam: convex positive [1/mm]."""
    (px, py), (dx, dy), (ax, ay), *_ = follower.traced_point(s, size)
    tx, ty = dx + py, dy - px
    sx, sy = ax + dy + ty, ay - dx - tx
    square = tx * tx + ty * ty
    return (ty * sx - tx * sy) / (square * np.sqrt(square))


def pitch_radius(follower: Trace, size: Size, s: tuple[Any, ...]) -> Any:
    """|p|: how far the curve is from the cam's axis [mm]."""
    (px, py), *_ = follower.traced_point(s, size)
    return np.sqrt(px * px + py * py)


def face_radius(follower: Trace, size: Size, s: tuple[Any, ...]) -> Any:
    """ρ = T·m / m·m with m = n' + J n, n the face's unit normal, at the contact point [mm].

    The support function's way: where T runs against the turning face the profile is undercut, and
    ρ is negative; at a cusp it passes through 0. The curvature from T alone would be 1/|ρ|.
    """
    tx, ty = tangent(follower, size, s)
    mx, my = follower.face_turn(s, size)
    return (tx * mx + ty * my) / (mx * mx + my * my)


def contact(follower: Trace, size: Size, s: tuple[Any, ...]) -> Any:
    """How far the contact point is along the face from where its reach is measured [mm]."""
    (px, py), *_ = follower.traced_point(s, size)
    (mx, my), (ax, ay) = follower.face_axis(s, size)
    return (px - mx) * ax + (py - my) * ay


def _derivative(order: int) -> Formula:
    return lambda follower, size, s: s[order]


Box = tuple[Indices, Array, Array]  # piece, lower and upper end
Points = tuple[Indices, Array]  # piece and cam angle


class Measurable(Protocol):
    """What can be enclosed; the attributes as of ``Quantity``."""

    @property
    def order(self) -> int:
        """Highest derivative of s."""

    @property
    def smooth(self) -> int:
        """Derivatives below this one must not jump."""

    @property
    def absolute(self) -> float:
        """Width that is good enough."""

    @property
    def share(self) -> float:
        """The same as a share of the cam's size."""

    @property
    def turns(self) -> bool:
        """Whether a corner makes it infinite."""

    def at(self, trace: Trace, size: Size, s: tuple[Any, ...], box: Box) -> Any:
        """Its model on boxes."""

    def value(self, trace: Trace, size: Size, s: tuple[Any, ...], at: Points) -> Array:
        """Its values at points, from s to s''' there: (n,)."""


@dataclass(frozen=True)
class Quantity:
    """A function of the cam angle.

    Attributes:
        formula: its value from the follower, the size and s to s'''; of numbers or of models.
        order: highest derivative of s that it uses; the others reach the formula as 0.
        smooth: derivatives of s below this one must not jump, or the quantity is infinite.
        absolute: width that is good enough, besides 1e-10 of the value.
        share: the same as a share of the cam's size, for lengths that may vanish.
        turns: a corner of the traced curve makes it infinite, with the sign of the turn.
    """

    formula: Formula
    order: int
    smooth: int = 0
    absolute: float = 0.0
    share: float = 0.0
    turns: bool = False

    def at(self, trace: Trace, size: Size, s: tuple[Any, ...], box: Box) -> Taylor:
        """Its model, from those of s and at least as many derivatives as it uses."""
        found = self.formula(trace, size, s[: self.order + 1] + (0.0,) * (3 - self.order))
        return found if isinstance(found, Taylor) else s[0].constant(found)

    def value(self, trace: Trace, size: Size, s: tuple[Any, ...], at: Points) -> Array:
        """Its values at points."""
        return np.asarray(self.formula(trace, size, s))


QUANTITIES = {
    "travel": Quantity(_derivative(0), 0, share=1e-14),
    "displacement": Quantity(_derivative(0), 0),
    "velocity": Quantity(_derivative(1), 1, smooth=1),
    "acceleration": Quantity(_derivative(2), 2, smooth=2),
    "jerk": Quantity(_derivative(3), 3, smooth=3),
    "pressure_angle": Quantity(pressure_angle, 1, absolute=1e-10),
    "pitch_curvature": Quantity(pitch_curvature, 2, turns=True),
    "pitch_radius": Quantity(pitch_radius, 1),
    "face_radius": Quantity(face_radius, 2, smooth=2, share=1e-12),
    "contact": Quantity(contact, 1, smooth=1, share=1e-12),
    "contact_left": Quantity(lambda *at: -contact(*at), 1, smooth=1, share=1e-12),
    "contact_right": Quantity(contact, 1, smooth=1, share=1e-12),
}


def traced(machine: Machine, path: str = "") -> Trace:
    """The traced curve of this name, the first one for none."""
    paths = machine.follower.paths
    return paths[path] if path else next(iter(paths.values()))


def enclose_all(
    subjects: Sequence[tuple[Measurable, str]],
    course: Course,
    machine: Machine,
    size: Size,
    questions: Sequence[Question],
) -> list[Answer]:
    """Answers about quantities, each on a path, one-sided at joints.

    Args:
        subjects: quantity, and name of its path; the functions that the questions speak of.
        course, machine, size: the cam.
        questions: what is asked, to the width that each says and what is good enough anyway.
    """
    traces = [traced(machine, path) for _, path in subjects]
    scale = machine.follower.radius(size)

    def models(piece: Indices, lo: Array, hi: Array, wanted: Sequence[int]) -> list[Taylor]:
        highest = max(subjects[k][0].order for k in wanted)
        s = course.jets.models(piece, lo, hi, highest)
        return [subjects[k][0].at(traces[k], size, s, (piece, lo, hi)) for k in wanted]

    def values(piece: Indices, x: Array, wanted: Sequence[int]) -> list[Array]:
        s = tuple(course.curve.jet(x, piece, 3))
        return [subjects[k][0].value(traces[k], size, s, (piece, x)) for k in wanted]

    enough = [quantity.absolute + quantity.share * scale for quantity, _ in subjects]
    asked = [replace(q, absolute=q.absolute + enough[q.function]) for q in questions]
    return enclose(models, course.curve.breaks, course.counts, asked, values)


def infinite(
    quantity: Measurable,
    course: Course,
    stretches: Sequence[int],
    part: tuple[float, float] | None = None,
) -> Jump | None:
    """The jump that makes a derivative infinite on these stretches, lowest order first."""
    if course.joined(quantity.smooth):
        return None
    joints = course.joints(stretches, part)
    for order in range(quantity.smooth):
        apart = course.breaches(order, joints)
        if len(apart):
            return course.worst(order, apart)
    return None


def corner(
    quantity: Measurable, course: Course, machine: Machine, size: Size, claim: Claim
) -> Jump | None:
    """A jump of the velocity that turns the pitch curve's tangent the way the claim forbids."""
    if not quantity.turns or course.joined(2):
        return None
    trace = traced(machine, claim.path)
    for joint in course.breaches(1, course.joints(claim.stretches, claim.part)):
        before, after = (tangent(trace, size, s) for s in course.sides(int(joint)))
        turn = before[1] * after[0] - before[0] * after[1]
        if (turn > 0.0 and claim.upper is not None) or (turn < 0.0 and claim.lower is not None):
            return course.worst(1, np.array([joint]))
    return None
