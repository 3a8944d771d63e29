"""Radii of the profile: of its curvature, and about the cam's axis.

The smallest radius where it is convex (at 0: no undercut) and that of its hollows are bounds on the
curvature κ of the traced curve, which are free of division by what vanishes where the curve turns
from convex to hollow. Of a flank on the side σ at the distance D, c = +1 where it is convex and −1
where it is hollow: radius ≥ r is c σκ ≤ 1/(r + c D), and the radius is 1/(c σκ) − c D.
"""

from __future__ import annotations

from abc import ABC
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, ClassVar, Literal

from pydantic import Field
from pydantic_core import PydanticCustomError

from synthesis.catalogue.box_bounds import BoxBounds
from synthesis.catalogue.constraints import LinearInequality, NonconvexConstraints, NormBounds
from synthesis.catalogue.followers.base import Follower, paths
from synthesis.catalogue.followers.kinematics import Flank, TracePoint, edge_offset, labelled
from synthesis.catalogue.limits.base import Claim, Limit, Machine, scaling
from synthesis.catalogue.limits.forces import push_sign
from synthesis.catalogue.motion import PlacedSegment, Segments
from synthesis.numerics.piecewise import Array


class FlankRadius(Limit, ABC):
    """Radius of every flank ≥ a least one where it bends one way.

    Attributes:
        sign: c. field: of the least radius.
    """

    sign: ClassVar[int]
    field: ClassVar[str]
    same_on_every_segment: ClassVar[bool] = True

    def _flanks(self, machine: Machine) -> Iterator[tuple[Flank, float]]:
        """Flanks that may break it, and the least radius of their traced curves, r + c D [mm]."""
        for flank in machine.follower.flanks:
            radius = getattr(self, self.field) + self.sign * flank.distance
            if radius > 0.0:
                yield flank, radius

    def curvature_bounds(self, segment: PlacedSegment, machine: Machine) -> BoxBounds:
        return tuple(
            replace(rows, source=labelled(self.kind, flank.name))
            for flank, radius in self._flanks(machine)
            for rows in flank.trace.curvature_bounds(self.sign * flank.side, 1.0 / radius)
        )

    def claims(self, segments: Segments, machine: Machine) -> tuple[Claim, ...]:
        return tuple(self._curvature_claim(segments, *each) for each in self._flanks(machine))

    def _curvature_claim(self, segments: Segments, flank: Flank, radius: float) -> Claim:
        side, distance = self.sign * flank.side, self.sign * flank.distance

        def to_wire(curvature: float) -> float | None:
            bend = side * curvature
            return 1.0 / bend - distance if bend > 0.0 else None

        sharpest = side / radius
        bounds = (None, sharpest) if side > 0 else (sharpest, None)
        return self._claim(
            segments, bounds, self.field, "mm", label=flank.name,
            quantity="pitch_curvature", to_wire=to_wire, path=flank.path,
        )  # fmt: skip


class ProfileRadius(FlankRadius):
    """Radius of the convex profile ≥ ``min_mm``: ρ_pitch ≥ Rr + min wherever ρ_pitch is positive.

    A hollow flank (negative curvature) is the business of the limit ``cutter_radius``.

    Note:
        The follower says it in linear rows where it can (a flat face: ρ = Rb + s + s''). For a
        roller it is written as κ_pitch ≤ 1/(Rr + min), which is free of division by what may
        vanish; of a flank touched from inside with −κ_pitch, because there a hollow pitch curve is
        convex.
    """

    kind: Literal["profile_radius"] = "profile_radius"
    title: ClassVar[str] = "Smallest convex radius of the profile"
    sign: ClassVar[int] = 1
    field: ClassVar[str] = "min_mm"
    min_mm: float = Field(
        0.0, ge=0.0, le=1e6, description="Smallest radius of the convex profile; 0: no undercut."
    )

    @property
    def bounds_size_below(self) -> bool:
        return self.min_mm > 0.0  # at 0 it says what every cam keeps

    @property
    def min_circle_radius(self) -> float:
        return self.min_mm

    def rows(self, segment: PlacedSegment, machine: Machine) -> tuple[LinearInequality, ...]:
        rows = machine.follower.profile_radius_rows(self.min_mm)
        return tuple(replace(row, source="profile_radius") for row in rows)

    def nonconvex(self, segment: PlacedSegment, machine: Machine) -> NonconvexConstraints:
        curves = machine.follower.profile_radius_constraints(self.min_mm)
        return tuple(replace(curve, source="profile_radius") for curve in curves)

    def smooth_constraints(
        self, segment: PlacedSegment, machine: Machine, theta: Array, s: Any, z: Any
    ) -> tuple[Any, ...]:
        curved = super().smooth_constraints(segment, machine, theta, s, z)
        if curved or self.rows(segment, machine):
            return curved
        found = []
        for flank, radius in self._flanks(machine):
            numerator, speed_squared = flank.trace.curvature_terms(s, z)
            # σκ ≤ 1/ρ_min with κ = N/W³, divided by W² to keep the size of the numbers even
            found.append(flank.side * radius * numerator / speed_squared**1.5 - 1.0)
        return tuple(found)

    def claims(self, segments: Segments, machine: Machine) -> tuple[Claim, ...]:
        if not machine.follower.always_convex:
            return super().claims(segments, machine)
        # Under a flat face, whose profile has no hollows, the radius itself is measured.
        bounds = self.min_mm, None
        return (self._claim(segments, bounds, "min_mm", "mm", quantity="face_radius"),)


class CutterRadius(FlankRadius):
    """Hollow flanks must let in a cutter of radius ``radius_mm``: |ρ_profile| ≥ Rg there.

    A cutter not larger than the roller fits everywhere.

    Note:
        With ρ_profile = |ρ_pitch| + D on a hollow at the distance D this is σκ_pitch ≥ −1/(Rg − D),
        σ = 1 where the cam is touched from outside, −1 from inside.
    """

    kind: Literal["cutter_radius"] = "cutter_radius"
    title: ClassVar[str] = "Cutter or grinding wheel that must fit every hollow"
    bounds_size_below: ClassVar[bool] = True
    sign: ClassVar[int] = -1
    field: ClassVar[str] = "radius_mm"
    radius_mm: float = Field(gt=0.0, le=1e9, description="Radius of the cutter.")

    def _flanks(self, machine: Machine) -> Iterator[tuple[Flank, float]]:
        return iter(()) if machine.follower.always_convex else super()._flanks(machine)

    def smooth_constraints(
        self, segment: PlacedSegment, machine: Machine, theta: Array, s: Any, z: Any
    ) -> tuple[Any, ...]:
        found = []
        for flank, radius in self._flanks(machine):
            numerator, speed_squared = flank.trace.curvature_terms(s, z)
            speed = speed_squared**0.5
            # σκ ≥ −1/R times W/(W + R): even numbers for a cutter of any size, the same zero
            bend = flank.side * radius * numerator
            found.append(-(bend / speed_squared + speed) / (speed + radius))
        return tuple(found)


class OuterRadius(Limit):
    """No point of the profile lies farther from the cam's axis than ``max_mm``.

    The rim that the spec asks for is counted in.

    Note:
        Where the profile is outermost its normal is radial, so the pitch curve is outermost there
        too: the profile's largest radius is the pitch curve's less Rr, or plus Rr where the cam
        lies around the roller; there the rim that the spec asks for is added.
    """

    kind: Literal["outer_radius"] = "outer_radius"
    title: ClassVar[str] = "Largest radius of the profile"
    max_mm: float = Field(gt=0.0, le=1e9, description="Largest radius of the profile.")

    def check(self, segments: Segments, machine: Machine, position: int) -> None:
        for *_, gap in _edges(machine.follower.without_free_counter()):
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
            NormBounds(norm, trace.norm_from_radius(self.max_mm + gap), labelled(self.kind, path))
            for path, trace, gap in _edges(machine.follower)
            if (norm := trace.outer_radius_norm(highest)) is not None
        )

    def rows(self, segment: PlacedSegment, machine: Machine) -> tuple[LinearInequality, ...]:
        """Of a law that may overshoot the ends: what the norm's last component says."""
        found = list[LinearInequality]()
        for path, trace, gap in _edges(machine.follower) if segment.may_overshoot else ():
            low, high = trace.outer_radius_norm(0.0), trace.outer_radius_norm(1.0)
            if low is None or high is None or low.matrix != high.matrix:
                continue
            rise = high.shift[-1] - low.shift[-1]
            if rise > 0.0:
                most = trace.norm_from_radius(self.max_mm + gap) - low.shift[-1]
                row = LinearInequality((rise, 0.0, 0.0, 0.0), low.matrix[-1], most)
                found.append(replace(row, source=labelled(self.kind, path)))
        return tuple(found)

    def nonconvex(self, segment: PlacedSegment, machine: Machine) -> NonconvexConstraints:
        curves = machine.follower.outer_radius_constraints(self.max_mm)
        return tuple(replace(curve, source="outer_radius") for curve in curves)

    def smooth_constraints(
        self, segment: PlacedSegment, machine: Machine, theta: Array, s: Any, z: Any
    ) -> tuple[Any, ...]:
        found = list(super().smooth_constraints(segment, machine, theta, s, z))
        if segment.may_overshoot and not found:
            for _, trace, gap in _edges(machine.follower):
                (x, y), *_ = trace.position(s, z)
                found.append((x * x + y * y) / (self.max_mm + gap) ** 2 - 1.0)
        return tuple(found)

    def claims(self, segments: Segments, machine: Machine) -> tuple[Claim, ...]:
        return tuple(
            self._claim(
                segments, (None, self.max_mm + gap), "max_mm", "mm", label=path,
                quantity="pitch_radius", to_wire=scaling(1.0, gap), path=path,
            )
            for path, _, gap in _edges(machine.follower)
        )  # fmt: skip


def _edges(follower: Follower) -> Iterator[tuple[str, TracePoint, float]]:
    """Every path by name, and what the edge of its cam lacks to it [mm]."""
    for path, trace in paths(follower).items():
        yield path, trace, edge_offset(follower.flanks, path)


class CounterBaseRadius(Limit):
    """The counter cam's base radius ≥ ``min_mm``: its traced curve stays Rr + min off the axis."""

    kind: Literal["counter_base_radius"] = "counter_base_radius"
    title: ClassVar[str] = "Base radius of the counter cam"
    bounds_size_below: ClassVar[bool] = True
    same_on_every_segment: ClassVar[bool] = True
    min_mm: float = Field(
        0.0, ge=0.0, le=1e9, description="Smallest base radius of the counter cam."
    )

    def applies_to(self, follower: Follower) -> bool:
        return bool(follower.closure.counter_paths)

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
            least = (flank.distance + self.min_mm) * (flank.distance + self.min_mm)
            (px, py), *_ = flank.trace.position(s, z)
            square = px * px + py * py
            found.append((least - square) / (least + square))
        return tuple(found)

    def claims(self, segments: Segments, machine: Machine) -> tuple[Claim, ...]:
        return tuple(
            self._claim(
                segments, (flank.distance + self.min_mm, None), "min_mm", "mm",
                quantity="pitch_radius", to_wire=scaling(1.0, flank.distance), path=flank.path,
            )
            for flank in _counters(machine)
        )  # fmt: skip


def _counters(machine: Machine) -> Iterator[Flank]:
    """The flanks of counter cams."""
    return (flank for flank in machine.follower.flanks if push_sign(flank, machine) < 0)
