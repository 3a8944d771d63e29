"""How what is best changes with one number: by multipliers, and sought again on both sides.

Multipliers belong to one optimum and give one slope; where a limit just begins to bind the slopes
to both sides differ, and multipliers give something between. So every number is also moved by a
finite step either way and the optimum sought again. What the two do not agree on is not told.
"""

from __future__ import annotations

from dataclasses import dataclass

from synthesis.sensitivity.beside import Beside
from synthesis.sensitivity.numbers import Number

TANGENT = 1e-5  # relative step of the multipliers' slope: rounding and curvature both below 1e-9
STEPS = (1e-3, 2e-4)  # relative, at which the optimum is sought again; the second in doubt
AGREES = 0.02  # of the larger: what two slopes may differ by and be the same
FELT = 1e-5  # relative to the value, for a change of a number by all of itself: less is rounding


@dataclass(frozen=True)
class Slopes:
    """Change of the objective for one unit of a number.

    Attributes:
        more: for one unit more. less: towards one unit less, as a change per unit more, so that
            both are equal where the objective is smooth. None: on that side there is no cam.
    """

    more: float | None
    less: float | None

    @property
    def sides(self) -> list[float]:
        """Those that there are."""
        return [each for each in (self.more, self.less) if each is not None]

    @property
    def steepest(self) -> float:
        """The larger of their sizes."""
        return max(map(abs, self.sides), default=0.0)


def slopes(beside: Beside, number: Number, deadline: float) -> Slopes | None:
    """Both slopes; None where the two ways to them disagree, or neither side has a cam."""
    tangent = _tangent(beside, number)
    if tangent is None:
        return None
    if _rounding(beside, number, tangent) and _idle(beside, number):
        return Slopes(0.0, 0.0)
    for share in STEPS:
        step = share * number.size
        doubt = 2.0 * beside.noise * abs(beside.value) / step
        found = _sought(beside, number, step, deadline)
        if found.sides and all(_alike(tangent, each, doubt) for each in found.sides):
            more, less = (None if side is None else tangent for side in (found.more, found.less))
            return _told(beside, number, Slopes(more, less))
    if not found.sides:
        return None
    least, most = min(found.sides), max(found.sides)
    allowed = AGREES * max(abs(least), abs(most)) + doubt
    if len(found.sides) == 2 and not least - allowed <= tangent <= most + allowed:
        return None
    return _told(beside, number, found)


def _tangent(beside: Beside, number: Number) -> float | None:
    """By multipliers, from what is stated a little to both sides, or to the one that there is."""
    step, values, places = TANGENT * number.size, [], []
    for move in (step, -step):
        spec = number.at(number.asked + move)
        value = None if spec is None else beside.to_first_order(spec)
        if value is not None:
            values.append(value)
            places.append(move)
    if len(values) == 1:
        values.append(beside.value)
        places.append(0.0)
    return (values[0] - values[1]) / (places[0] - places[1]) if values else None


def _sought(beside: Beside, number: Number, step: float, deadline: float) -> Slopes:
    """By seeking the optimum again to both sides."""
    found: list[float | None] = []
    for move in (step, -step):
        spec = number.at(number.asked + move)
        value = None if spec is None else beside.sought(spec, deadline)
        found.append(None if value is None else (value - beside.value) / move)
    return Slopes(*found)


def _idle(beside: Beside, number: Number) -> bool:
    """Whether the optimum itself keeps the limits on both sides, where these make sense."""
    step = STEPS[0] * number.size
    beyond = [number.at(number.asked + move) for move in (step, -step)]
    return all(spec is None or beside.stays(spec) for spec in beyond)


def _alike(one: float, other: float, doubt: float) -> bool:
    return abs(one - other) <= AGREES * max(abs(one), abs(other)) + doubt


def _rounding(beside: Beside, number: Number, slope: float) -> bool:
    return abs(slope) * max(abs(number.asked), 1.0) <= FELT * abs(beside.value)


def _told(beside: Beside, number: Number, found: Slopes) -> Slopes:
    """With 0 for what is rounding."""

    def each(slope: float | None) -> float | None:
        if slope is None:
            return None
        return 0.0 if _rounding(beside, number, slope) else float(slope)

    return Slopes(each(found.more), each(found.less))
