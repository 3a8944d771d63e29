"""How fast the roller turns on its pin."""

from __future__ import annotations

import math
from collections.abc import Iterator

from synthesis.pipeline.advice.rule import Finding, Rule, number
from synthesis.pipeline.advice.subject import Subject

FAST, TOO_FAST = 1e5, 2.5e5  # mm/min: outer diameter times speed of a track roller


def _find(subject: Subject) -> Iterator[Finding]:
    turning = [
        (2.0 * flank.roller, found.roller_speed_rpm)
        for flank, found in subject.flanks
        if found.roller_speed_rpm is not None
    ]
    products = [(diameter * abs(peak.value), diameter, peak) for diameter, peak in turning]
    if not products:
        return
    _, diameter, peak = max(products, key=lambda one: one[0])
    yield from find_speed(diameter, abs(peak.value), "follower/roller_radius_mm")


def find_speed(diameter: float, rpm: float, field: str) -> Iterator[Finding]:
    """What is to be said of a roller of this diameter [mm]; ``field``: where it is given."""
    product = diameter * rpm
    if product > FAST:
        yield Finding(
            "caution" if product > TOO_FAST else "note", field,
            f"The roller of {number(diameter)} mm diameter turns on its pin at up to "
            f"{number(rpm)} rpm, so that its surface runs at {number(surface(product))} m/s; above "
            f"{number(surface(FAST))} it is taken for fast, above {number(surface(TOO_FAST))} for "
            "too fast.",
            "Compare with the limiting speed of your roller. A larger roller turns more slowly; "
            "a smaller cam or a lower speed helps too.",
        )  # fmt: skip


def surface(product: float) -> float:
    """Speed of a roller's surface [m/s], of its diameter times its speed [mm/min]."""
    return math.pi * product / 60e3


RULE = Rule(
    code="roller_speed",
    thresholds="caution: outer diameter times speed above 250 000 mm/min; note: above 100 000.",
    reason="Grease, seals and cage of a track roller bear a limited speed.",
    source="Rule of this program: the rolling surface at 5 m/s, and at 13 m/s. Makers' catalogues "
    "give each roller its limiting speed.",
    checked="Catalogues of SKF, INA, NTN, Nadella and McGill were found, their tables of speeds "
    "could not be opened: look up your own roller.",
    silenced_by="nothing: the spec has no field for it",
    find=_find,
)
