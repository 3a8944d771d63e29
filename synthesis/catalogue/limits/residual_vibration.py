"""Residual vibration: what an elastic follower train still swings with when a dwell begins."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field
from pydantic_core import PydanticCustomError

from synthesis.catalogue.constraints import VibrationBound
from synthesis.catalogue.limits.base import Claim, Machine, scaling
from synthesis.catalogue.limits.derivatives import TravelLimit
from synthesis.catalogue.motion import Segments
from synthesis.units import FULL_TURN

SPARE = 1e-9  # of the stroke: what rounding leaves of an amplitude that is to be none
PER_TURN = (0.01, 5000.0)  # swings of the train in one turn: fewer or more are wrong units
Amplitude = Annotated[float, Field(ge=0.0, le=1e30)] | None


class ResidualVibration(TravelLimit):
    """Amplitude ≤ the limit where a dwell begins, of one mode of the follower train.

    Every run of segments between two dwells counts by itself, the train at rest before it. The
    amplitude is the modulus of an integral that is linear in the motion, so that it is a cone, and
    0 two equalities.
    """

    kind: Literal["residual_vibration"] = "residual_vibration"
    title: ClassVar[str] = "Residual vibration"
    fields: ClassVar[dict[str, str]] = {"mm": "max_mm", "deg": "max_deg"}
    natural_frequency_hz: float = Field(
        gt=0.0,
        le=1e9,
        description="Undamped natural frequency of the train's mode, the cam's side held fast; "
        "0.01 to 5000 times the speed of the cam.",
    )
    damping_ratio: float = Field(
        0.0, ge=0.0, lt=1.0, description="Damping of the mode, as a share of the critical one."
    )
    max_mm: Amplitude = Field(
        None,
        description="Largest amplitude of the output's swing about its place, of a slide, where a "
        "dwell begins; 0 for none at all. The train is at rest before each run of moves.",
    )
    max_deg: Amplitude = Field(None, description="The same of an arm.")

    def check(self, segments: Segments, machine: Machine) -> None:
        swings = self.natural_frequency_hz * FULL_TURN / machine.omega
        if not PER_TURN[0] <= swings <= PER_TURN[1]:
            raise PydanticCustomError(
                "vibration_too_far_off",
                "residual_vibration is about {frequency} Hz, {swings} swings in one turn of the "
                "cam; between {least} and {most} make sense. Give the frequency in Hz and the "
                "speed in rpm, or leave the limit out.",
                {"frequency": self.natural_frequency_hz, "swings": float(f"{swings:.4g}"),
                 "least": PER_TURN[0], "most": PER_TURN[1]},
            )  # fmt: skip
        if not runs_between_dwells(segments):
            raise PydanticCustomError(
                "no_dwell_to_ring_in",
                "residual_vibration limits what a dwell begins with, but program holds no dwell "
                "with an angle. Add one, or leave the limit out.",
                {},
            )

    def vibration_bounds(self, segments: Segments, machine: Machine) -> tuple[VibrationBound, ...]:
        frequency = self.natural_frequency_hz * FULL_TURN / machine.omega
        largest = self.bound / machine.wire_factor(0)
        return tuple(
            VibrationBound(run, frequency, self.damping_ratio, largest, self.kind)
            for run in runs_between_dwells(segments)
        )

    def claims(self, segments: Segments, machine: Machine) -> tuple[Claim, ...]:
        bounds = self.vibration_bounds(segments, machine)
        moving = tuple(sorted(index for bound in bounds for index in bound.run))
        levels = [level for s in segments for level in (s.s_start, s.s_end)]
        spare = SPARE * (max(levels) - min(levels)) if self.bound == 0.0 else 0.0
        factor, unit = machine.wire_factor(0), machine.derivative_unit(0)
        claim = self._claim(
            segments, (None, self.bound / factor + spare), self.field, unit,
            to_wire=scaling(factor), indices=moving, vibration=bounds,
        )  # fmt: skip
        return (claim,)


def runs_between_dwells(segments: Segments) -> tuple[tuple[int, ...], ...]:
    """Indices of the segments between two dwells, run by run in the order of their dwells.

    None where there is no dwell. Segments of no angle do not count.
    """
    placed = [s for s in segments if s.angle > 0.0]
    dwells = [k for k, s in enumerate(placed) if s.kind == "dwell"]
    found = []
    for one, other in zip(dwells[-1:] + dwells[:-1], dwells, strict=True):
        between = (other - one - 1) % len(placed)
        run = tuple(placed[(one + 1 + k) % len(placed)].index for k in range(between))
        if run:
            found.append(run)
    return tuple(found)
