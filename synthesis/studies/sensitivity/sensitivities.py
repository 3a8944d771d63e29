"""sensitivities(design): what each limit costs, as derivatives and as sentences."""

from __future__ import annotations

import re
from collections.abc import Sequence
from math import inf

from synthesis.design.analysis import Sensitivities, Sensitivity
from synthesis.design.design import Design
from synthesis.numerics import clock
from synthesis.studies.sensitivity.derivatives import (
    Derivatives,
    Number,
    chosen_numbers,
    differentiate,
    spec_numbers,
)
from synthesis.studies.sensitivity.perturbation import (
    FixedKnots,
    PerturbedDesign,
    perturbed_designs,
)

SAME_CAM = 2e-3  # relative, beside the tolerance: a local optimum this near is the design itself
LEVEL = 0.02  # of the value, for a change of a chosen number by all of itself: less is stationary
AT_END = 1e-9  # of a chosen number: so near to an end of its range it is at the end
LARGE = 1000.0  # numbers from here on are changed by one per cent in sentences, not by one unit
UNIT = re.compile(r"(?P<name>.+)_(?P<unit>mm|deg|hz)(?P<per>_per_s(?P<power>[23])?)?")


def sensitivities(design: Design, deadline: float = inf) -> Sensitivities:
    """How the first objective changes with every limit and range of a finished design's spec.

    Args:
        design: the design.
        deadline: ``time.monotonic()`` at which to stop with what is known by then.

    Returns:
        derivatives on which multipliers and solving again agree; numbers where they do not are
        listed as ``unconfirmed``, and where nothing is known ``evidence`` says why.
    """
    proof = design.certificate
    if not design.motion or not proof.certified or proof.value is None:
        return _answer(design, [], [], "there is no certified cam")
    spec = design.resolved_spec.without_deferred()
    # The design must be the optimum of a program on its own knots.
    allowed = (SAME_CAM + design.spec.tolerance) * abs(proof.value)
    optima = perturbed_designs(FixedKnots.of(design, spec), spec, deadline)
    optimum = next((each for each in optima if abs(each.value - proof.value) <= allowed), None)
    if optimum is None:
        return _answer(
            design, [], [],
            "not known: the best that a local search finds on the design's own knots is another "
            "cam, as where a profile that crosses itself was made larger",
        )  # fmt: skip
    # Chosen numbers are held fixed, which is exact where the objective is stationary in them.
    kinks = [each for each in chosen_numbers(design) if not _is_stationary(optimum, each, deadline)]
    known, unconfirmed = list[tuple[Number, Derivatives]](), list[str]()
    for number in spec_numbers(design.resolved_spec):
        each = None if clock.now() >= deadline else differentiate(optimum, number, deadline)
        if each is None or (each.steepest > 0.0 and kinks):
            unconfirmed.append(number.pointer)
        else:
            known.append((number, each))
    return _answer(design, known, unconfirmed, _evidence(optimum, kinks))


def _is_stationary(optimum: PerturbedDesign, number: Number, deadline: float) -> bool:
    """Whether a chosen number does not move when limits change by little.

    Where the objective is level in it, or where it is held at an end of its range.
    """
    derivatives = differentiate(optimum, number, deadline)
    if derivatives is None:
        return False
    level = LEVEL * abs(optimum.value) / number.size
    low, high = number.range
    near = AT_END * number.size
    at_end = (derivatives.more or 0.0) > 0.0 and number.value <= low + near
    at_end = at_end or ((derivatives.less or 0.0) < 0.0 and number.value >= high - near)
    return at_end or (len(derivatives.sides) == 2 and derivatives.steepest <= level)


def _evidence(optimum: PerturbedDesign, kinks: Sequence[Number]) -> str:
    evidence = (
        f"{optimum.method} on the design's own knots, confirmed by solving again with each number "
        "a thousandth larger and smaller"
    )
    if kinks:
        evidence += (
            "; the angles, lifts or lengths that were chosen lie where several limits meet, and "
            "would move with these: what binds there is listed as unconfirmed"
        )
    return evidence


def _answer(
    design: Design,
    known: Sequence[tuple[Number, Derivatives]],
    unconfirmed: list[str],
    evidence: str,
) -> Sensitivities:
    """The answer, with the most expensive limit first."""
    objective = design.certificate.objective
    costs = sorted(known, key=lambda each: -each[1].steepest * max(abs(each[0].value), 1.0))
    return Sensitivities(
        objective=objective,
        value=design.certificate.value,
        sensitivities=[
            Sensitivity(
                field=number.pointer,
                requested=number.value,
                per_unit=each.more if each.more == each.less else None,
                per_unit_more=each.more,
                per_unit_less=each.less,
                sentence=describe(number, each, objective),
            )
            for number, each in costs
        ],
        unconfirmed=unconfirmed,
        evidence=evidence,
    )


def describe(number: Number, derivatives: Derivatives, objective: str) -> str:
    """A sentence: 1 deg more in /limits/0/rise_deg makes base_radius 0.8 mm smaller."""
    more, less = derivatives.more, derivatives.less
    if more == less == 0.0:
        return f"{number.pointer} has no influence"
    # One unit, or one per cent of a large number.
    parts = reversed(number.pointer.split("/"))
    step = f"1 {next((unit for part in parts if (unit := _split_unit(part)[1])), '')}"
    step = "1 %" if abs(number.value) >= LARGE else step
    if more is not None and more == less:
        return f"{step} more in {number.pointer} makes {_change(number, more, objective)}"
    sides = []
    for way, slope in (("more", more), ("less", None if less is None else -less)):
        if slope is None:
            sides.append(f"{way} has no cam near this one")
        elif slope == 0.0:
            sides.append(f"{way} changes nothing")
        else:
            sides.append(f"{step} {way} makes {_change(number, slope, objective)}")
    return f"{number.pointer} is at a kink: {'; '.join(sides)}"


def _change(number: Number, slope: float, objective: str) -> str:
    name, unit = _split_unit(objective)
    change = slope if abs(number.value) < LARGE else 0.01 * slope * abs(number.value)
    way = "larger" if change > 0.0 else "smaller"
    return f"{name} {abs(change):.4g} {unit} {way}"


def _split_unit(field: str) -> tuple[str, str]:
    """A field's name without its unit, and the unit: max and mm/s³ of max_mm_per_s3."""
    match = UNIT.fullmatch(field)
    if match is None:
        return field, ""
    power = {"2": "²", "3": "³"}.get(match["power"] or "", "")
    unit = match["unit"].replace("hz", "Hz")
    return match["name"], unit + (f"/s{power}" if match["per"] else "")
