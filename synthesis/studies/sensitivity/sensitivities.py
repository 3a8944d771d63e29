"""sensitivities(design): what each limit costs, as derivatives and as sentences.

Derivatives of the optimal value by one number come by multipliers, and by finite differences.
Multipliers belong to one optimum and give one derivative; where a limit just begins to bind, the
one-sided derivatives differ, and multipliers give something between them. So the number is also
moved by a finite step either way and the problem solved again. Where the two methods disagree
nothing is reported.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial, reduce
from math import inf
from operator import getitem
from typing import Any, TypeVar

from pydantic import ValidationError

from synthesis.catalogue.fields import ends
from synthesis.design.analysis import Sensitivities, Sensitivity
from synthesis.design.design import Design
from synthesis.numerics import clock
from synthesis.spec.design_spec import RADII, DesignSpec
from synthesis.studies.sensitivity.perturbation import (
    FixedKnots,
    PerturbedDesign,
    perturbed_designs,
)
from synthesis.units import split_unit

SAME_CAM = 2e-3  # relative, beside the tolerance: a local optimum this near is the design itself
LEVEL = 0.02  # of the value, for a change of a chosen number by all of itself: less is stationary
AT_END = 1e-9  # of a chosen number: so near to an end of its range it is at the end
LARGE = 1000.0  # numbers from here on are changed by one per cent in sentences, not by one unit
TANGENT_STEP = 1e-5  # relative: for the multipliers; rounding and curvature are both below 1e-9
STEPS = (1e-3, 2e-4)  # relative: of the finite differences; the second one where in doubt
AGREEMENT = 0.02  # of the larger: difference of two derivatives that count as equal
NEGLIGIBLE = 1e-5  # of the value, for a change of the number by all of itself: less is rounding
SMALL = 0.1  # of the stroke: size of a number near 0
DEMANDS = ("windows", "points")  # of a segment
PLACES = ("from_deg", "to_deg", "angle_deg")  # of these: knots of a law, which are fixed

Path = tuple[str | int, ...]
T = TypeVar("T")


@dataclass(frozen=True)
class Number:
    """One number on which a design depends, by its JSON pointer.

    ``size``: the magnitude that steps are relative to; ``at``: the spec with another value, None
    where that is no valid spec; ``range``: least and largest value, of a number that was chosen.
    """

    pointer: str
    value: float
    size: float
    at: Callable[[float], DesignSpec | None]
    range: tuple[float, float] = (-inf, inf)


@dataclass(frozen=True)
class Derivatives:
    """Change of the objective per unit of a number: its right and its left derivative.

    They are equal where the objective is smooth; None: on that side there is no cam.
    """

    more: float | None
    less: float | None

    @property
    def sides(self) -> list[float]:
        """Those that exist."""
        return [each for each in (self.more, self.less) if each is not None]

    @property
    def steepest(self) -> float:
        """The larger magnitude."""
        return max(map(abs, self.sides), default=0.0)


def differentiate(design: PerturbedDesign, number: Number, deadline: float) -> Derivatives | None:
    """Both derivatives; None where the two methods disagree, or neither side has a cam."""

    def on_both_sides(step: float, function: Callable[[DesignSpec], T]) -> list[T | None]:
        specs = (number.at(number.value + move) for move in (step, -step))
        return [None if spec is None else function(spec) for spec in specs]

    def negligible(side: float | None) -> bool:
        size = 0.0 if side is None else abs(side) * max(abs(number.value), 1.0)
        return side is not None and size <= NEGLIGIBLE * abs(design.value)

    def without_rounding(*sides: float | None) -> Derivatives:
        return Derivatives(*(0.0 if negligible(side) else side for side in sides))

    # Multipliers: first-order estimates a little to both sides, or to the one side that exists.
    step = TANGENT_STEP * number.size
    above, below = on_both_sides(step, design.estimate)
    if above is None and below is None:
        return None
    above, width = (design.value, step) if above is None else (above, 2.0 * step)
    below, width = (design.value, step) if below is None else (below, width)
    tangent = (above - below) / width
    # A number that the optimum does not feel, on either side, needs no solving.
    if negligible(tangent) and False not in on_both_sides(
        STEPS[0] * number.size, design.remains_optimal
    ):
        return Derivatives(0.0, 0.0)
    for share in STEPS:
        # Finite differences, by solving the problem again on both sides.
        step = share * number.size
        noise = 2.0 * design.noise * abs(design.value) / step
        values = on_both_sides(step, partial(design.solve, deadline=deadline))
        differences = Derivatives(
            *(None if value is None else (value - design.value) / move
              for value, move in zip(values, (step, -step), strict=True))
        )  # fmt: skip
        sides = differences.sides
        # Smooth: both sides agree with the multipliers, which are the more accurate.
        if sides and all(
            abs(tangent - each) <= AGREEMENT * max(abs(tangent), abs(each)) + noise
            for each in sides
        ):
            return without_rounding(*(None if value is None else tangent for value in values))
    if not sides:
        return None
    # A kink: the multipliers must lie between the one-sided derivatives.
    allowed = AGREEMENT * differences.steepest + noise
    if len(sides) == 2 and not min(sides) - allowed <= tangent <= max(sides) + allowed:
        return None
    return without_rounding(differences.more, differences.less)


def chosen_numbers(design: Design) -> Iterator[Number]:
    """The angles, lifts and lengths that the spec leaves free and a design has chosen."""
    parameters = design.spec.free_parameters.parameters if design.free_parameters else ()
    values = [design.free_parameters[parameter.field] for parameter in parameters]

    def with_chosen(position: int, value: float) -> DesignSpec:
        return design.spec.with_values([*values[:position], value, *values[position + 1 :]])

    for position, (parameter, value) in enumerate(zip(parameters, values, strict=True)):
        number = _number(design.resolved_spec, parameter.field, value,
                         partial(with_chosen, position))  # fmt: skip
        yield replace(number, range=ends(parameter.requested))


def spec_numbers(spec: DesignSpec) -> Iterator[Number]:
    """The numbers of limits, of ranges of the size, and of windows and points."""
    leaves = list(_numeric_leaves(spec.model_dump(mode="json", exclude_none=True), ()))
    roots: list[Path] = [("limits",), *((name,) for name in RADII)]
    roots += [("follower", name) for name in spec.follower.adjustable_dimensions()]
    roots += [("program", index, part) for index in range(len(spec.program)) for part in DEMANDS]

    def with_value(path: Path, value: float) -> DesignSpec:
        document: Any = spec.model_dump(mode="json")
        reduce(getitem, path[:-1], document)[path[-1]] = value
        return DesignSpec.model_validate(document)

    for root in roots:
        for path, value in leaves:
            exact = str(path[-1]).startswith("tolerance") and value == 0.0
            if path[: len(root)] == root and path[-1] not in PLACES and not exact:
                pointer = "".join(f"/{part}" for part in path)
                yield _number(spec, pointer, value, partial(with_value, path))


def _number(
    spec: DesignSpec, pointer: str, value: float, changed: Callable[[float], DesignSpec]
) -> Number:
    """A number of a spec; ``changed``: the spec with another value."""

    def at(value: float) -> DesignSpec | None:
        try:
            return changed(value).without_deferred()
        except ValidationError:
            return None

    return Number(pointer, value, max(abs(value), SMALL * spec.stroke()), at)


def _numeric_leaves(at: Any, path: Path) -> Iterator[tuple[Path, float]]:
    """Every number of a document that has a name, as values of a table have not."""
    inside = at.items() if isinstance(at, dict) else enumerate(at) if isinstance(at, list) else ()
    for key, inner in inside:
        yield from _numeric_leaves(inner, (*path, key))
    if isinstance(at, float) and isinstance(path[-1], str):
        yield path, at


def sensitivities(design: Design, deadline: float = inf) -> Sensitivities:
    """How the main objective changes with every limit and range of a finished design's spec.

    ``deadline``: ``time.monotonic()`` at which to stop with what is known by then.

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
    evidence = (
        f"{optimum.method} on the design's own knots, confirmed by solving again with each number "
        "a thousandth larger and smaller"
    )
    if optimum.knots.caps:
        held = (each.objective.name_on_wire(spec.machine()) for each in optimum.knots.caps)
        evidence += f"; {', '.join(held)} no larger than now"
    if kinks:
        evidence += (
            "; the angles, lifts or lengths that were chosen lie where several limits meet, and "
            "would move with these: what binds there is listed as unconfirmed"
        )
    return _answer(design, known, unconfirmed, evidence)


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
    units = (split_unit(part)[1] for part in reversed(number.pointer.split("/")))
    unit = "%" if abs(number.value) >= LARGE else next(filter(None, units), "")
    step = f"1 {unit}".rstrip()
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
    name, unit = split_unit(objective)
    change = slope if abs(number.value) < LARGE else 0.01 * slope * abs(number.value)
    way = "larger" if change > 0.0 else "smaller"
    return " ".join(filter(None, (name, f"{abs(change):.4g}", unit, way)))
