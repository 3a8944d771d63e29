"""A design's certificate, line by line."""

from __future__ import annotations

from collections import defaultdict

from flint import arb

from synthesis.confirmation.arithmetic import BITS, degree, exactly
from synthesis.confirmation.claims import measured
from synthesis.confirmation.course import ExactCourse
from synthesis.confirmation.crossing import crossing
from synthesis.confirmation.promises import promise
from synthesis.confirmation.report import Confirmation, Remeasured, Verdict
from synthesis.confirmation.ringing import ringing
from synthesis.confirmation.subject import DIGITS, Measured, Subject
from synthesis.design import Design, Extreme
from synthesis.errors import InputError
from synthesis.limits.base import Claim


def confirmed(design: Design) -> Confirmation:
    """Measure every line of a design's certificate again."""
    with exactly():
        subject = _subject(design)
        claims = _claims(design)
        lines = [_line(extreme, _measured(subject, extreme, claims)) for extreme in design.extremes]
    return Confirmation(
        id=design.id,
        name=design.name,
        verdict=_verdict(lines),
        bits=BITS,
        lines=lines,
    )


def _subject(design: Design) -> Subject:
    if not design.motion:
        raise InputError(
            "/motion", [], "This design has no cam: there is nothing to measure.",
            "Confirm a design whose status is optimal or feasible.",
        )  # fmt: skip
    size = tuple(arb(z) for z in design.size)
    link = design.built.follower.link(size, degree())
    if link is None:
        raise InputError(
            "/follower", design.follower, "This follower is not described as a bare mechanism yet.",
            "Its certificate cannot be confirmed; it stands by itself.",
        )  # fmt: skip
    return Subject(design, link, ExactCourse(design))


def _claims(design: Design) -> dict[tuple[str, str], list[Claim]]:
    """What the limits claim, by limit and field, in the certificate's order."""
    spec, found = design.built, defaultdict[tuple[str, str], list[Claim]](list)
    machine, stretches = spec.machine(), design.curve.stretches
    for limit in spec.all_limits():
        for claim in limit.claims(stretches, machine):
            found[claim.limit, claim.field].append(claim)
    reach = machine.follower.displacement_measure(tuple(design.size))
    if reach is not None:
        everywhere = tuple(s.index for s in stretches if s.angle > 0.0)
        standing = Claim(
            "reach", reach.quantity, everywhere, reach.lower, reach.upper, reach.unit,
            reach.to_wire, "follower",
        )  # fmt: skip
        found["reach", "follower"].append(standing)
    return found


def _measured(
    subject: Subject, extreme: Extreme, claims: dict[tuple[str, str], list[Claim]]
) -> Measured:
    if extreme.limit.startswith("self_crossing"):
        return crossing(subject, extreme)
    asked = claims.get((extreme.limit, extreme.field))
    if asked:
        claim = asked.pop(0)
        return (ringing if claim.rings else measured)(subject, claim, extreme)
    return promise(extreme)(subject, extreme)


def _line(extreme: Extreme, found: Measured) -> Remeasured:
    value = width = apart = None
    if found.low is not None and found.high is not None:
        middle = (found.low + found.high) / 2
        value, width = middle.str(DIGITS, radius=False), float(found.high - found.low)
        apart = None if extreme.value is None else float(middle - arb(extreme.value))
    return Remeasured(
        limit=extreme.limit, field=extreme.field, unit=extreme.unit, value=value, width=width,
        angle_deg=found.angle, certificate=extreme.value, difference=apart, holds=found.holds,
        agrees=found.agrees, how=found.how,
    )  # fmt: skip


def _verdict(lines: list[Remeasured]) -> Verdict:
    verdicts = [line.agrees for line in lines]
    if False in verdicts:
        return "contradicted"
    return "incomplete" if None in verdicts else "confirmed"
