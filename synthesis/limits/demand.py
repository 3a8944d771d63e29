"""A bound that one segment alone has to keep, on a part of it: what windows and points ask for."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf
from typing import ClassVar, Literal

from synthesis.limits.base import Claim, Limit, Machine, times
from synthesis.motion import Stretch
from synthesis.terms import Row, derivative

EXACT = 1e-9  # of lift/β^k: what one value may differ from another by rounding
TRAVEL = 0
NAMES = ("travel", "velocity", "acceleration", "jerk")
FIELDS = {
    "mm": ("travel_mm", "velocity_mm_per_s", "acceleration_mm_per_s2", "jerk_mm_per_s3"),
    "deg": ("travel_deg", "velocity_deg_per_s", "acceleration_deg_per_s2", "jerk_deg_per_s3"),
}
QUANTITIES = ("travel", "velocity", "acceleration", "jerk")


class Demand(Limit):
    """min ≤ one derivative ≤ max on a part of one segment; equal where both are.

    Attributes:
        segment: index of the segment in the program.
        place: where it stands in the segment, as in ``windows/0``.
        field: path of what sets it, from the program on.
        order: 0 for the travel since the segment's start, positive in the sense of the move;
            k for the k-th derivative by time, positive away from the cam's axis.
        part: first and last x of the segment, in [0, 1]; equal for a point.
        min, max: bounds in the wire's units, None where there is none.
    """

    kind: Literal["demand"] = "demand"
    title: ClassVar[str] = "Window or point of one segment"
    segment: int
    place: str
    field: str
    order: int
    part: tuple[float, float]
    min: float | None = None
    max: float | None = None

    @property
    def exact(self) -> bool:
        """Whether one value is asked for."""
        return self.min is not None and self.min == self.max

    @property
    def name(self) -> str:
        """Name in the certificate: segment, window or point, quantity, and side if it is one."""
        where = self.place.replace("s/", "_")
        side = "_max" if self.min is None else "_min" if self.max is None else ""
        return f"program_{self.segment}_{where}_{NAMES[self.order]}{side}"

    def unit(self, stretch: Stretch, machine: Machine) -> float:
        """Natural size of the quantity on the wire: lift ω^k/β^k."""
        return abs(stretch.lift) / stretch.angle**self.order * machine.rate(self.order)

    def _factor(self, stretch: Stretch, machine: Machine) -> float:
        """What the derivative per radian is multiplied by to give the wire's value."""
        backwards = self.order == TRAVEL and stretch.lift < 0.0
        return -machine.rate(TRAVEL) if backwards else machine.rate(self.order)

    def rows(self, stretch: Stretch, machine: Machine) -> tuple[Row, ...]:
        if stretch.index != self.segment:
            return ()
        factor = self._factor(stretch, machine)
        start = factor * stretch.s_start if self.order == TRAVEL else 0.0
        sides = ((1.0, self.max), (-1.0, None if self.exact else self.min))
        scale = abs(factor)
        room = inf if self.min is None or self.max is None else (self.max - self.min) / scale
        return tuple(
            Row(
                derivative(self.order, sign * factor / scale), (), sign * (value + start) / scale,
                source=self.name, part=self.part, exact=self.exact, room=room,
            )
            for sign, value in sides
            if value is not None
        )  # fmt: skip

    def widened(self, amount: float) -> Demand:
        low = None if self.min is None else self.min - amount
        high = None if self.max is None else self.max + amount
        return self.model_copy(update={"min": low, "max": high})

    def claims(self, stretches: Sequence[Stretch], machine: Machine) -> tuple[Claim, ...]:
        stretch = next((s for s in stretches if s.index == self.segment), None)
        if stretch is None:
            return ()
        factor = self._factor(stretch, machine)
        start = factor * stretch.s_start if self.order == TRAVEL else 0.0
        spare = EXACT * self.unit(stretch, machine) if self.exact else 0.0
        low = None if self.min is None else (self.min - spare + start) / factor
        high = None if self.max is None else (self.max + spare + start) / factor
        if factor < 0.0:
            low, high = high, low
        return (
            Claim(
                self.name, QUANTITIES[self.order], (self.segment,), low, high,
                machine.told(self.order), _moved(factor, start), self.field,
                part=self.part, exact=self.exact,
            ),
        )  # fmt: skip


def _moved(factor: float, start: float) -> Callable[[float], float]:
    """The map from a derivative per radian to the wire's value."""
    return times(factor) if start == 0.0 else lambda value: value * factor - start
