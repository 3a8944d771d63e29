"""Torque on the camshaft."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from synthesis.catalogue.followers.kinematics import pressure_angle_sine_cosine
from synthesis.catalogue.forces.reduced import MILLI
from synthesis.catalogue.limits.base import Claim, Machine
from synthesis.catalogue.limits.force import ForceLimit, drive, load_of, transmission
from synthesis.catalogue.motion import PlacedSegment, Segments
from synthesis.numerics.piecewise import Array


class CamshaftTorque(ForceLimit):
    """|T| ≤ ``max_n_m`` at every cam angle: T = G s', with friction G s' λ cos α/(λ cos α − …).

    A product of two derivatives of the law: no row says it, nor is it eased by a larger cam.
    """

    kind: Literal["camshaft_torque"] = "camshaft_torque"
    title: ClassVar[str] = "Camshaft torque"
    max_n_m: Annotated[float, Field(gt=0.0, le=1e12, description="Largest |torque|.")]

    def smooth_constraints(
        self, segment: PlacedSegment, machine: Machine, theta: Array, s: Any, z: Any
    ) -> tuple[Any, ...]:
        flank, friction = machine.follower.flanks[0], load_of(machine).friction
        power = drive(segment, machine, theta, s) * s[1] * (MILLI / self.max_n_m)
        if friction is None:
            return power - 1.0, -power - 1.0
        _, cosine = pressure_angle_sine_cosine(flank.trace, s, z)
        grip = transmission(flank.trace, segment, machine, s, z)
        return power * cosine - grip, -power * cosine - grip

    def claims(self, segments: Segments, machine: Machine) -> tuple[Claim, ...]:
        return (self._claim(segments, (-self.max_n_m, self.max_n_m), "max_n_m", "N m"),)
