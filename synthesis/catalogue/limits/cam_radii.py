"""Radii of the cam: the largest of its profile, and the base radius of a counter cam."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, ClassVar, Literal

from pydantic import Field
from pydantic_core import PydanticCustomError

from synthesis.catalogue.constraints import LinearInequality, NonconvexConstraint, NormBounds
from synthesis.catalogue.followers.base import Follower, paths
from synthesis.catalogue.followers.kinematics import Flank, TracePoint, edge_offset, labelled
from synthesis.catalogue.limits.base import Claim, Limit, Machine, shifting
from synthesis.catalogue.motion import PlacedSegment, Segments
from synthesis.numerics.piecewise import Array


class OuterRadius(Limit):
    """No point of the profile lies farther from the cam's axis than ``max_mm``.

    Where the profile is outermost its normal is radial, so the pitch curve is outermost there
    too: the profile's largest radius is the pitch curve's less Rr, or plus Rr where the cam lies
    around the roller; there the rim that the spec asks for is added.
    """

    kind: Literal["outer_radius"] = "outer_radius"
    title: ClassVar[str] = "Largest radius of the profile"
    max_mm: float = Field(gt=0.0, le=1e9, description="Largest radius of the profile.")

    def check(self, segments: Segments, machine: Machine) -> None:
        alone = machine.follower.without_free_counter()
        for path in paths(alone):
            gap = edge_offset(alone.flanks, path)
            if self.max_mm + gap <= 0.0:
                raise PydanticCustomError(
                    "outer_radius_too_small",
                    "max_mm = {value} of outer_radius is not above {gap} mm: roller, clearance "
                    "and rim take that much around the pitch curve. Allow a larger radius, or "
                    "make them smaller.",
                    {"value": self.max_mm, "gap": -gap},
                )

    def norm_bounds(self, segments: Segments, machine: Machine) -> tuple[NormBounds, ...]:
        highest = max(segment.max_displacement for segment in segments)
        return tuple(
            NormBounds(
                norm, trace.norm_from_radius(self.max_mm + gap), labelled("outer_radius", path)
            )
            for path, trace, gap in _edges(machine)
            if (norm := trace.outer_radius_norm(highest)) is not None
        )

    def rows(self, segment: PlacedSegment, machine: Machine) -> tuple[LinearInequality, ...]:
        """Of a law that may overshoot the ends: what the norm's last component says."""
        return tuple(self._rows(machine)) if _overshoots(segment) else ()

    def _rows(self, machine: Machine) -> Iterator[LinearInequality]:
        for path, trace, gap in _edges(machine):
            low, high = trace.outer_radius_norm(0.0), trace.outer_radius_norm(1.0)
            if low is None or high is None or low.matrix != high.matrix:
                continue
            rise = high.shift[-1] - low.shift[-1]
            if rise > 0.0:
                most = trace.norm_from_radius(self.max_mm + gap) - low.shift[-1]
                source = labelled("outer_radius", path)
                yield LinearInequality((rise, 0.0, 0.0, 0.0), low.matrix[-1], most, source=source)

    def nonconvex(
        self, segment: PlacedSegment, machine: Machine
    ) -> tuple[NonconvexConstraint, ...]:
        curves = machine.follower.outer_radius_constraints(self.max_mm)
        return tuple(replace(curve, source="outer_radius") for curve in curves)

    def smooth_constraints(
        self, segment: PlacedSegment, machine: Machine, theta: Array, s: Any, z: Any
    ) -> tuple[Any, ...]:
        found = list(super().smooth_constraints(segment, machine, theta, s, z))
        if _overshoots(segment) and not found:
            for _, trace, gap in _edges(machine):
                (x, y), *_ = trace.position(s, z)
                found.append((x * x + y * y) / (self.max_mm + gap) ** 2 - 1.0)
        return tuple(found)

    def claims(self, segments: Segments, machine: Machine) -> tuple[Claim, ...]:
        return tuple(
            self._claim(
                segments, (None, self.max_mm + gap), "max_mm", "mm", label=path,
                quantity="pitch_radius", to_wire=shifting(gap), path=path,
            )
            for path, trace, gap in _edges(machine)
        )  # fmt: skip


def _overshoots(segment: PlacedSegment) -> bool:
    """Whether the law is one of the answer's that may go beyond its ends."""
    return segment.free is not None and segment.free.overshoot


def _edges(machine: Machine) -> Iterator[tuple[str, TracePoint, float]]:
    """Every path by name, and what the edge of its cam lacks to it [mm]."""
    for path, trace in paths(machine.follower).items():
        yield path, trace, edge_offset(machine.follower.flanks, path)


class CounterBaseRadius(Limit):
    """The counter cam's base radius ≥ ``min_mm``: its traced curve stays Rr + min off the axis."""

    kind: Literal["counter_base_radius"] = "counter_base_radius"
    title: ClassVar[str] = "Base radius of the counter cam"
    same_on_every_segment: ClassVar[bool] = True
    min_mm: float = Field(
        0.0, ge=0.0, le=1e9, description="Smallest base radius of the counter cam."
    )

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
