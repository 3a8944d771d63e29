"""Advice: what an engineer would say of a finished cam, by the rules of the field.

In: a ``Design``. Out: the same with its warnings, the most severe first. Each rule is a file and a
line in ``RULES``; open ``rule`` first. A rule is silent where the user has set on purpose what it
would warn of. ``docs/warnings.md`` is made of ``RULES``.
"""

from __future__ import annotations

from typing import Final

from synthesis.design.design import Design
from synthesis.design.warnings import worst
from synthesis.pipeline.advice import (
    contact_force,
    contact_pressure,
    gap_open,
    hub,
    jumps,
    knife_edge,
    lift_to_base_radius,
    period_ratio,
    pressure_angle,
    roller_speed,
    rough_motion,
    sharp_nose,
    spring_solid,
    unit_suspicion,
)
from synthesis.pipeline.advice.rule import Rule, judge
from synthesis.pipeline.advice.subject import Subject

RULES: Final[tuple[Rule[Subject], ...]] = (
    unit_suspicion.RULE,
    contact_force.RULE,
    spring_solid.RULE,
    contact_pressure.RULE,
    hub.RULE,
    sharp_nose.RULE,
    knife_edge.RULE,
    jumps.RULE,
    rough_motion.RULE,
    pressure_angle.RULE,
    roller_speed.RULE,
    lift_to_base_radius.RULE,
    period_ratio.RULE,
    gap_open.RULE,
)
"""All rules; of two findings of one severity that of the earlier rule comes first."""


def with_warnings(design: Design) -> Design:
    """The same design with its warnings, and the severity of the worst."""
    # A copy is judged: what it computes once would outlive a later change of the design's spec.
    subject = Subject(design.model_copy())
    found = judge((rule for rule in RULES if subject.has_cam or rule.without_cam), subject)
    return design.model_copy(update={"warnings": found, "severity": worst(found)})
