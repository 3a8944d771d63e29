"""Numbers that look as if they had been typed in another unit."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from synthesis.catalogue.limits.pressure_angle import PressureAngle
from synthesis.pipeline.advice.rule import Finding, Rule, number
from synthesis.pipeline.advice.subject import Subject
from synthesis.spec.schedule import MOST_IN_RADIANS
from synthesis.units import DEGREE

MOST_LIFTS: Final = 100.0  # base radius over stroke
LEAST_SHARE: Final = 0.01  # stroke over roller radius


def _find(subject: Subject) -> Iterator[Finding]:
    angles = list[float]()
    for limit in subject.limits("pressure_angle"):
        assert isinstance(limit, PressureAngle)
        given = (limit.rise_deg, limit.return_deg, limit.dwell_deg)
        angles += [angle for angle in given if angle is not None]
    if angles and max(angles) < MOST_IN_RADIANS:
        meant = number(max(angles) / DEGREE)
        yield Finding(
            "caution", "limits/pressure_angle",
            f"All pressure angles allowed are below {MOST_IN_RADIANS}°: {number(max(angles))}° is "
            "far less than any cam needs, and looks like radians.",
            f"If radians were meant, write {meant} for {number(max(angles))}: angles are in "
            "degrees.",
        )  # fmt: skip
    roller, stroke = subject.spec.follower.roller_radius_mm, subject.stroke
    if stroke < LEAST_SHARE * roller:
        yield Finding(
            "caution", "program",
            f"The stroke of {number(stroke)} mm is below a hundredth of the roller radius of "
            f"{number(roller)} mm: one of them looks like another unit.",
            "Lengths are in mm: 1 in is 25.4 mm, 1 m is 1000 mm.",
        )  # fmt: skip
    chosen = subject.has_cam and not subject.base_radius_is_set
    if chosen and subject.base_radius > MOST_LIFTS * stroke:
        times = number(subject.base_radius / stroke)
        yield Finding(
            "caution", "limits",
            f"The base radius of {number(subject.base_radius)} mm is {times} strokes: a limit is "
            "far tighter than usual, or in another unit.",
            "Look for a limit in radians, m or s in place of degrees, mm or min; see which limits "
            "are used up.",
        )  # fmt: skip


RULE = Rule(
    code="unit_suspicion",
    thresholds="caution: all pressure angles allowed below 1.6° (π/2 rad is 1.57); a stroke below "
    "1 % of the roller radius; a chosen base radius above 100 strokes.",
    reason="A number in radians, inches or metres gives a cam that is right for the question and "
    "useless for the machine.",
    source="Rule of this program: no cam of the textbooks comes near these values.",
    checked="By 600 everyday cams of two authors (tests/hard/everyday.py, trades.py).",
    silenced_by="a base radius that is given, or has a least value (the third)",
    find=_find,
    without_cam=True,
)
