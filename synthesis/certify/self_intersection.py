"""Whether a flank of the cam intersects itself, a line of the certificate for each flank.

A profile without undercut is shown to be simple in one of three ways, by what touches it:

* **Roller**: no position of the roller reaches into another part of the profile; proven by the
  search in ``roller_interference``, or without it where the curve runs round the axis clearly.
* **Knife edge**: the profile is the traced curve itself. The traced point moves along one line or
  arc of the machine, given by s. If its distance from the cam's axis is strictly monotone in s,
  equal distances mean equal s, so the same point of the machine and the same cam angle: the curve
  is simple. Checked by the sign of p · dp/ds.
* **Flat face**: the profile is the envelope of a line that, seen from the cam, turns steadily and
  once round. Where its radius, which divides by the rate of turning, is positive everywhere it is a
  closed convex curve with total curvature 2π, which is simple. So the limit ``profile_radius`` is
  sufficient, and no line is added here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Final

import numpy as np

from synthesis.catalogue.followers.kinematics import Flank, labelled
from synthesis.certify.quantities import MeasuredCam, Subject, tangent_clearance
from synthesis.certify.roller_interference import NearestPair, OffsetProfile, nearest_far_pair
from synthesis.design.design import Extreme
from synthesis.numerics.enclosure import Extremum, ExtremumQuery
from synthesis.units import DEGREE

SELF_CROSSING: Final = "self_crossing"
WIDEST: Final = 0.05  # interval on which a knife edge's path is examined [rad]


def check_self_intersection(cam: MeasuredCam, clear: Sequence[Flank] = ()) -> list[Extreme]:
    """A line per flank: how deep the roller cuts into another part of it, 0 where it does not.

    ``clear``: flanks already known to run round the axis clearly, see ``roller_clearances``.
    """
    if cam.machine.follower.always_convex:
        return []
    return [
        _check_edge(cam, flank)
        if flank.distance == 0.0
        else _no_interference(flank, 0)
        if flank in clear
        else _check_roller(flank, _nearest_pair(cam, flank))
        for flank in cam.machine.follower.flanks
    ]


def deepest_interference(cam: MeasuredCam) -> tuple[Flank, NearestPair] | None:
    """The flank into which its own roller cuts deepest, and where; None if there is none."""
    smooth, questions, subjects = roller_clearances(cam, 0)
    clear = clear_flanks(smooth, cam.enclose(subjects, questions))
    cut = [
        (flank, pair)
        for flank in cam.machine.follower.flanks
        if flank.distance > 0.0 and flank not in clear
        for pair in (_nearest_pair(cam, flank),)
        if pair.distance < flank.distance and not pair.excludes_interference(flank.distance)
    ]
    return max(cut, key=lambda each: each[0].distance - each[1].distance, default=None)


def roller_clearances(
    cam: MeasuredCam, first: int
) -> tuple[list[Flank], list[ExtremumQuery], list[Subject]]:
    """Questions for the least clearance of the tangents of traced curves from the axis.

    Of flanks under a roller; the argument needs a continuous tangent. Only the sign of the proven
    lower end matters, so any width suffices.

    Returns:
        the flanks, a question for each, and their subjects, which are numbered from ``first`` on.
    """
    follower = cam.machine.follower
    if follower.always_convex or not cam.motion.is_continuous_below(2):
        return [], [], []
    flanks = [flank for flank in follower.flanks if flank.distance > 0.0]
    everywhere = np.arange(cam.motion.curve.count)
    questions = [
        ExtremumQuery(everywhere, 0.0, math.inf, None, first + k, absolute=math.inf)
        for k in range(len(flanks))
    ]
    # the tangent must pass the axis at more than R where the profile lies inside the traced curve
    return (
        flanks,
        questions,
        [
            (tangent_clearance(max(flank.side * flank.distance, 0.0)), flank.path)
            for flank in flanks
        ],
    )


def clear_flanks(flanks: Sequence[Flank], answers: Sequence[Extremum]) -> list[Flank]:
    """Flanks that run round the axis clearly: without self-intersection unless undercut."""
    pairs = zip(flanks, answers, strict=True)
    return [flank for flank, answer in pairs if answer.enclosure.lower > 0.0]


def _nearest_pair(cam: MeasuredCam, flank: Flank) -> NearestPair:
    offset = flank.side * flank.distance
    trace = partial(flank.trace.position, z=cam.size)
    return nearest_far_pair(OffsetProfile(cam.motion, trace, offset))


def _no_interference(flank: Flank, pairs: int) -> Extreme:
    evidence = f"curvature, and {pairs} pairs of intervals: the roller reaches into no other part"
    return _line(flank, 0.0, evidence)


def _check_roller(flank: Flank, pair: NearestPair) -> Extreme:
    """The result of the search, as a depth."""
    if pair.excludes_interference(flank.distance):
        return _no_interference(flank, pair.pairs)
    if not math.isfinite(pair.distance):
        why = "the roller centre's path has no enclosed tangent here"
        return _line(flank, None, why, pair.profile_angle)
    depth = flank.distance - pair.distance
    if depth <= 0.0:
        why = f"neither found nor excluded in {pair.pairs} pairs of intervals"
        return _line(flank, None, why, pair.profile_angle)
    where = (
        f"at {pair.roller_angle / DEGREE:.6g}° the roller reaches into the profile of "
        f"{pair.profile_angle / DEGREE:.6g}°; {pair.pairs} pairs of intervals"
    )
    return _line(flank, depth, where, pair.profile_angle, pair.distance - pair.lower_bound)


def _check_edge(cam: MeasuredCam, flank: Flank) -> Extreme:
    """Whether the edge's distance from the axis is strictly monotone in s."""
    intervals = cam.motion.intervals(WIDEST)
    with np.errstate(all="ignore"):
        (s,) = cam.motion.jets.models(intervals.piece, intervals.lo, intervals.hi, 0)
        # with s' = 1 and s'' = s''' = 0 the derivative of p with respect to θ is dp/ds
        (px, py), (dx, dy), *_ = flank.trace.position((s, 0.0 * s + 1.0, 0.0, 0.0), cam.size)
        product = px * dx + py * dy
        high, low = product.range()
        outward, inward = low - product.rem, -high - product.rem
    grows, falls = (np.nan_to_num(each, nan=-np.inf) for each in (outward, inward))
    if grows.min() > 0.0 or falls.min() > 0.0:
        proof = f"the edge's distance from the axis is monotone in s, on {len(intervals)} intervals"
        return _line(flank, 0.0, proof)
    angle = float(intervals.lo[int(np.argmin(np.maximum(grows, falls)))])
    return _line(flank, None, "the edge's distance from the axis is not monotone in s", angle)


def _line(
    flank: Flank, depth: float | None, evidence: str, angle: float = 0.0, width: float = 0.0
) -> Extreme:
    """A line of the certificate: it holds where no interference is left, a depth of 0."""
    return Extreme(
        limit=labelled(SELF_CROSSING, flank.name), value=depth, unit="mm",
        angle_deg=angle / DEGREE, bound=0.0, margin=None if depth is None else 0.0 - depth,
        width=width, holds=depth == 0.0, evidence=evidence, field="base_radius_mm",
    )  # fmt: skip
