"""Jumps of velocity and of acceleration."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from synthesis.design.summary import PeakValue
from synthesis.design.warnings import Severity
from synthesis.pipeline.advice.rule import SMALL_ACCELERATION, Finding, Rule, number
from synthesis.pipeline.advice.subject import Subject

SEVERE_IMPACT, IMPACT = 0.1, 0.01  # m/s: speeds after a fall of 0.5 mm, and of 5 µm


class Jump(NamedTuple):
    """A jump of a derivative: its size [m/s, m/s²] along the path, cam angle, segment after it."""

    size: float
    angle_deg: float
    segment: int


def _find(subject: Subject) -> Iterator[Finding]:
    def jump(at: PeakValue | None) -> Jump | None:
        if at is None:
            return None
        return Jump(subject.in_metres(abs(at.value)), at.angle_deg, at.segment)

    if subject.spec.continuity is None:
        summary = subject.summary
        yield from find_jumps(
            jump(summary.velocity.largest_jump), jump(summary.acceleration.largest_jump)
        )


def find_jumps(
    velocity: Jump | None, acceleration: Jump | None, otherwise: str = ", or ask for continuity 2"
) -> Iterator[Finding]:
    """What is to be said of the largest jumps of velocity and acceleration.

    ``otherwise``: another remedy of a jump of acceleration.
    """
    severity: Severity
    if velocity is not None:
        size = velocity.size
        severity = "stop" if size > SEVERE_IMPACT else "caution" if size > IMPACT else "note"
        yield Finding(
            severity, f"program/{velocity.segment}",
            f"The velocity jumps by {number(size)} m/s at {number(velocity.angle_deg)}°: the "
            "acceleration is infinite there: an impact.",
            "Take a law that begins and ends at rest, or let the program choose it "
            '(law {"kind": "spline"}).',
        )  # fmt: skip
    if acceleration is not None:
        size = acceleration.size
        yield Finding(
            "caution" if size > SMALL_ACCELERATION else "note", f"program/{acceleration.segment}",
            f"The acceleration jumps by {number(size)} m/s² at {number(acceleration.angle_deg)}°: "
            "the jerk is infinite there, and excites vibration.",
            f"Take a law without jumps (cycloidal, modified sine, polynomial 3-4-5){otherwise}.",
        )  # fmt: skip


RULE = Rule(
    code="jumps",
    thresholds="velocity: stop above 0.1 m/s, caution above 0.01 m/s, note below; acceleration: "
    "caution above 0.98 m/s² (a tenth of the weight), note below.",
    reason="A jump of acceleration is an infinite jerk, that of velocity an impact (0.1 m/s as "
    "after a fall of 0.5 mm). Only at the lowest speeds can a machine take them.",
    source="Norton, fundamental law of cam design, as it is quoted: velocity and acceleration "
    "continuous, jerk finite over the whole turn.",
    checked="Quotations opened, one of them from p. 388 of the first edition, not the book. The "
    "limits are this program's.",
    silenced_by="`continuity` in the spec",
    find=_find,
)
