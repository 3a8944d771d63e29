"""Hertz pressure between cam and follower, and the curvature that it leaves.

With D the flank's distance from the roller's centre, R1 the roller's radius, ℓ = ±G/(B p_max²) [mm]
and φ = 1 − friction/cos α the limit reads ℓ [(1 − Dσκ)/R1 + σκ] ≤ φ cos α (1 − Dσκ). Without a
slack D = R1, and it is

    ℓ/D² ≤ φ cos α (1/D − σκ)

A slack D − R1 > 0 presses harder, so that this follows from the limit there too. The right side is
not negative, so that a φ that is too large asks for less.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import sqrt
from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import Field
from pydantic_core import PydanticCustomError

from synthesis.catalogue.box_bounds import BoxBounds
from synthesis.catalogue.constraints import LinearInequality, MotionBox, PressureTerm
from synthesis.catalogue.followers.kinematics import Flank, labelled, pressure_angle_sine_cosine
from synthesis.catalogue.limits.base import Claim, Machine
from synthesis.catalogue.limits.forces import (
    SMALL,
    ForceLimit,
    drive,
    load_of,
    push_sign,
    transmission,
)
from synthesis.catalogue.motion import PlacedSegment, Segments
from synthesis.numerics.piecewise import Array

WEAKEST = 1e-3  # φ: a guide that leaves less is nearly locked by its friction


class HertzPressure(ForceLimit):
    """p ≤ ``max_mpa`` of the line contact, on every flank.

    Note:
        p² = (N/B)(1/R1 + 1/R2) with 1/R2 = σκ/(1 − Dσκ). Times what does not vanish on a cam
        without undercut, and with L = G/(B p_max²), a length:

            roller     L [(1 − Dσκ)/R1 + σκ] ≤ (λ cos α − friction)(1 − Dσκ)
            flat face  L ≤ (λ cos α) ρ

        No formula divides by a curvature, so that straight and hollow flanks are nothing special.
    """

    kind: Literal["hertz_pressure"] = "hertz_pressure"
    title: ClassVar[str] = "Hertz pressure"
    bounds_size_below: ClassVar[bool] = True
    max_mpa: float = Field(gt=0.0, le=1e6, description="Largest contact pressure.")

    def check(self, segments: Segments, machine: Machine, position: int) -> None:
        super().check(segments, machine, position)
        if load_of(machine).contact is None:
            raise PydanticCustomError(
                "limit_needs_contact",
                "limits/{position} is hertz_pressure, but the spec describes no line contact. "
                "Give load/contact with its width_mm.",
                {"position": position},
            )
        follower = machine.follower.without_free_counter()
        if not follower.always_convex and any(flank.roller <= 0.0 for flank in follower.flanks):
            raise PydanticCustomError(
                "edge_has_no_pressure",
                "limits/{position} is hertz_pressure, but roller radius 0 is a knife edge, under "
                "which the pressure is infinite. Give the roller a radius.",
                {"position": position},
            )

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
            motion = tuple((by + grip * np.array(radius.coefficients)).tolist())
            size = tuple(grip * each for each in radius.size)
            upper = grip * radius.upper - (load.constant_force + least) / self._scale(machine)
            found.append(LinearInequality(motion, size, upper, source=self.kind))
        return tuple(found)

    def curvature_bounds(self, segment: PlacedSegment, machine: Machine) -> BoxBounds:
        """Of a roller on a slide: what thrust leaves of the curvature that undercut allows."""
        scale = self._scale(machine)
        terms = (RollerPressureTerm(f, segment, machine, scale) for f in machine.follower.flanks)
        return tuple(
            replace(rows, source=labelled(self.kind, term.flank.name))
            for term in terms
            if (distance := term.flank.distance) > 0.0
            for rows in term.flank.trace.curvature_bounds(term.flank.side, 1.0 / distance, term)
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

    def claims(self, segments: Segments, machine: Machine) -> tuple[Claim, ...]:
        return tuple(
            self._claim(
                segments, (None, self.max_mpa**2), "max_mpa", "MPa", label=flank.name,
                quantity="pressure_square", to_wire=lambda square: sqrt(max(square, 0.0)),
                path=flank.path, flank=flank.name,
            )
            for flank in machine.follower.flanks
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class RollerPressureTerm(PressureTerm):
    """Of one flank on one segment; ``scale``: B p_max² [N/mm]."""

    flank: Flank
    segment: PlacedSegment
    machine: Machine
    scale: float

    def linear_form(self, theta: Array) -> tuple[Array, Array]:
        load, flank = load_of(self.machine), self.flank
        way = flank.side * push_sign(flank, self.machine)
        unit = way / (self.scale * flank.distance**2)
        by = np.array(load.coefficients(self.machine.omega)[:3])
        return by * unit, (self._process(theta, way) + load.constant_force) * unit

    def _process(self, theta: Array, way: int) -> Array:
        """The process force [N]; at a jump that side of it which presses harder."""
        load, segment = load_of(self.machine), self.segment
        inner = (segment.start < theta) & (theta < segment.end)
        after = load.process_on(segment, theta)
        before = np.where(inner, load.process(theta, 0, "left"), after)
        return np.asarray(way * np.maximum(way * after, way * before))

    def friction_bound(self, low: Array, high: Array, moving: MotionBox) -> tuple[Array, Array]:
        load, one = load_of(self.machine), np.ones(low.shape[1])
        if load.friction is None:
            return one, 0.0 * one
        share = load.friction.share_of_side_force
        ends = [share(s) + 0.0 * s for s in (moving.low[0], moving.high[0])]
        way = push_sign(self.flank, self.machine) * load.sliding_sense(self.segment) * load.side
        # Range of q = tan α = u/X over the box: monotone in u and in X > 0.
        slopes = np.stack([u / x for u in (low[1], high[1]) for x in (low[0], high[0])])
        flat, steep = np.min(slopes, axis=0), np.max(slopes, axis=0)
        # φ = 1 ∓ μ |q|. Where friction takes force, |q| ≥ k q for |k| ≤ 1 bounds φ above; where it
        # gives force, |q| lies below its chord over the range.
        if way > 0.0:
            share = (flat + steep) / np.maximum(np.abs(flat) + np.abs(steep), SMALL)
            base, by = one, -np.maximum(np.minimum(*ends), 0.0) * share
        else:
            width = np.maximum(steep - flat, SMALL)
            mixed = (flat < 0.0) & (steep > 0.0)
            share = np.where(mixed, (flat + steep) / width, np.sign(flat + steep))
            rest = np.where(mixed, -2.0 * flat * steep / width, 0.0)
            most = -way * np.maximum(*ends)
            base, by = one + most * rest, most * share
        least = np.minimum(base + by * flat, base + by * steep)
        largest = np.maximum(np.maximum(base + by * flat, base + by * steep), WEAKEST)
        held = least >= WEAKEST
        return np.where(held, base, largest), np.where(held, by, 0.0)
