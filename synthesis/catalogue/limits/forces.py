"""Limits on the contact force and on the camshaft's torque, and what limits on forces share."""

from __future__ import annotations

from abc import ABC
from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.constraints import LinearInequality
from synthesis.catalogue.followers.kinematics import (
    Flank,
    TracePoint,
    labelled,
    pressure_angle_sine_cosine,
)
from synthesis.catalogue.forces import ReducedLoad
from synthesis.catalogue.forces.reduced import MILLI
from synthesis.catalogue.limits.base import AtLowerSpeed, Claim, Limit, Machine, scaling
from synthesis.catalogue.motion import PlacedSegment, Segments
from synthesis.numerics.piecewise import Array

SMALL = 1e-300  # keeps a quotient finite where its denominator may be 0


class ForceLimit(Limit, ABC):
    """A limit on a force: a spec with such a limit must give the load on the follower."""

    needs_load: ClassVar[bool] = True
    at_lower_speed: ClassVar[AtLowerSpeed] = "either"

    def check(self, segments: Segments, machine: Machine, position: int) -> None:
        if machine.load is None:
            raise PydanticCustomError(
                "limit_needs_load",
                "limits/{position} is {limit}, but the spec gives no load on the follower. "
                "Give load, or remove the limit.",
                {"position": position, "limit": self.kind},
            )


def load_of(machine: Machine) -> ReducedLoad:
    """The load on the follower, which ``check`` has found to be given."""
    assert machine.load is not None
    return machine.load


def drive(segment: PlacedSegment, machine: Machine, theta: Array, s: Any) -> Any:
    """Drive force G [N] on a segment, from columns of s to s''' that may be symbols."""
    load, angles = load_of(machine), np.asarray(theta, dtype=float)
    process = load.process_on(segment, angles.ravel()).reshape(angles.shape)
    # 0·θ gives the sum the shape of θ: CasADi would take a NumPy vector for a row.
    return load.drive(s, 0.0 * theta + process, machine.omega)


def push_sign(flank: Flank, machine: Machine) -> int:
    """+1 on the main roller's flanks, −1 on a counter roller's: it pushes against growing s."""
    return -1 if flank.path in machine.follower.closure.counter_paths else 1


def transmission(path: TracePoint, segment: PlacedSegment, machine: Machine, s: Any, z: Any) -> Any:
    """G/N: λ cos α less the share of the contact force that friction in the guide takes."""
    load = load_of(machine)
    sine, cosine = pressure_angle_sine_cosine(path, s, z)
    sense = load.sliding_sense(segment)
    # |·| smoothed to a finite slope at 0, for numbers and for symbols
    resisted = load.friction_loss(sense, sine, s[0], lambda v: (v * v + 1e-18) ** 0.5)
    return cosine * path.lever(s, z) - resisted


class ContactForce(ForceLimit):
    """``min_n`` ≤ N ≤ ``max_n`` on every flank; at min_n = 0 the follower does not float.

    Note:
        The drive G = m s'' ω² + c s' ω + k s + F0 + P + W is linear in the law. N is not, but it
        has the sign of G, so that "no float" is linear; and N ≥ G where nothing shares the load, so
        that G ≤ max_n is a row that the limit implies. The rest is said in smooth form, G ≤ max_n
        (λ cos α − friction), which divides by nothing.
    """

    kind: Literal["contact_force"] = "contact_force"
    title: ClassVar[str] = "Contact force"
    max_n: float | None = Field(
        None, gt=0.0, le=1e12, description="Largest contact force, on every flank."
    )
    min_n: float | None = Field(
        None,
        ge=0.0,
        le=1e12,
        description="Smallest contact force; 0: the follower never floats. Not of a follower "
        "that is pushed both ways.",
    )

    @model_validator(mode="after")
    def _limits_something(self) -> ContactForce:
        if self.max_n is self.min_n is None:
            raise PydanticCustomError(
                "no_force_limited",
                "contact_force gives no limit. Give max_n, or min_n (0: no float), or leave the "
                "limit out.",
            )
        if self.max_n is not None and self.min_n is not None and self.min_n >= self.max_n:
            raise PydanticCustomError(
                "forces_crossed",
                "min_n = {low} is not below max_n = {high}: no force is left. Exchange the two.",
                {"low": self.min_n, "high": self.max_n},
            )
        return self

    def check(self, segments: Segments, machine: Machine, position: int) -> None:
        super().check(segments, machine, position)
        if self.min_n is not None and load_of(machine).pushed_both_ways:
            raise PydanticCustomError(
                "never_floats",
                "limits/{position} asks for contact_force ≥ {value} N, but this closure pushes the "
                "follower both ways: it changes flank instead of floating. Leave min_n out.",
                {"position": position, "value": self.min_n},
            )

    def rows(self, segment: PlacedSegment, machine: Machine) -> tuple[LinearInequality, ...]:
        load, most, found = load_of(machine), _max_transmission(machine), list[LinearInequality]()
        for flank in machine.follower.flanks:
            if push_sign(flank, machine) < 0:
                continue
            side, name = flank.side, labelled(self.kind, flank.name)
            drive = tuple(side * c for c in load.coefficients(machine.omega))
            constant = side * load.constant_force
            least, largest = sorted(side * p for p in load.process_range(segment))
            if self.max_n is not None and most is not None:
                upper = most * self.max_n - constant - least
                found.append(LinearInequality(drive, (), upper, source=f"{name}_max"))
            if self.min_n is not None:
                less = tuple(-c for c in drive)
                found.append(LinearInequality(less, (), constant + largest, source=f"{name}_min"))
        return tuple(found)

    def smooth_constraints(
        self, segment: PlacedSegment, machine: Machine, theta: Array, s: Any, z: Any
    ) -> tuple[Any, ...]:
        load, found = load_of(machine), list[Any]()
        force, (low, high) = drive(segment, machine, theta, s), load.process_range(segment)
        for flank in machine.follower.flanks:
            way = push_sign(flank, machine)
            pressed = force * (flank.side * way)
            grip = way * transmission(flank.trace, segment, machine, s, z)
            if self.max_n is not None:
                found.append(pressed / self.max_n - grip)
            if self.min_n is not None and (self.min_n > 0.0 or low != high):
                most = abs(load.constant_force) + max(abs(low), abs(high))
                found.append((self.min_n * grip - pressed) / max(self.min_n, most, SMALL))
        return tuple(found)

    def claims(self, segments: Segments, machine: Machine) -> tuple[Claim, ...]:
        # N is measured positive towards the first flank; on the other side its bounds change ends.
        return tuple(
            self._claim(
                segments, (bound, None) if (end == "min") == (flank.side > 0) else (None, bound),
                f"{end}_n", "N", name=f"{labelled(self.kind, flank.name)}_{end}",
                to_wire=scaling(float(flank.side)), path=flank.path, flank=flank.name,
            )
            for flank in machine.follower.flanks
            for end, value in (("min", self.min_n), ("max", self.max_n))
            if value is not None
            for bound in [flank.side * value]
        )  # fmt: skip


def _max_transmission(machine: Machine) -> float | None:
    """The largest that λ cos α − friction can be; None where that is not known beforehand."""
    follower, friction = machine.follower, load_of(machine).friction
    if follower.always_convex and follower.travel.unit == "deg":
        return None
    return 1.0 if friction is None else float((1.0 + friction.share_of_side_force(0.0) ** 2) ** 0.5)


class CamshaftTorque(ForceLimit):
    """|T| ≤ ``max_n_m`` at every cam angle: T = G s', with friction G s' λ cos α/(λ cos α − …).

    Note:
        A product of two derivatives of the law: no row says it, nor is it eased by a larger cam.
    """

    kind: Literal["camshaft_torque"] = "camshaft_torque"
    title: ClassVar[str] = "Camshaft torque"
    max_n_m: float = Field(gt=0.0, le=1e12, description="Largest |torque|.")

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
