"""Derivatives of the optimal value by one number: by multipliers, and by finite differences.

Multipliers belong to one optimum and give one derivative; where a limit just begins to bind, the
one-sided derivatives differ, and multipliers give something between them. So the number is also
moved by a finite step either way and the problem solved again. Where the two methods disagree
nothing is reported.
"""

from __future__ import annotations

from dataclasses import dataclass

from synthesis.studies.sensitivity.perturbation import PerturbedDesign
from synthesis.studies.sensitivity.spec_numbers import Number

TANGENT_STEP = 1e-5  # relative: for the multipliers; rounding and curvature are both below 1e-9
STEPS = (1e-3, 2e-4)  # relative: of the finite differences; the second one where in doubt
AGREEMENT = 0.02  # of the larger: difference of two derivatives that count as equal
NEGLIGIBLE = 1e-5  # of the value, for a change of the number by all of itself: less is rounding


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
