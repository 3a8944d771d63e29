"""Hertz pressure between cam and follower."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import sqrt
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field
from pydantic_core import PydanticCustomError

from synthesis.catalogue.constraints import LinearInequality
from synthesis.catalogue.followers.base import Follower
from synthesis.catalogue.followers.curvature_bound import CurvatureBound
from synthesis.catalogue.followers.flank import labelled
from synthesis.catalogue.followers.kinematics import pressure_angle_sine_cosine
from synthesis.catalogue.forces import Load
from synthesis.catalogue.limits.base import Claim, Machine, segment_indices
from synthesis.catalogue.limits.force import ForceLimit, drive, load_of, push_sign, transmission
from synthesis.catalogue.limits.pressure_term import RollerPressureTerm
from synthesis.catalogue.motion import PlacedSegment
from synthesis.numerics.piecewise import Array


class HertzPressure(ForceLimit):
    """p ≤ ``max_mpa`` of the line contact, on every flank.

    p² = (N/B)(1/R1 + 1/R2) with 1/R2 = σκ/(1 − Dσκ). Times what does not vanish on a cam without
    undercut, and with L = G/(B p_max²), a length:

        roller     L [(1 − Dσκ)/R1 + σκ] ≤ (λ cos α − friction)(1 − Dσκ)
        flat face  L ≤ (λ cos α) ρ

    No formula divides by a curvature, so that straight and hollow flanks are nothing special.
    """

    kind: Literal["hertz_pressure"] = "hertz_pressure"
    title: ClassVar[str] = "Hertz pressure"
    max_mpa: Annotated[float, Field(gt=0.0, le=1e6, description="Largest contact pressure.")]

    @property
    def bounds_size_below(self) -> bool:
        return True

    def check_load(
        self,
        load: Load | None,
        follower: Follower,
        segments: Sequence[PlacedSegment],
        position: int,
    ) -> None:
        super().check_load(load, follower, segments, position)
        if load is not None and load.contact is None:
            raise PydanticCustomError(
                "limit_needs_contact",
                "limits/{position} is hertz_pressure, but the spec describes no line contact. "
                "Give load/contact with its width_mm.",
                {"position": position},
            )
        edges = [flank for flank in follower.without_free_counter().flanks if flank.roller <= 0.0]
        if edges and not follower.always_convex:
            raise PydanticCustomError(
                "edge_has_no_pressure",
                "limits/{position} is hertz_pressure, but roller radius 0 is a knife edge, under "
                "which the pressure is infinite. Give the roller a radius.",
                {"position": position},
            )

    @property
    def rows_incomplete(self) -> bool:
        return True

    def rows(self, segment: PlacedSegment, machine: Machine) -> tuple[LinearInequality, ...]:
        """Of a face on a slide, whose pressure angle is one and ρ linear, all of it.

        Where the process force changes along the segment, with the least that presses.
        """
        follower, load = machine.follower, load_of(machine)
        radii = follower.profile_radius_rows(0.0)
        if not radii or follower.profile_radius_constraints(0.0):  # then the rows are not all of it
            return ()
        by = np.array(load.coefficients(machine.omega)) / self._scale(machine)
        least = min(load.process_range(segment))
        _, grip = pressure_angle_sine_cosine(follower, (0.0,) * 4, (1.0,) * len(radii[0].size))
        found = []
        for radius in radii:
            s, v, a, j = (by + grip * np.array(radius.coefficients)).tolist()
            size = tuple(grip * each for each in radius.size)
            upper = grip * radius.upper - (load.constant_force + least) / self._scale(machine)
            found.append(LinearInequality((s, v, a, j), size, upper, source=self.kind))
        return tuple(found)

    def curvature_bounds(
        self, segment: PlacedSegment, machine: Machine
    ) -> tuple[CurvatureBound, ...]:
        """Of a roller on a slide: what thrust leaves of the curvature that undercut allows."""
        return tuple(
            replace(rows, source=labelled(self.kind, flank.name))
            for flank in machine.follower.flanks
            if flank.distance > 0.0
            for rows in flank.trace.curvature_bounds(
                flank.side,
                1.0 / flank.distance,
                RollerPressureTerm(flank, segment, machine, self._scale(machine)),
            )
        )

    def _scale(self, machine: Machine) -> float:
        """B p_max² [N/mm]."""
        contact = load_of(machine).contact
        assert contact is not None
        return contact.stiffness * self.max_mpa**2

    def smooth_constraints(
        self, segment: PlacedSegment, machine: Machine, theta: Array, s: Any, z: Any
    ) -> tuple[Any, ...]:
        low, high = load_of(machine).process_range(segment)
        if low == high and self.rows(segment, machine):
            return ()
        force = drive(segment, machine, theta, s) / self._scale(machine)
        found = list[Any]()
        for flank in machine.follower.flanks:
            way = push_sign(flank, machine)
            pressed = force * (flank.side * way)
            grip = way * transmission(flank.trace, segment, machine, s, z)
            numerator, square = flank.trace.curvature_terms(s, z)
            if machine.follower.always_convex:
                natural = max(abs(segment.s_start), abs(segment.s_end), abs(segment.lift), 1e-9)
                found.append((pressed - grip * numerator / square**0.5) / natural)
                continue
            bend = flank.side * numerator / square**1.5
            left = 1.0 - flank.distance * bend
            found.append(pressed * (left / flank.roller + bend) - grip * left)
        return tuple(found)

    def claims(self, segments: Sequence[PlacedSegment], machine: Machine) -> tuple[Claim, ...]:
        return tuple(
            Claim(
                labelled(self.kind, flank.name), "pressure_square", segment_indices(segments), None,
                self.max_mpa**2, "MPa", _root, f"{self.kind}/max_mpa", flank.path,
                flank=flank.name,
            )
            for flank in machine.follower.flanks
        )  # fmt: skip


def _root(square: float) -> float:
    """The pressure, 0 where nothing presses."""
    return sqrt(max(square, 0.0))
