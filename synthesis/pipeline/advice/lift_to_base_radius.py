"""A cam that is small against its stroke while no pressure angle is limited."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from synthesis.pipeline.advice.rule import Finding, Rule, number
from synthesis.pipeline.advice.subject import Subject

USUAL: Final = 1.0  # stroke over base radius


def _find(subject: Subject) -> Iterator[Finding]:
    # Under a flat face on a slide the pressure angle is always that of its tilt.
    faced = subject.spec.follower.always_convex
    if faced or not subject.is_touched_from_outside or subject.base_radius_is_set:
        return
    meant = subject.limited("pressure_angle") or subject.minimises("peak_pressure_angle")
    ratio = subject.stroke / subject.base_radius
    if ratio > USUAL and not meant:
        yield Finding(
            "note",
            "limits/pressure_angle",
            f"The stroke is {number(ratio)} base radii, and no pressure angle is limited.",
            "Ask for the limit pressure_angle; without it nothing but curvature keeps the cam "
            "from shrinking.",
        )


RULE = Rule(
    code="lift_to_base_radius",
    thresholds="note: of rollers, the stroke above one base radius without a limit of the "
    "pressure angle.",
    reason="Flanks of such a cam are steep; whether too steep, the pressure angle says.",
    source="Rule of this program.",
    checked="No source was found.",
    silenced_by="the limit or objective of the pressure angle, or a base radius that is given or "
    "has a least value",
    find=_find,
)
