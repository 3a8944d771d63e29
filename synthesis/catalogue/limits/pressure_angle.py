"""Pressure angle: between the common normal and the follower's direction of motion."""

from __future__ import annotations

from dataclasses import replace
from math import inf, tan
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.constraints import LinearInequality, NonconvexConstraints
from synthesis.catalogue.followers.base import paths
from synthesis.catalogue.followers.kinematics import labelled, pressure_angle_sine_cosine
from synthesis.catalogue.limits.base import Claim, Limit, Machine, scaling, segment_indices
from synthesis.catalogue.motion import PlacedSegment, Segments, Sense
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

Degrees = Annotated[float, Field(gt=0.0, lt=90.0)]


class PressureAngle(Limit):
    """|α| ≤ the rise's limit on every rise, ≤ the return's on every return; dwells are free.

    Rises and returns are the program's, for a counter cam too, which falls where the main cam
    rises.

    Note:
        Linear in the motion and the size together for a translating roller: |s' − e| ≤ tan α_max
        (s0 + s). On an arm it is not: the follower then says it as curved.
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
            )
        return self

    @property
    def bounds_size_below(self) -> bool:
        return self.rise_deg is not None or self.return_deg is not None

    def _largest(self, kind: Sense) -> float | None:
        """Limit on a kind of segment [rad], None where it is free."""
        degrees = {"rise": self.rise_deg, "return": self.return_deg, "dwell": self.dwell_deg}[kind]
        return None if degrees is None else degrees * DEGREE

    def rows(self, segment: PlacedSegment, machine: Machine) -> tuple[LinearInequality, ...]:
        return tuple(
            replace(row, source=labelled(f"pressure_angle_{kind}", label))
            for kind in segment.senses
            if (largest := self._largest(kind)) is not None
            for label, path in paths(machine.follower).items()
            for row in path.pressure_angle_rows(tan(largest))
        )

    def smooth_constraints(
        self, segment: PlacedSegment, machine: Machine, theta: Array, s: Any, z: Any
    ) -> tuple[Any, ...]:
        """What is curved, and of counter rollers that have no rows: |n × g| ≤ t n · g."""
        found = list(super().smooth_constraints(segment, machine, theta, s, z))
        limits = filter(None, map(self._largest, segment.senses))
        slope = min(map(tan, limits), default=inf)
        for label in machine.follower.closure.counter_paths:
            path = paths(machine.follower)[label]
            if slope == inf or path.pressure_angle_rows(slope):
                continue
            across, along = pressure_angle_sine_cosine(path, s, z)
            found += [across - slope * along, -across - slope * along]
        return tuple(found)

    def nonconvex(self, segment: PlacedSegment, machine: Machine) -> NonconvexConstraints:
        return tuple(
            replace(curve, source=f"pressure_angle_{kind}")
            for kind in segment.senses
            if (largest := self._largest(kind)) is not None
            for curve in machine.follower.pressure_angle_constraints(tan(largest))
        )

    def claims(self, segments: Segments, machine: Machine) -> tuple[Claim, ...]:
        kinds: tuple[Sense, ...] = ("rise", "return", "dwell")
        return tuple(
            self._claim(
                segments, (-largest, largest), f"{kind}_deg", "deg", name=f"pressure_angle_{kind}",
                label=path, to_wire=scaling(1.0 / DEGREE), path=path, indices=moving,
            )
            for path in paths(machine.follower)
            for kind in kinds
            if (largest := self._largest(kind)) is not None
            and (moving := segment_indices(segments, kind))
        )  # fmt: skip
