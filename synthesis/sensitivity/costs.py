"""What each limit costs: the change of the optimum with the numbers of the spec."""

from __future__ import annotations

from collections.abc import Iterable
from math import inf

from synthesis import clock
from synthesis.design import Design
from synthesis.findings import Sensitivities, Sensitivity
from synthesis.sensitivity.beside import Beside, besides
from synthesis.sensitivity.family import Family
from synthesis.sensitivity.numbers import Asked, Chosen, asked, chosen
from synthesis.sensitivity.slopes import Slopes, slopes
from synthesis.sensitivity.words import words

AGREES = 2e-3  # relative, beside the tolerance: what the optimum near a design may differ from it
SETTLED = 0.02  # of the value, for all of a chosen number: a slope that is none


def sensitivities(design: Design, deadline: float = inf) -> Sensitivities:
    """How the first objective changes with every limit and range of a finished design's spec.

    Args:
        design: the design.
        deadline: ``time.monotonic()`` at which to stop with what is known by then.

    Returns:
        slopes that multipliers and seeking again agree on; numbers of which they do not are listed
        as ``unconfirmed``, and where nothing is known ``evidence`` says why.
    """
    proof = design.certificate
    if not design.motion or not proof.certified or proof.value is None:
        return _told(design, [], [], "there is no certified cam")
    spec = design.numbered.alone()
    allowed = (AGREES + design.spec.tolerance) * abs(proof.value)
    found = besides(Family.of(design, spec), spec, deadline)
    beside = next((each for each in found if abs(each.value - proof.value) <= allowed), None)
    if beside is None:
        return _told(
            design, [], [],
            "not known: the best that a local search finds on the design's own knots is another "
            "cam, as where a profile that crosses itself was made larger",
        )  # fmt: skip
    kinks = [each for each in chosen(design) if not _at_rest(beside, each, deadline)]
    known, unconfirmed = list[Sensitivity](), list[str]()
    for number in asked(design.numbered):
        each = None if clock.now() >= deadline else slopes(beside, number, deadline)
        if each is None or (each.steepest > 0.0 and kinks):
            unconfirmed.append(number.pointer)
        else:
            known.append(_sensitivity(number, each, proof.objective))
    return _told(design, known, unconfirmed, _evidence(beside, kinks))


def _at_rest(beside: Beside, number: Chosen, deadline: float) -> bool:
    """Whether a number that was chosen stays where it is when limits change by little.

    That is where the objective is level in it, or where it is held at an end of its range.
    """
    found = slopes(beside, number, deadline)
    if found is None:
        return False
    level = SETTLED * abs(beside.value) / number.size
    low, high = number.ends
    near = 1e-9 * number.size
    held = (found.more or 0.0) > 0.0 and number.asked <= low + near
    held = held or ((found.less or 0.0) < 0.0 and number.asked >= high - near)
    return held or (len(found.sides) == 2 and found.steepest <= level)


def _evidence(beside: Beside, kinks: list[Chosen]) -> str:
    said = (
        f"{beside.method} on the design's own knots, confirmed by seeking that again with each "
        "number a thousandth larger and smaller"
    )
    if kinks:
        said += (
            "; the angles, lifts or lengths that were chosen lie where several limits meet, and "
            "would move with these: what binds there is listed as unconfirmed"
        )
    return said


def _sensitivity(number: Asked, found: Slopes, objective: str) -> Sensitivity:
    return Sensitivity(
        field=number.pointer,
        asked=number.asked,
        per_unit=found.more if found.more == found.less else None,
        per_unit_more=found.more,
        per_unit_less=found.less,
        words=words(number, found, objective),
    )


def _told(
    design: Design, found: Iterable[Sensitivity], unconfirmed: list[str], evidence: str
) -> Sensitivities:
    """The dearest first."""

    def weight(each: Sensitivity) -> float:
        sides = [abs(side) for side in (each.per_unit_more, each.per_unit_less) if side is not None]
        return max(sides, default=0.0) * max(abs(each.asked), 1.0)

    return Sensitivities(
        objective=design.certificate.objective,
        value=design.certificate.value,
        sensitivities=sorted(found, key=lambda each: -weight(each)),
        unconfirmed=unconfirmed,
        evidence=evidence,
    )
