"""The judge's word on a cam that cuts itself.

Three reasons why a profile that is nowhere undercut does not cross itself:

* **Roller**: no position of the roller reaches into another part of the profile; searched and
  proven in ``self_crossing``.
* **Knife edge**: the profile is the traced curve itself. The traced point moves along one line
  or arc of the machine, given by s. If its distance from the cam's axis grows with s all along,
  equal distances mean equal s, the same point of the machine, and so the same cam angle: the
  curve is simple. Measured: p · dp/ds > 0 for all s that occur.
* **Flat face**: the profile is the envelope of a line that turns steadily, once round, as seen
  from the cam. Where its radius is positive everywhere it is a convex curve of total turning 2π,
  and such a curve is simple (its support function is the face's distance). So the local
  condition, ``profile_radius``, says it all, and nothing is added here.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from synthesis.certify.course import Course
from synthesis.certify.path import Boxes, Path, Trace
from synthesis.certify.quantities import Size
from synthesis.certify.self_crossing import Nearest, nearest
from synthesis.design import Extreme
from synthesis.limits.base import Machine
from synthesis.units import DEGREE

CROSSING: Final = "self_crossing"
WIDEST: Final = 0.05  # boxes of a knife edge's path [rad]


def crosses(course: Course, machine: Machine, size: Size) -> list[Extreme]:
    """Whether the profile crosses itself, as one extreme: how deep the roller cuts into the cam.

    Its value is 0 where no position of the roller reaches into the profile.
    """
    if machine.follower.always_convex:
        return []
    if machine.follower.roller_radius == 0.0:
        return [_edge(course, _trace(machine, size))]
    return [_roller(approach(course, machine, size), machine.follower.roller_radius)]


def approach(course: Course, machine: Machine, size: Size) -> Nearest:
    """How near a roller of positive radius comes to far parts of the profile."""
    return nearest(Path(course, _trace(machine, size), machine.follower.roller_radius))


def _trace(machine: Machine, size: Size) -> Trace:
    return lambda s: machine.follower.traced_point(s, size)


def _roller(found: Nearest, radius: float) -> Extreme:
    """What the search found, as depth."""
    if found.holds_off(radius):
        proof = f"curvature and {found.pairs} pairs of boxes: no position of the roller reaches in"
        return _extreme(0.0, 0.0, 0.0, True, proof)
    if not math.isfinite(found.least):
        return _extreme(None, found.profile, 0.0, False, "the roller's path has no tangent there")
    deep = radius - found.least
    if deep <= 0.0:
        return _extreme(None, found.profile, 0.0, False, f"not excluded in {found.pairs} pairs")
    where = (
        f"at {found.roller / DEGREE:.6g}° the roller reaches into the profile of "
        f"{found.profile / DEGREE:.6g}°; {found.pairs} pairs of boxes"
    )
    return _extreme(deep, found.profile, found.least - found.lower, False, where)


def _edge(course: Course, trace: Trace) -> Extreme:
    """Whether the knife edge moves away from the axis wherever s grows."""
    boxes = Boxes.of(course, WIDEST)
    with np.errstate(all="ignore"):
        (s,) = course.jets.models(boxes.piece, boxes.lo, boxes.hi, 0)
        one = 0.0 * s + 1.0
        (px, py), (dx, dy), *_ = trace((s, one, 0.0, 0.0))
        product = px * dx + py * dy
        _, least, *_ = product.extremes()
        least = least - product.rem
    least = np.where(np.isfinite(least), least, -np.inf)
    worst = int(np.argmin(least))
    if least[worst] > 0.0:
        proof = f"the edge moves away from the axis as s grows, on {len(boxes)} boxes"
        return _extreme(0.0, 0.0, 0.0, True, proof)
    angle = float(boxes.lo[worst])
    return _extreme(
        None, angle, 0.0, False, "where s grows the edge does not move away from the axis"
    )


def _extreme(deep: float | None, angle: float, width: float, holds: bool, evidence: str) -> Extreme:
    return Extreme(
        limit=CROSSING, value=deep, unit="mm", angle_deg=angle / DEGREE, bound=0.0,
        margin=None if deep is None else 0.0 - deep, width=width, holds=holds,
        evidence=evidence, field="base_radius_mm",
    )  # fmt: skip
