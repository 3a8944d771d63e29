"""What is measured, and how: from the path of the traced point, for every follower alike.

A point p(θ) of the machine frame draws its curve on the turning cam. With D = d/dθ + J,
J (x, y) = (y, −x), its tangent is T = D p and its second derivative S = D T, both seen in the
machine frame. Nothing here comes from the closed forms that the formulations use.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from synthesis.certify.course import Course, Indices, Jump
from synthesis.followers.trace import Trace, Vector2
from synthesis.limits.base import Claim, Machine
from synthesis.numerics.enclosure import Answer, Question, enclose
from synthesis.numerics.piecewise import Array
from synthesis.numerics.taylor import Taylor

Size = tuple[float, ...]


@dataclass(frozen=True, eq=False)
class Sight:
    """A traced point at s to s''' (numbers, arrays, models), as the quantities see it.

    What several of them need is made once.
    """

    trace: Trace
    size: Size
    s: tuple[Any, ...]

    @cached_property
    def point(self) -> tuple[Vector2, ...]:
        """p and its derivatives in the machine frame."""
        return self.trace.traced_point(self.s, self.size)

    @cached_property
    def tangent(self) -> Vector2:
        """T = D p."""
        (px, py), (dx, dy), *_ = self.point
        return dx + py, dy - px

    @cached_property
    def moment(self) -> Any:
        """(n · p) |T|."""
        (px, py), *_ = self.point
        tx, ty = self.tangent
        return py * tx - px * ty

    @cached_property
    def square(self) -> Any:
        """|T|²."""
        tx, ty = self.tangent
        return tx * tx + ty * ty

    @cached_property
    def speed(self) -> Any:
        """|T|."""
        return np.sqrt(self.square)


Formula = Callable[[Sight], Any]


def pressure_angle(at: Sight) -> Any:
    """α from the outward normal, the curve's own or a face's, to the direction of drive g [rad]."""
    nx, ny = at.trace.normal(at.tangent, at.s, at.size)
    (gx, gy), _ = at.trace.direction(at.s, at.size)
    return np.arctan2(gx * ny - gy * nx, gx * nx + gy * ny)


def pitch_curvature(at: Sight) -> Any:
    """κ = T × S / |T|³ of the curve, run clockwise round the cam: convex positive [1/mm]."""
    _, (dx, dy), (ax, ay), *_ = at.point
    tx, ty = at.tangent
    # S = T' + J T, so that T × S = T × T' + |T|²
    return (at.square + ty * (ax + dy) - tx * (ay - dx)) / (at.square * at.speed)


def pitch_radius(at: Sight) -> Any:
    """|p|: how far the curve is from the cam's axis [mm]."""
    (px, py), *_ = at.point
    return np.sqrt(px * px + py * py)


def face_radius(at: Sight) -> Any:
    """ρ = T·m / m·m with m = n' + J n, n the face's unit normal, at the contact point [mm].

    The support function's way: where T runs against the turning face the profile is undercut, and
    ρ is negative; at a cusp it passes through 0. The curvature from T alone would be 1/|ρ|.
    """
    tx, ty = at.tangent
    mx, my = at.trace.face_turn(at.s, at.size)
    return (tx * mx + ty * my) / (mx * mx + my * my)


def contact(at: Sight) -> Any:
    """How far the contact point is along the face from where its reach is measured [mm]."""
    (px, py), *_ = at.point
    (mx, my), (ax, ay) = at.trace.face_axis(at.s, at.size)
    return (px - mx) * ax + (py - my) * ay


def _derivative(order: int) -> Formula:
    return lambda at: at.s[order]


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

    def on(self, seen: Sight, box: Box) -> Any:
        """Its model on boxes, from those of s and at least as many derivatives as it uses."""

    def at(self, seen: Sight, points: Points) -> Array:
        """Its values at points, from s to s''' there: (n,)."""


@dataclass(frozen=True)
class Quantity:
    """A function of the cam angle.

    Attributes:
        formula: its value from what is seen; of numbers or of models.
        order: highest derivative of s that it uses.
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

    def on(self, seen: Sight, box: Box) -> Taylor:
        """Its model on boxes."""
        found = self.formula(seen)
        return found if isinstance(found, Taylor) else seen.s[0].constant(found)

    def at(self, seen: Sight, points: Points) -> Array:
        """Its values at points."""
        return np.asarray(self.formula(seen))


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
    "contact_left": Quantity(lambda at: -contact(at), 1, smooth=1, share=1e-12),
    "contact_right": Quantity(contact, 1, smooth=1, share=1e-12),
}


def clearance(depth: float) -> Quantity:
    """(n · p − depth) |T|: positive where the curve's tangent passes the cam's axis that far off.

    With the axis on the inner side, and more than ``depth`` [mm] away.
    """
    return Quantity(lambda at: at.moment - depth * at.speed, 1)


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
    traces = {path: traced(machine, path) for path in {path for _, path in subjects}}
    scale = machine.follower.radius(size)

    def models(piece: Indices, lo: Array, hi: Array, wanted: Sequence[int]) -> list[Taylor]:
        highest = max(subjects[k][0].order for k in wanted)
        s = course.jets.models(piece, lo, hi, highest) + (0.0,) * (3 - highest)
        seen = {path: Sight(trace, size, s) for path, trace in traces.items()}
        asked = (subjects[k] for k in wanted)
        return [quantity.on(seen[path], (piece, lo, hi)) for quantity, path in asked]

    def values(piece: Indices, x: Array, wanted: Sequence[int]) -> list[Array]:
        s = tuple(course.curve.jet(x, piece, 3))
        seen = {path: Sight(trace, size, s) for path, trace in traces.items()}
        asked = (subjects[k] for k in wanted)
        return [quantity.at(seen[path], (piece, x)) for quantity, path in asked]

    enough = [quantity.absolute + quantity.share * scale for quantity, _ in subjects]
    return enclose(models, course.curve.breaks, course.counts, questions, values, enough)


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
        before, after = (Sight(trace, size, s).tangent for s in course.sides(int(joint)))
        turn = before[1] * after[0] - before[0] * after[1]
        if (turn > 0.0 and claim.upper is not None) or (turn < 0.0 and claim.lower is not None):
            return course.worst(1, np.array([joint]))
    return None
