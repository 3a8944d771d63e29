"""Hertz pressure between cam and follower."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import sqrt
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field
from pydantic_core import PydanticCustomError

from synthesis.followers.base import Follower
from synthesis.followers.flank import labelled
from synthesis.followers.trace import leaning
from synthesis.forces import Load
from synthesis.limits.base import Claim, Machine, where
from synthesis.limits.force import ForceLimit, drive, loaded, pushing, yielding
from synthesis.limits.thrust import RollerThrust
from synthesis.motion import Stretch
from synthesis.numerics.piecewise import Array
from synthesis.terms import Row, Traced


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
    def keeps_large(self) -> bool:
        return True

    def check_load(
        self, load: Load | None, follower: Follower, stretches: Sequence[Stretch], position: int
    ) -> None:
        super().check_load(load, follower, stretches, position)
        if load is not None and load.contact is None:
            raise PydanticCustomError(
                "limit_needs_contact",
                "limits/{position} is hertz_pressure, but nothing is told of the line contact. "
                "Give load/contact with its width_mm.",
                {"position": position},
            )
        edges = [flank for flank in follower.alone().flanks if flank.roller <= 0.0]
        if edges and not follower.always_convex:
            raise PydanticCustomError(
                "edge_has_no_pressure",
                "limits/{position} is hertz_pressure, but roller radius 0 is a knife edge, under "
                "which the pressure is infinite. Give the roller a radius.",
                {"position": position},
            )

    @property
    def said_in_part(self) -> bool:
        return True

    def rows(self, stretch: Stretch, machine: Machine) -> tuple[Row, ...]:
        """Of a face on a slide, whose pressure angle is one and ρ linear, all of it.

        Where the process force changes along the stretch, with the least that presses.
        """
        follower, load = machine.follower, loaded(machine)
        radii = follower.profile_radius_rows(0.0)
        if not radii or follower.profile_radius_curves(0.0):  # then the rows are not all of it
            return ()
        by = np.array(load.coefficients(machine.omega)) / self._scale(machine)
        least = min(load.process_range(stretch))
        _, grip = leaning(follower, (0.0,) * 4, (1.0,) * len(radii[0].size))
        found = []
        for radius in radii:
            s, v, a, j = (by + grip * np.array(radius.coefficients)).tolist()
            size = tuple(grip * each for each in radius.size)
            upper = grip * radius.upper - (load.constant + least) / self._scale(machine)
            found.append(Row((s, v, a, j), size, upper, source=self.kind))
        return tuple(found)

    def traced(self, stretch: Stretch, machine: Machine) -> tuple[Traced, ...]:
        """Of a roller on a slide: what thrust leaves of the curvature that undercut allows."""
        return tuple(
            replace(rows, source=labelled(self.kind, flank.name))
            for flank in machine.follower.flanks
            if flank.distance > 0.0
            for rows in flank.trace.curvature_implied(
                flank.side,
                1.0 / flank.distance,
                RollerThrust(flank, stretch, machine, self._scale(machine)),
            )
        )

    def _scale(self, machine: Machine) -> float:
        """B p_max² [N/mm]."""
        contact = loaded(machine).contact
        assert contact is not None
        return contact.stiffness * self.max_mpa**2

    def smooth(
        self, stretch: Stretch, machine: Machine, theta: Array, s: Any, z: Any
    ) -> tuple[Any, ...]:
        low, high = loaded(machine).process_range(stretch)
        if low == high and self.rows(stretch, machine):
            return ()
        force = drive(stretch, machine, theta, s) / self._scale(machine)
        found = list[Any]()
        for flank in machine.follower.flanks:
            way = pushing(flank, machine)
            pressed = force * (flank.side * way)
            grip = way * yielding(flank.trace, stretch, machine, s, z)
            numerator, square = flank.trace.curvature_terms(s, z)
            if machine.follower.always_convex:
                natural = max(abs(stretch.s_start), abs(stretch.s_end), abs(stretch.lift), 1e-9)
                found.append((pressed - grip * numerator / square**0.5) / natural)
                continue
            bend = flank.side * numerator / square**1.5
            left = 1.0 - flank.distance * bend
            found.append(pressed * (left / flank.roller + bend) - grip * left)
        return tuple(found)

    def claims(self, stretches: Sequence[Stretch], machine: Machine) -> tuple[Claim, ...]:
        return tuple(
            Claim(
                labelled(self.kind, flank.name), "pressure_square", where(stretches), None,
                self.max_mpa**2, "MPa", _root, f"{self.kind}/max_mpa", flank.path,
                flank=flank.name,
            )
            for flank in machine.follower.flanks
        )  # fmt: skip


def _root(square: float) -> float:
    """The pressure, 0 where nothing presses."""
    return sqrt(max(square, 0.0))
