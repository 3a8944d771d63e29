"""Base radius of the counter cam of a conjugate pair."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from synthesis.catalogue.constraints import LinearInequality
from synthesis.catalogue.followers.base import Follower
from synthesis.catalogue.followers.flank import Flank
from synthesis.catalogue.limits.base import Claim, Limit, Machine, shifting
from synthesis.catalogue.motion import PlacedSegment, Segments
from synthesis.numerics.piecewise import Array


class CounterBaseRadius(Limit):
    """The counter cam's base radius ≥ ``min_mm``: its traced curve stays Rr + min off the axis."""

    kind: Literal["counter_base_radius"] = "counter_base_radius"
    title: ClassVar[str] = "Base radius of the counter cam"
    same_on_every_segment: ClassVar[bool] = True
    min_mm: Annotated[
        float, Field(ge=0.0, le=1e9, description="Smallest base radius of the counter cam.")
    ] = 0.0

    @property
    def bounds_size_below(self) -> bool:
        return True

    def applies_to(self, follower: Follower) -> bool:
        return bool(follower.active_closure.counter_paths)

    def rows(self, segment: PlacedSegment, machine: Machine) -> tuple[LinearInequality, ...]:
        return tuple(
            replace(row, source=self.kind)
            for flank in _counters(machine)
            for row in flank.trace.radius_rows(flank.distance + self.min_mm)
        )

    def smooth_constraints(
        self, segment: PlacedSegment, machine: Machine, theta: Array, s: Any, z: Any
    ) -> tuple[Any, ...]:
        if self.rows(segment, machine):
            return ()
        found = []
        for flank in _counters(machine):
            least = flank.distance + self.min_mm
            (px, py), *_ = flank.trace.position(s, z)
            square = px * px + py * py
            found.append((least * least - square) / (least * least + square))
        return tuple(found)

    def claims(self, segments: Segments, machine: Machine) -> tuple[Claim, ...]:
        return tuple(
            self._claim(
                segments, (flank.distance + self.min_mm, None), "min_mm", "mm",
                quantity="pitch_radius", to_wire=shifting(flank.distance), path=flank.path,
            )
            for flank in _counters(machine)
        )  # fmt: skip


def _counters(machine: Machine) -> Iterator[Flank]:
    """The flanks of counter cams."""
    for flank in machine.follower.flanks:
        if flank.path in machine.follower.active_closure.counter_paths:
            yield flank
