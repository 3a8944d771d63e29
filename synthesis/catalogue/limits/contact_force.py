"""Force between cam and follower, along their common normal."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.constraints import LinearInequality
from synthesis.catalogue.followers.base import Follower
from synthesis.catalogue.followers.flank import Flank, labelled
from synthesis.catalogue.forces import Load
from synthesis.catalogue.limits.base import Claim, Machine, scaling, segment_indices
from synthesis.catalogue.limits.force import (
    SMALL,
    ForceLimit,
    drive,
    load_of,
    push_sign,
    transmission,
)
from synthesis.catalogue.motion import PlacedSegment
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

    def check_load(
        self,
        load: Load | None,
        follower: Follower,
        segments: Sequence[PlacedSegment],
        position: int,
    ) -> None:
        super().check_load(load, follower, segments, position)
        if load is not None and self.min_n is not None and load.pushed_both_ways(follower):
            raise PydanticCustomError(
                "never_floats",
                "limits/{position} asks for contact_force ≥ {value} N, but this closure pushes the "
                "follower both ways: it changes flank instead of floating. Leave min_n out.",
                {"position": position, "value": self.min_n},
            )

    def rows(self, segment: PlacedSegment, machine: Machine) -> tuple[LinearInequality, ...]:
        return tuple(self._rows(segment, machine))

    def _rows(self, segment: PlacedSegment, machine: Machine) -> Iterator[LinearInequality]:
        load, most = load_of(machine), _grip(machine)
        by = load.coefficients(machine.omega)
        for flank in machine.follower.flanks:
            if push_sign(flank, machine) < 0:
                continue
            least, largest = sorted(flank.side * p for p in load.process_range(segment))
            still, name = flank.side * load.constant_force, labelled(self.kind, flank.name)
            if self.max_n is not None and most is not None:
                upper = most * self.max_n - still - least
                yield LinearInequality(_scaled(by, flank.side), (), upper, source=f"{name}_max")
            if self.min_n is not None:
                yield LinearInequality(
                    _scaled(by, -flank.side), (), still + largest, source=f"{name}_min"
                )

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

    def claims(self, segments: Sequence[PlacedSegment], machine: Machine) -> tuple[Claim, ...]:
        everywhere, found = segment_indices(segments), list[Claim]()
        for flank in machine.follower.flanks:
            name, to_wire = labelled(self.kind, flank.name), scaling(float(flank.side))
            for end, value in (("min", self.min_n), ("max", self.max_n)):
                if value is None:
                    continue
                low, high = _ends(flank, end, value)
                found.append(
                    Claim(
                        f"{name}_{end}", "contact_force", everywhere, low, high, "N", to_wire,
                        f"{self.kind}/{end}_n", flank.path, flank=flank.name,
                    )
                )  # fmt: skip
        return tuple(found)


def _ends(flank: Flank, end: str, value: float) -> tuple[float | None, float | None]:
    """Lower and upper bound of N in the sense in which it is measured, + on the first side."""
    bound = flank.side * value
    return (bound, None) if (end == "min") == (flank.side > 0) else (None, bound)


def _scaled(
    by: tuple[float, float, float, float], factor: int
) -> tuple[float, float, float, float]:
    s, v, a, j = (factor * each for each in by)
    return s, v, a, j


def _grip(machine: Machine) -> float | None:
    """The largest that λ cos α − friction can be; None where that is not known beforehand."""
    follower, load = machine.follower, load_of(machine)
    if follower.always_convex and follower.travel.unit == "deg":
        return None
    friction: Callable[[float], Any] | None = load.friction.effective if load.friction else None
    return 1.0 if friction is None else float((1.0 + friction(0.0) ** 2) ** 0.5)
