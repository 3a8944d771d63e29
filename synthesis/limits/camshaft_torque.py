"""Torque on the camshaft."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from synthesis.followers.trace import leaning
from synthesis.forces.reduced import MILLI
from synthesis.limits.base import Claim, Machine, times, where
from synthesis.limits.force import ForceLimit, drive, loaded, yielding
from synthesis.motion import Stretch
from synthesis.numerics.piecewise import Array


class CamshaftTorque(ForceLimit):
    """|T| ≤ ``max_n_m`` at every cam angle: T = G s', with friction G s' λ cos α/(λ cos α − …).

    A product of two derivatives of the law: no row says it, nor is it eased by a larger cam.
    """

    kind: Literal["camshaft_torque"] = "camshaft_torque"
    title: ClassVar[str] = "Camshaft torque"
    max_n_m: Annotated[float, Field(gt=0.0, le=1e12, description="Largest |torque|.")]

    def smooth(
        self, stretch: Stretch, machine: Machine, theta: Array, s: Any, z: Any
    ) -> tuple[Any, ...]:
        flank, friction = machine.follower.flanks[0], loaded(machine).friction
        power = drive(stretch, machine, theta, s) * s[1] * (MILLI / self.max_n_m)
        if friction is None:
            return power - 1.0, -power - 1.0
        _, cosine = leaning(flank.trace, s, z)
        grip = yielding(flank.trace, stretch, machine, s, z)
        return power * cosine - grip, -power * cosine - grip

    def claims(self, stretches: Sequence[Stretch], machine: Machine) -> tuple[Claim, ...]:
        return (
            Claim(
                self.kind, self.kind, where(stretches), -self.max_n_m, self.max_n_m, "N m",
                times(1.0), f"{self.kind}/max_n_m",
            ),
        )  # fmt: skip
