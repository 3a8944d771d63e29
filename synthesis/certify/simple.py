"""The judge's word on a cam that cuts itself.

Three reasons why a profile that is nowhere undercut does not cross itself:

* **Roller**: no position of the roller reaches into another part of the profile; searched and
  proven in ``self_crossing``.
* **Knife edge**: the profile is the traced curve itself. The traced point moves along one line
  or arc of the machine, given by s. If its distance from the cam's axis grows with s all along
  (or falls all along, as a counter roller's may), equal distances mean equal s, the same point of
  the machine, and so the same cam angle: the curve is simple. Measured: the sign of p · dp/ds.
* **Flat face**: the profile is the envelope of a line that turns steadily, once round, as seen
  from the cam. Where its radius is positive everywhere it is a convex curve of total turning 2π,
  and such a curve is simple (its support function is the face's distance); were the turning to
  stop anywhere, the radius, which divides by it, could not be enclosed. So the local
  condition, ``profile_radius``, says it all, and nothing is added here.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Final

import numpy as np

from synthesis.certify.course import Course
from synthesis.certify.path import Boxes, Path, Trace
from synthesis.certify.quantities import Measurable, Size, clearance, enclose_all
from synthesis.certify.self_crossing import Nearest, nearest
from synthesis.design import Extreme
from synthesis.followers.flank import Flank, labelled
from synthesis.limits.base import Machine
from synthesis.numerics.enclosure import Answer, Question
from synthesis.units import DEGREE

CROSSING: Final = "self_crossing"
WIDEST: Final = 0.05  # boxes of a knife edge's path [rad]
MORE: Final = 1.0 + 1e-12  # more than the roundings of a comparison


def rounding(course: Course, machine: Machine) -> list[Flank]:
    """Flanks of which it is worth asking whether their curves go round the axis well apart."""
    if machine.follower.always_convex or not course.joined(2):
        return []
    return [flank for flank in machine.follower.flanks if flank.distance > 0.0]


def rounds_axis(
    course: Course, flanks: Sequence[Flank], first: int
) -> tuple[list[Question], list[tuple[Measurable, str]]]:
    """Asks by how much traced curves' tangents pass the axis far enough off, all round.

    Returns:
        questions and their subjects, the functions from number ``first`` on.
    """
    everywhere = np.arange(course.curve.count)
    questions = [
        Question(everywhere, 0.0, math.inf, None, first + k, absolute=math.inf)
        for k in range(len(flanks))
    ]
    return questions, [(clearance(depth(flank)), flank.path) for flank in flanks]


def apart(flanks: Sequence[Flank], answers: Iterable[Answer]) -> list[Flank]:
    """Those whose curves go round the axis well apart: tangent and profile pass it on one side."""
    told = zip(flanks, answers, strict=True)
    return [flank for flank, answer in told if answer.extreme.lower > 0.0]


def depth(flank: Flank) -> float:
    """What that distance has to be more than: how deep the profile lies below the curve [mm]."""
    return MORE * max(flank.side * flank.distance, 0.0)


def crosses(
    course: Course, machine: Machine, size: Size, clear: Sequence[Flank] = ()
) -> list[Extreme]:
    """Whether a flank crosses itself, one extreme for each: how deep the roller cuts into it.

    Its value is 0 where no position of the roller reaches into the flank. ``clear``: flanks known
    to go round the axis well apart.
    """
    if machine.follower.always_convex:
        return []
    return [
        _edge(course, flank, size)
        if flank.distance == 0.0
        else _apart(flank, 0)
        if flank in clear
        else _roller(flank, approach(course, flank, size))
        for flank in machine.follower.flanks
    ]


def deepest(course: Course, machine: Machine, size: Size) -> tuple[Flank, Nearest] | None:
    """The flank that its own roller cuts deepest, and where; None where none is found."""
    if machine.follower.always_convex:
        return None
    rounds = rounding(course, machine)
    questions, subjects = rounds_axis(course, rounds, 0)
    clear = apart(rounds, enclose_all(subjects, course, machine, size, questions))
    flanks = [each for each in machine.follower.flanks if each.distance > 0.0 and each not in clear]
    found = [(flank, approach(course, flank, size)) for flank in flanks]
    cut = [
        (flank, near)
        for flank, near in found
        if near.least < flank.distance and not near.holds_off(flank.distance)
    ]
    return max(cut, key=lambda pair: pair[0].distance - pair[1].least, default=None)


def approach(course: Course, flank: Flank, size: Size) -> Nearest:
    """How near a roller of positive radius comes to far parts of its flank."""
    return nearest(Path(course, _trace(flank, size), flank.side * flank.distance))


def _trace(flank: Flank, size: Size) -> Trace:
    return lambda s: flank.trace.traced_point(s, size)


def _apart(flank: Flank, pairs: int) -> Extreme:
    """It is proven that the roller cuts into nothing."""
    proof = f"curvature and {pairs} pairs of boxes: no position of the roller reaches in"
    return _extreme(flank, 0.0, 0.0, 0.0, True, proof)


def _roller(flank: Flank, found: Nearest) -> Extreme:
    """What the search found, as depth."""
    if found.holds_off(flank.distance):
        return _apart(flank, found.pairs)
    if not math.isfinite(found.least):
        why = "the roller's path has no tangent there"
        return _extreme(flank, None, found.profile, 0.0, False, why)
    deep = flank.distance - found.least
    if deep <= 0.0:
        why = f"not excluded in {found.pairs} pairs"
        return _extreme(flank, None, found.profile, 0.0, False, why)
    where = (
        f"at {found.roller / DEGREE:.6g}° the roller reaches into the profile of "
        f"{found.profile / DEGREE:.6g}°; {found.pairs} pairs of boxes"
    )
    return _extreme(flank, deep, found.profile, found.least - found.lower, False, where)


def _edge(course: Course, flank: Flank, size: Size) -> Extreme:
    """Whether the edge's distance from the axis grows with s all along, or falls all along."""
    boxes = Boxes.of(course, WIDEST)
    with np.errstate(all="ignore"):
        (s,) = course.jets.models(boxes.piece, boxes.lo, boxes.hi, 0)
        (px, py), (dx, dy), *_ = flank.trace.traced_point((s, 0.0 * s + 1.0, 0.0, 0.0), size)
        product = px * dx + py * dy
        high, low, *_ = product.extremes()
        outward, inward = low - product.rem, -high - product.rem
    grows, falls = (np.nan_to_num(each, nan=-np.inf) for each in (outward, inward))
    if grows.min() > 0.0 or falls.min() > 0.0:
        proof = f"the edge's distance from the axis changes one way with s, on {len(boxes)} boxes"
        return _extreme(flank, 0.0, 0.0, 0.0, True, proof)
    angle = float(boxes.lo[int(np.argmin(np.maximum(grows, falls)))])
    why = "the edge's distance from the axis does not change one way with s"
    return _extreme(flank, None, angle, 0.0, False, why)


def _extreme(
    flank: Flank, deep: float | None, angle: float, width: float, holds: bool, evidence: str
) -> Extreme:
    return Extreme(
        limit=labelled(CROSSING, flank.name), value=deep, unit="mm", angle_deg=angle / DEGREE,
        bound=0.0, margin=None if deep is None else 0.0 - deep, width=width, holds=holds,
        evidence=evidence, field="base_radius_mm",
    )  # fmt: skip
