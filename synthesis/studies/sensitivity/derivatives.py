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
from typing import Any

from pydantic import ValidationError

from synthesis.catalogue.ranges import ends
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
    tangent = _by_multipliers(design, number)
    if tangent is None:
        return None
    # A number that the optimum does not feel, on either side, needs no solving.
    if _negligible(design, number, tangent) and _remains_optimal(design, number):
        return Derivatives(0.0, 0.0)
    for share in STEPS:
        step = share * number.size
        noise = 2.0 * design.noise * abs(design.value) / step
        differences = _by_differences(design, number, step, deadline)
        # Smooth: both sides agree with the multipliers, which are the more accurate.
        if differences.sides and all(_agree(tangent, each, noise) for each in differences.sides):
            more, less = (
                None if side is None else tangent for side in (differences.more, differences.less)
            )
            return _without_rounding(design, number, Derivatives(more, less))
    if not differences.sides:
        return None
    # A kink: the multipliers must lie between the one-sided derivatives.
    least, most = min(differences.sides), max(differences.sides)
    allowed = AGREEMENT * max(abs(least), abs(most)) + noise
    if len(differences.sides) == 2 and not least - allowed <= tangent <= most + allowed:
        return None
    return _without_rounding(design, number, differences)


def _by_multipliers(design: PerturbedDesign, number: Number) -> float | None:
    """By first-order estimates a little to both sides, or to the one side that exists."""
    step, values, places = TANGENT_STEP * number.size, [], []
    for move in (step, -step):
        spec = number.at(number.value + move)
        value = None if spec is None else design.estimate(spec)
        if value is not None:
            values.append(value)
            places.append(move)
    if len(values) == 1:
        values.append(design.value)
        places.append(0.0)
    return (values[0] - values[1]) / (places[0] - places[1]) if values else None


def _by_differences(
    design: PerturbedDesign, number: Number, step: float, deadline: float
) -> Derivatives:
    """By solving the problem again on both sides."""
    sides: list[float | None] = []
    for move in (step, -step):
        spec = number.at(number.value + move)
        value = None if spec is None else design.solve(spec, deadline)
        sides.append(None if value is None else (value - design.value) / move)
    return Derivatives(*sides)


def _remains_optimal(design: PerturbedDesign, number: Number) -> bool:
    """Whether the optimum keeps the limits on both sides, where these make sense."""
    step = STEPS[0] * number.size
    moved = [number.at(number.value + move) for move in (step, -step)]
    return all(spec is None or design.remains_optimal(spec) for spec in moved)


def _agree(one: float, other: float, noise: float) -> bool:
    return abs(one - other) <= AGREEMENT * max(abs(one), abs(other)) + noise


def _negligible(design: PerturbedDesign, number: Number, derivative: float) -> bool:
    return abs(derivative) * max(abs(number.value), 1.0) <= NEGLIGIBLE * abs(design.value)


def _without_rounding(
    design: PerturbedDesign, number: Number, derivatives: Derivatives
) -> Derivatives:
    """With 0 for negligible derivatives."""

    def each(derivative: float | None) -> float | None:
        if derivative is None:
            return None
        return 0.0 if _negligible(design, number, derivative) else float(derivative)

    return Derivatives(each(derivatives.more), each(derivatives.less))


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
