"""Force between cam and follower, along their common normal."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.constraints import LinearInequality
from synthesis.catalogue.followers.flank import labelled
from synthesis.catalogue.limits.base import Claim, Machine, scaling
from synthesis.catalogue.limits.force import (
    SMALL,
    ForceLimit,
    drive,
    load_of,
    push_sign,
    transmission,
)
from synthesis.catalogue.motion import PlacedSegment, Segments
from synthesis.numerics.piecewise import Array


class ContactForce(ForceLimit):
    """``min_n`` ≤ N ≤ ``max_n`` on every flank; at min_n = 0 the follower does not float.

    The drive G = m s'' ω² + c s' ω + k s + F0 + P + W is linear in the law. N is not, but it has
    the sign of G, so that "no float" is linear; and N ≥ G where nothing shares the load, so that
    G ≤ max_n is a row that the limit implies. The rest is said in smooth form,
    G ≤ max_n (λ cos α − friction), which divides by nothing.
    """

    kind: Literal["contact_force"] = "contact_force"
    title: ClassVar[str] = "Contact force"
    max_n: Annotated[
        float | None, Field(gt=0.0, le=1e12, description="Largest contact force, on every flank.")
    ] = None
    min_n: Annotated[
        float | None,
        Field(
            ge=0.0,
            le=1e12,
            description="Smallest contact force; 0: the follower never floats. Not of a follower "
            "that is pushed both ways.",
        ),
    ] = None

    @model_validator(mode="after")
    def _limits_something(self) -> ContactForce:
        if self.max_n is self.min_n is None:
            raise PydanticCustomError(
                "no_force_limited",
                "contact_force gives no limit. Give max_n, or min_n (0: no float), or leave the "
                "limit out.",
                {},
            )
        if self.max_n is not None and self.min_n is not None and self.min_n >= self.max_n:
            raise PydanticCustomError(
                "forces_crossed",
                "min_n = {low} is not below max_n = {high}: no force is left. Exchange the two.",
                {"low": self.min_n, "high": self.max_n},
            )
        return self

    @property
    def rows_incomplete(self) -> bool:
        return self.max_n is not None or bool(self.min_n)

    def check_load(self, segments: Segments, machine: Machine, position: int) -> None:
        super().check_load(segments, machine, position)
        if self.min_n is not None and load_of(machine).pushed_both_ways:
            raise PydanticCustomError(
                "never_floats",
                "limits/{position} asks for contact_force ≥ {value} N, but this closure pushes the "
                "follower both ways: it changes flank instead of floating. Leave min_n out.",
                {"position": position, "value": self.min_n},
            )

    def rows(self, segment: PlacedSegment, machine: Machine) -> tuple[LinearInequality, ...]:
        load, most, found = load_of(machine), _max_transmission(machine), list[LinearInequality]()
        s, v, a, j = load.coefficients(machine.omega)
        for flank in machine.follower.flanks:
            if push_sign(flank, machine) < 0:
                continue
            side, name = flank.side, labelled(self.kind, flank.name)
            drive = side * s, side * v, side * a, side * j
            less = -side * s, -side * v, -side * a, -side * j
            constant = side * load.constant_force
            least, largest = sorted(side * p for p in load.process_range(segment))
            if self.max_n is not None and most is not None:
                upper = most * self.max_n - constant - least
                found.append(LinearInequality(drive, (), upper, source=f"{name}_max"))
            if self.min_n is not None:
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
                natural = max(
                    self.min_n, abs(load.constant_force) + max(abs(low), abs(high)), SMALL
                )
                found.append((self.min_n * grip - pressed) / natural)
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
    return 1.0 if friction is None else float((1.0 + friction.effective(0.0) ** 2) ** 0.5)
