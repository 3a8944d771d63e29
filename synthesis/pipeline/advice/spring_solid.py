"""How near the spring comes to its solid length."""

from __future__ import annotations

from collections.abc import Iterator

from synthesis.catalogue.forces.load_parts import SlideSpring
from synthesis.pipeline.advice.rule import Finding, Rule, number
from synthesis.pipeline.advice.subject import Subject

CLASH, CLOSE = 0.10, 0.15  # of the largest compression: what is left until the coils touch


def _find(subject: Subject) -> Iterator[Finding]:
    load, reduced = subject.spec.load, subject.spec.machine().load
    spring = None if load is None else load.spring
    if reduced is None or not isinstance(spring, SlideSpring) or spring.solid_mm is None:
        return
    if reduced.rate <= 0.0:
        return
    # Under a cam touched from outside the lift compresses it further; in a ring it slackens.
    most = reduced.preload / reduced.rate + (subject.stroke if reduced.side > 0 else 0.0)
    left = spring.solid_mm / most - 1.0
    if left < CLOSE:
        within = (
            f"{number(100.0 * left)} % before its coils touch"
            if left > 0.0
            else "beyond where its coils touch"
        )
        yield Finding(
            "stop" if left <= 0.0 else "caution" if left < CLASH else "note", "load/spring",
            f"The spring is compressed by up to {number(most)} mm (preload over rate, plus the "
            f"stroke), {within} at {number(spring.solid_mm)} mm.",
            "Take a longer spring, or one with a higher rate and less compression at the lowest "
            "position.",
        )  # fmt: skip


RULE = Rule(
    code="spring_solid",
    thresholds="stop: the largest compression, preload over rate plus the stroke, beyond "
    "`load/spring/solid_mm`; caution: less than 10 % before it; note: less than 15 %.",
    reason="Coils that touch make a rigid stop of the spring; near it they clash, and its rate "
    "grows.",
    source="me_toolbox, a package of machine-design formulas (HelicalCompressionSpring.Fsolid): "
    "solid at 1.15 times the largest force; a university lecture on springs: clash allowance of "
    "10 to 15 %.",
    checked="Both opened, and two programs that take 10 % of the working travel, and 1/7, what is "
    "left of a spring that is used to 7/8 of its way to solid. The numbers are said to be "
    "Shigley's and Norton's, whose books could not be opened.",
    silenced_by="`solid_mm` left out",
    find=_find,
)
