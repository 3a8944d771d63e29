"""Largest radius of the finished profile."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field
from pydantic_core import PydanticCustomError

from synthesis.followers.base import Follower
from synthesis.followers.flank import labelled, outer_gap
from synthesis.followers.trace import Trace
from synthesis.limits.base import Claim, Limit, Machine, where
from synthesis.motion import Stretch
from synthesis.numerics.piecewise import Array
from synthesis.terms import Cone, Curved, Row


class OuterRadius(Limit):
    """No point of the profile lies farther from the cam's axis than ``max_mm``.

    Where the profile is outermost its normal is radial, so the pitch curve is outermost there
    too: the profile's largest radius is the pitch curve's less Rr, or plus Rr where the cam lies
    around the roller; there the rim that was asked for comes on top.
    """

    kind: Literal["outer_radius"] = "outer_radius"
    title: ClassVar[str] = "Largest radius of the profile"
    max_mm: Annotated[float, Field(gt=0.0, le=1e9, description="Largest radius of the profile.")]

    def check(self, follower: Follower) -> None:
        alone = follower.alone()
        for path in alone.paths:
            gap = outer_gap(alone.flanks, path)
            if self.max_mm + gap <= 0.0:
                raise PydanticCustomError(
                    "outer_radius_too_small",
                    "max_mm = {value} of outer_radius is not above {gap} mm: roller, clearance "
                    "and rim take that much around the pitch curve. Allow a larger radius, or "
                    "make them smaller.",
                    {"value": self.max_mm, "gap": -gap},
                )

    def cones(self, stretches: Sequence[Stretch], machine: Machine) -> tuple[Cone, ...]:
        highest = max(stretch.highest for stretch in stretches)
        return tuple(
            Cone(norm, trace.value_of(self.max_mm + gap), labelled("outer_radius", path))
            for path, trace, gap in _edges(machine)
            if (norm := trace.outermost(highest)) is not None
        )

    def rows(self, stretch: Stretch, machine: Machine) -> tuple[Row, ...]:
        """Of a law that may overshoot the ends: what the norm's last component says."""
        return tuple(self._rows(machine)) if _overshoots(stretch) else ()

    def _rows(self, machine: Machine) -> Iterator[Row]:
        for path, trace, gap in _edges(machine):
            low, high = trace.outermost(0.0), trace.outermost(1.0)
            if low is None or high is None or low.matrix != high.matrix:
                continue
            rise = high.shift[-1] - low.shift[-1]
            if rise > 0.0:
                most = trace.value_of(self.max_mm + gap) - low.shift[-1]
                source = labelled("outer_radius", path)
                yield Row((rise, 0.0, 0.0, 0.0), low.matrix[-1], most, source=source)

    def curved(self, stretch: Stretch, machine: Machine) -> tuple[Curved, ...]:
        curves = machine.follower.outer_radius_curves(self.max_mm)
        return tuple(replace(curve, source="outer_radius") for curve in curves)

    def smooth(
        self, stretch: Stretch, machine: Machine, theta: Array, s: Any, z: Any
    ) -> tuple[Any, ...]:
        found = [v for curve in self.curved(stretch, machine) for v in curve.excess(s, z)]
        if _overshoots(stretch) and not found:
            for _, trace, gap in _edges(machine):
                (x, y), *_ = trace.traced_point(s, z)
                found.append((x * x + y * y) / (self.max_mm + gap) ** 2 - 1.0)
        return tuple(found)

    def claims(self, stretches: Sequence[Stretch], machine: Machine) -> tuple[Claim, ...]:
        return tuple(
            Claim(
                labelled("outer_radius", path),
                "pitch_radius",
                where(stretches),
                None,
                self.max_mm + gap,
                "mm",
                _less(gap),
                "outer_radius/max_mm",
                path,
            )
            for path, trace, gap in _edges(machine)
        )


def _overshoots(stretch: Stretch) -> bool:
    """Whether the law is one of the answer's that may go beyond its ends."""
    return stretch.free is not None and stretch.free.overshoot


def _edges(machine: Machine) -> Iterator[tuple[str, Trace, float]]:
    """Every path by name, and what the edge of its cam lacks to it [mm]."""
    for path, trace in machine.follower.paths.items():
        yield path, trace, outer_gap(machine.follower.flanks, path)


def _less(gap: float) -> Callable[[float], float]:
    """The map that takes away ``gap``."""
    return lambda pitch: pitch - gap
