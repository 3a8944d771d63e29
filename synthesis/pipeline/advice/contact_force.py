"""Whether the follower stays on its cam, with what reserve, and whether its guide jams."""

from __future__ import annotations

from collections.abc import Iterator
from math import sqrt
from typing import Final

from synthesis.pipeline.advice.rule import Finding, Rule, number
from synthesis.pipeline.advice.subject import Subject

RESERVE: Final = sqrt(1.2)  # of speed: inertia grows with its square, 1.2 times what lifts it off


def _find(subject: Subject) -> Iterator[Finding]:
    forces, load = subject.design.forces, subject.spec.machine().load
    if forces is None or load is None:
        return
    if forces.floats:
        worst = min(forces.floats, key=lambda arc: arc.lowest_n)
        count = len(forces.floats)
        arcs = f"on {count} arcs, the worst " if count > 1 else ""
        need = "a stronger spring" if load.preload > 0.0 or load.rate > 0.0 else "a spring"
        yield Finding(
            "stop", "load/spring",
            f"The follower leaves its cam {arcs}from {number(worst.start_deg)}° to "
            f"{number(worst.end_deg)}°: {number(-worst.lowest_n)} N are missing at "
            f"{number(worst.angle_deg)}°.",
            f"Give {need}, ask for the limit contact_force (then the spring can be left free), or "
            "guide the follower both ways: a groove, conjugate cams.",
        )  # fmt: skip
        return
    infinite = subject.summary.acceleration.rms is None
    if load.friction is not None and forces.flanks[0].largest_n is None and not infinite:
        yield Finding(
            "stop",
            "load/friction",
            "The guide locks: at some cam angle friction takes more than the cam can push.",
            "Limit the pressure angle, or make the guide longer and the overhang shorter.",
        )
        return
    onset, speed = forces.float_onset_rpm, subject.spec.speed_rpm
    meant = subject.limited("contact_force") or load.speeds[1] > load.speeds[0]
    if onset is not None and onset < RESERVE * speed and not meant:
        yield Finding(
            "note", "load/spring",
            f"The follower leaves its cam from {number(onset)} rpm on, "
            f"{number(100.0 * (onset / speed - 1.0))} % above the cam's {number(speed)} rpm.",
            "Give a stronger spring, or limit the contact force (limit contact_force, min_n).",
        )  # fmt: skip


RULE = Rule(
    code="contact_force",
    thresholds="stop: the contact force would be negative somewhere (the follower floats), or "
    "friction locks the guide; note: the follower floats from less than 1.1 times the speed on.",
    reason="A force-closed cam can only push. A follower that has left it returns with an "
    "impact. The note is a spring of less than 1.2 times the inertia that separates them.",
    source="Statics: a force-closed cam can only push. SEED design guide, Cam mechanisms, section "
    "15: spring force 1.2 to 2 times the largest separating force.",
    checked="SEED opened (co-design.co.uk). That the follower then jumps is so in Sankyo's "
    "glossary of cams and in an excerpt of Norton's Cam Design and Manufacturing Handbook, ch. 9; "
    "both opened.",
    silenced_by="the limit contact_force, or a range of speeds in the load (the note)",
    find=_find,
)
