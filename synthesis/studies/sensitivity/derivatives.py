"""Derivatives of the optimal value by one number: by multipliers, and by finite differences.

Multipliers belong to one optimum and give one derivative; where a limit just begins to bind, the
one-sided derivatives differ, and multipliers give something between them. So the number is also
moved by a finite step either way and the problem solved again. Where the two methods disagree
nothing is reported.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from math import inf
from typing import Any, TypeVar

from pydantic import ValidationError

from synthesis.catalogue.fields import ends
from synthesis.design.design import Design
from synthesis.spec.design_spec import DesignSpec
from synthesis.studies.sensitivity.perturbation import PerturbedDesign

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
    """One number on which a design depends.

    Attributes:
        pointer: its JSON pointer. value: its value. size: the magnitude that steps are relative to.
        at: the spec with another value; None where that is no valid spec.
        range: least and largest value, of a number that was chosen.
    """

    pointer: str
    value: float
    size: float
    at: Callable[[float], DesignSpec | None]
    range: tuple[float, float] = (-inf, inf)


@dataclass(frozen=True)
class Derivatives:
    """Change of the objective per unit of a number.

    Attributes:
        more: right derivative. less: left derivative; both are equal where the objective is smooth.
            None: on that side there is no cam.
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

    def negligible(derivative: float) -> bool:
        return abs(derivative) * max(abs(number.value), 1.0) <= NEGLIGIBLE * abs(design.value)

    def without_rounding(*sides: float | None) -> Derivatives:
        return Derivatives(
            *(0.0 if side is not None and negligible(side) else side for side in sides)
        )

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
    for position, (parameter, value) in enumerate(zip(parameters, values, strict=True)):
        at = partial(_with_chosen, design.spec, values, position)
        size = _size(design.resolved_spec, value)
        yield Number(parameter.field, value, size, at, ends(parameter.requested))


def _with_chosen(
    spec: DesignSpec, values: list[float], position: int, value: float
) -> DesignSpec | None:
    moved = [*values[:position], value, *values[position + 1 :]]
    try:
        return spec.with_values(moved).without_deferred()
    except ValidationError:
        return None


def spec_numbers(spec: DesignSpec) -> Iterator[Number]:
    """The numbers of limits, of ranges of the size, and of windows and points."""
    document = spec.model_dump(mode="json", exclude_none=True)
    roots: list[Path] = [("limits",), ("base_radius_mm",)]
    roots += [("follower", name) for name in spec.follower.adjustable_dimensions()]
    segments = range(len(spec.program))
    roots += [("program", index, part) for index in segments for part in DEMANDS]
    for root in roots:
        for path in _numeric_leaves(_resolve(document, root), root):
            value = float(_resolve(document, path))
            exact = str(path[-1]).startswith("tolerance") and value == 0.0
            if path[-1] not in PLACES and not exact:
                pointer = "".join(f"/{part}" for part in path)
                yield Number(pointer, value, _size(spec, value), partial(_with_value, spec, path))


def _with_value(spec: DesignSpec, path: Path, value: float) -> DesignSpec | None:
    document = spec.model_dump(mode="json")
    _resolve(document, path[:-1])[path[-1]] = value
    try:
        return DesignSpec.model_validate(document).without_deferred()
    except ValidationError:
        return None


def _size(spec: DesignSpec, value: float) -> float:
    return max(abs(value), SMALL * spec.stroke())


def _resolve(at: Any, path: Path) -> Any:
    for key in path:
        at = at.get(key) if isinstance(at, dict) else at[key]
        if at is None:
            break
    return at


def _numeric_leaves(at: Any, path: Path) -> Iterator[Path]:
    if isinstance(at, dict):
        for key, inner in at.items():
            yield from _numeric_leaves(inner, (*path, key))
    elif isinstance(at, list):
        for index, inner in enumerate(at):
            yield from _numeric_leaves(inner, (*path, index))
    elif isinstance(at, float) and isinstance(path[-1], str):  # values of a table have no name
        yield path
