"""Pressure angle: between the common normal and the follower's direction of motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import inf, tan
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.followers.flank import labelled
from synthesis.followers.trace import leaning
from synthesis.limits.base import Claim, Limit, Machine, times, where
from synthesis.motion import Sense, Stretch
from synthesis.numerics.piecewise import Array
from synthesis.terms import Curved, Implied, Row
from synthesis.units import DEGREE

Degrees = Annotated[float, Field(gt=0.0, lt=90.0)]


class PressureAngle(Limit):
    """|α| ≤ the rise's limit on every rise, ≤ the return's on every return; dwells are free.

    Linear in the motion and the size together for a translating roller: |s' − e| ≤
    tan α_max (s0 + s). On an arm it is not: the follower then says it as curved. Rises and returns
    are the program's, for a counter cam too, which falls where the main cam rises.
    """

    kind: Literal["pressure_angle"] = "pressure_angle"
    title: ClassVar[str] = "Pressure angle"
    rise_deg: Degrees | None = Field(None, description="Largest |pressure angle| on rises.")
    return_deg: Degrees | None = Field(None, description="Largest |pressure angle| on returns.")
    dwell_deg: Degrees | None = Field(
        None, description="Largest |pressure angle| on dwells; left out, dwells are free."
    )

    @model_validator(mode="after")
    def _limits_something(self) -> PressureAngle:
        if self.rise_deg is self.return_deg is self.dwell_deg is None:
            raise PydanticCustomError(
                "no_angle_limited",
                "pressure_angle gives no limit. Give rise_deg, return_deg or dwell_deg, or leave "
                "the limit out.",
                {},
            )
        return self

    @property
    def keeps_large(self) -> bool:
        return self.rise_deg is not None or self.return_deg is not None

    def _largest(self, kind: Sense) -> float | None:
        """Limit on a kind of stretch [rad], None where it is free."""
        degrees = {"rise": self.rise_deg, "return": self.return_deg, "dwell": self.dwell_deg}[kind]
        return None if degrees is None else degrees * DEGREE

    def rows(self, stretch: Stretch, machine: Machine) -> tuple[Row, ...]:
        return tuple(
            replace(row, source=labelled(f"pressure_angle_{kind}", label))
            for kind in stretch.senses
            if (largest := self._largest(kind)) is not None
            for label, path in machine.follower.paths.items()
            for row in path.pressure_angle_rows(tan(largest))
        )

    def smooth(
        self, stretch: Stretch, machine: Machine, theta: Array, s: Any, z: Any
    ) -> tuple[Any, ...]:
        """What is curved, and of counter rollers that say nothing in rows |n × g| ≤ t n · g."""
        curves, companions = self.curved(stretch, machine), machine.follower.companions
        found: list[Any] = [value for curve in curves for value in curve.excess(s, z)]
        limits = [self._largest(kind) for kind in stretch.senses] if companions else []
        slope = min((tan(largest) for largest in limits if largest is not None), default=inf)
        for label in companions:
            path = machine.follower.paths[label]
            if slope == inf or path.pressure_angle_rows(slope):
                continue
            across, along = leaning(path, s, z)
            found += [across - slope * along, -across - slope * along]
        return tuple(found)

    def curved(self, stretch: Stretch, machine: Machine) -> tuple[Curved, ...]:
        return tuple(
            replace(curve, source=f"pressure_angle_{kind}")
            for kind in stretch.senses
            if (largest := self._largest(kind)) is not None
            for curve in machine.follower.pressure_angle_curves(tan(largest))
        )

    def implied(self, stretch: Stretch, machine: Machine) -> tuple[Implied, ...]:
        return tuple(curve for curve in self.curved(stretch, machine) if curve.implies)

    def claims(self, stretches: Sequence[Stretch], machine: Machine) -> tuple[Claim, ...]:
        kinds: tuple[Sense, ...] = ("rise", "return", "dwell")
        return tuple(
            Claim(
                labelled(f"pressure_angle_{kind}", path),
                "pressure_angle",
                moving,
                -largest,
                largest,
                "deg",
                times(1.0 / DEGREE),
                f"pressure_angle/{kind}_deg",
                path,
            )
            for path in machine.follower.paths
            for kind in kinds
            if (largest := self._largest(kind)) is not None and (moving := where(stretches, kind))
        )
