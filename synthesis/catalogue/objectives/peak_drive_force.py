"""The lowest peak of the force that the cam has to give along the motion."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic_core import PydanticCustomError

from synthesis.catalogue.constraints import LinearInequality
from synthesis.catalogue.limits.base import Machine
from synthesis.catalogue.motion import PlacedSegment, Segments
from synthesis.catalogue.objectives.base import Objective
from synthesis.units import DEGREE


class PeakDriveForce(Objective):
    """Minimise the largest drive G over the turn; pushed both ways, the largest |G|.

    G = m s'' ω² + c s' ω + k s + F0 + P + W is linear in the law, so the least peak is found and
    bounded like that of the acceleration. Under an upright flat face it is the contact force;
    elsewhere N = G / cos α lies above it.
    """

    kind: Literal["peak_drive_force"] = "peak_drive_force"
    title: ClassVar[str] = "Peak force along the motion"
    quantity: ClassVar[str] = "drive_force"
    wire_name: ClassVar[str] = "peak_drive_force_n"

    def check_load(self, segments: Segments, machine: Machine, position: int) -> None:
        if machine.load is None:
            raise PydanticCustomError(
                "objective_needs_load",
                "peak_drive_force is to be small, but the spec gives no load on the follower. "
                "Give load, or choose another objective.",
                {},
            )
        for segment in segments:
            low, high = machine.load.process_range(segment)
            if segment.kind != "dwell" and segment.angle > 0.0 and low != high:
                raise PydanticCustomError(
                    "process_not_steady",
                    "peak_drive_force can be made small where the process force does not change "
                    "along a rise or return, and along program/{segment} it does. Give it the same "
                    "value at both ends of the segment (two points at one angle make a jump), or "
                    "limit contact_force and make something else small.",
                    {"segment": segment.index},
                )

    def rows(
        self, segment: PlacedSegment, machine: Machine, level: float
    ) -> tuple[LinearInequality, ...]:
        load, found = machine.load, list[LinearInequality]()
        assert load is not None
        s, v, a, j = load.coefficients(machine.omega)
        for side in (1, -1) if load.pushed_both_ways else (load.side,):
            process = max(side * end for end in load.process_range(segment))
            upper, drive = -(side * load.constant_force + process), (side * s, side * v, side * a)
            found.append(LinearInequality((*drive, side * j), (), upper, -1.0, self.kind))
        return tuple(found)

    def name_on_wire(self, machine: Machine) -> str:
        return self.wire_name if machine.follower.travel.unit == "mm" else "peak_drive_moment_n_m"

    def to_wire(self, value: float, machine: Machine) -> float:
        return value * _lever(machine)

    def from_wire(self, value: float, machine: Machine) -> float:
        return value / _lever(machine)


def _lever(machine: Machine) -> float:
    """N m of a newton along the arc of an arm; 1 on a slide."""
    travel = machine.follower.travel
    return 1.0 if travel.unit == "mm" else 1e-3 * travel.per_unit / DEGREE
