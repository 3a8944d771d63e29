"""Base radius of the counter cam of a conjugate pair."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from synthesis.followers.base import Follower
from synthesis.followers.flank import Flank
from synthesis.limits.base import Claim, Limit, Machine, where
from synthesis.motion import Stretch
from synthesis.numerics.piecewise import Array
from synthesis.terms import Row


class CounterBaseRadius(Limit):
    """The counter cam's base radius ≥ ``min_mm``: its traced curve stays Rr + min off the axis."""

    kind: Literal["counter_base_radius"] = "counter_base_radius"
    title: ClassVar[str] = "Base radius of the counter cam"
    same_everywhere: ClassVar[bool] = True
    min_mm: Annotated[
        float, Field(ge=0.0, le=1e9, description="Smallest base radius of the counter cam.")
    ] = 0.0

    @property
    def keeps_large(self) -> bool:
        return True

    def suits(self, follower: Follower) -> bool:
        return bool(follower.companions)

    def rows(self, stretch: Stretch, machine: Machine) -> tuple[Row, ...]:
        return tuple(
            replace(row, source=self.kind)
            for flank in _counters(machine)
            for row in flank.trace.radius_rows(flank.distance + self.min_mm)
        )

    def smooth(
        self, stretch: Stretch, machine: Machine, theta: Array, s: Any, z: Any
    ) -> tuple[Any, ...]:
        if self.rows(stretch, machine):
            return ()
        found = []
        for flank in _counters(machine):
            least = flank.distance + self.min_mm
            (px, py), *_ = flank.trace.traced_point(s, z)
            square = px * px + py * py
            found.append((least * least - square) / (least * least + square))
        return tuple(found)

    def claims(self, stretches: Sequence[Stretch], machine: Machine) -> tuple[Claim, ...]:
        return tuple(
            Claim(
                self.kind, "pitch_radius", where(stretches), flank.distance + self.min_mm, None,
                "mm", _less(flank.distance), f"{self.kind}/min_mm", flank.path,
            )
            for flank in _counters(machine)
        )  # fmt: skip


def _counters(machine: Machine) -> Iterator[Flank]:
    """The flanks of counter cams."""
    for flank in machine.follower.flanks:
        if flank.path in machine.follower.companions:
            yield flank


def _less(distance: float) -> Callable[[float], float]:
    """The map that takes away ``distance``."""
    return lambda pitch: pitch - distance
