"""Pressure angles where none is limited."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from synthesis.catalogue.limits.pressure_angle import PressureAngle
from synthesis.catalogue.motion import Sense
from synthesis.design.warnings import Severity
from synthesis.pipeline.advice.rule import Finding, Rule, number
from synthesis.pipeline.advice.subject import Subject

SLIDE, ARM = 30.0, 35.0  # deg: what the field asks for, of a slide and of an arm
SLIDE_MOST, ARM_MOST = 38.0, 50.0  # deg: the most that any of its books allows
JAM: Final = 70.0  # deg: tan 70° μ (2A + B)/B = 1 at μ = 0.12 and an overhang A of the guide's B
ARM_JAM: Final = 89.3  # deg: cos 89.3° = μ r/l at μ = 0.12 and a pin r of a tenth of the arm l
SPRING_NOTE, SPRING_CAUTION = 45.0, 70.0  # deg, where a spring drives and the cam only yields


def _find(subject: Subject) -> Iterator[Finding]:
    set_fields = {
        name
        for limit in subject.limits("pressure_angle")
        if isinstance(limit, PressureAngle)
        for name in ("rise_deg", "return_deg")
        if getattr(limit, name) is not None
    }
    for sense in ("rise", "return"):
        field = f"{sense}_deg"
        if field not in set_fields:
            yield from _on(subject, sense, field)


def _on(subject: Subject, sense: Sense, field: str) -> Iterator[Finding]:
    mask = subject.on(sense)
    if not mask.any():
        return
    curves = subject.pressure_angles_deg
    path = max(curves, key=lambda name: float(curves[name][mask].max()))
    angles = np.where(mask, curves[path], 0.0)
    at = int(np.argmax(angles))
    found = float(angles[at])
    advised, most = usual_angles(subject.is_arm)
    severity: Severity | None = None
    if sense == "return" and subject.is_force_closed:
        severity = "note" if found > max(SPRING_NOTE, advised) else None
        severity = "caution" if found > SPRING_CAUTION else severity
    elif found > advised:
        locks = found > (ARM_JAM if subject.is_arm else JAM) and _friction_is_open(subject)
        severity = "stop" if locks else "caution" if found > most else "note"
    remedy = f"Ask for the limit pressure_angle with {field} of {number(advised)}"
    remedy += (
        ", and for a larger base radius." if subject.base_radius_is_set else ": the cam grows."
    )
    if subject.minimises("peak_pressure_angle"):
        remedy = "It is the least for these dimensions: allow a larger cam, or give more angle."
    locked = "it would lock on its pivot" if subject.is_arm else "the slide would jam in its guide"
    if severity is not None:
        which = f" of the {path} roller" if path else ""
        yield Finding(
            severity, f"limits/pressure_angle/{field}",
            f"The pressure angle{which} on the {sense} comes to {number(found)}° at "
            f"{number(subject.degrees_at(at))}°; {number(advised)}° is usual for "
            f"{'an arm' if subject.is_arm else 'a slide'}"
            + (f": {locked}." if severity == "stop" else "."),
            remedy,
        )  # fmt: skip


def usual_angles(swings: bool) -> tuple[float, float]:
    """What the field asks for, and the most that any of its books allows [deg]."""
    return (ARM, ARM_MOST) if swings else (SLIDE, SLIDE_MOST)


def _friction_is_open(subject: Subject) -> bool:
    """Whether nothing is said of friction, by which the rule contact_force would judge."""
    load = subject.spec.machine().load
    return load is None or load.friction is None


RULE = Rule(
    code="pressure_angle",
    thresholds="note: above 30° on a slide, above 35° on an arm; caution: above 38°, above 50°; "
    "stop: where the cam pushes and no friction is given, above 70° on a slide, above 89.3° on an "
    "arm. On returns that a spring or weight drives: note above 45°, caution above 70°.",
    reason="The share of the force across the motion grows with tan α; it wears the guide, and at "
    "μ = 0.12 with an overhang as long as the guide a slide jams at 70°. On an arm friction acts "
    "at the radius of the pivot's pin: with a tenth of the arm it locks at 89.3°.",
    source="Norton, in the help of his program DYNACAM: about 30° translating, 35° oscillating; a "
    "course in Chinese: 30 to 38° and 40 to 50°, 70 to 80° on returns that a spring drives. "
    "Jamming: statics of a guide with friction, docs/forces.md.",
    checked="Both opened, and a text made of the Cam Design Handbook (Rothbart, ed., 2004), ch. "
    "6, which has the angle of jamming: 73° at μ = 0.1, the same formula. 45° and the pin of a "
    "tenth of the arm are this program's; that at 90° no force moves a follower is in Norton's "
    "excerpt.",
    silenced_by="the limit pressure_angle with rise_deg (rises) or return_deg (returns)",
    find=_find,
)
