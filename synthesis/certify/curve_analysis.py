"""The curves of a given cam: extremes, discontinuities, undercut and self-intersection."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final, get_args

import numpy as np

from synthesis.catalogue.followers.base import paths, prime_radius
from synthesis.catalogue.followers.kinematics import (
    Flank,
    TracePoint,
    labelled,
)
from synthesis.catalogue.limits.base import scaling, segment_indices
from synthesis.certify.motion_checks import DERIVATIVES
from synthesis.certify.piecewise_motion import ANGLE_ROUNDING
from synthesis.certify.quantities import QUANTITIES, MeasuredCam, Quantity
from synthesis.certify.self_intersection import deepest_interference
from synthesis.design.analysis import (
    CurveJump,
    CurveSummary,
    Over,
    Peak,
    SelfCrossing,
    Side,
    Undercut,
)
from synthesis.numerics.enclosure import Enclosure, ExtremumQuery
from synthesis.numerics.piecewise import Indices
from synthesis.units import DEGREE

ToWire = Callable[[float], float]
CURVATURE: Final = QUANTITIES["pitch_curvature"]
CURVATURE_UNIT: Final = "1/mm"
CUSP: Final = 1e-9  # profile radii of this share of the roller, or of the cam, count as zero
ANGLE_DIGITS: Final = 9  # decimals of a cam angle: drops the rounding of degrees to rad and back


@dataclass(frozen=True, eq=False)
class CurveAnalysis:
    """The curves of a given cam."""

    cam: MeasuredCam

    # -- results -----------------------------------------------------------------------------

    def summaries(self) -> list[CurveSummary]:
        """The extremes of every curve."""
        found, degrees = list[CurveSummary](), scaling(1.0 / DEGREE)
        for order, name in enumerate(DERIVATIVES[:4]):
            unit, to_wire = (
                self.cam.machine.derivative_unit(order),
                scaling(self.cam.machine.wire_factor(order)),
            )
            found.append(self._summary(name, "turn", QUANTITIES[name], unit, to_wire))
        for path in self._paths:
            name, quantity = labelled("pressure_angle", path), QUANTITIES["pressure_angle"]
            found += [
                self._summary(name, over, quantity, "deg", degrees, path)
                for over in get_args(Over)
                if over == "turn" or segment_indices(self.cam.motion.segments, over)
            ]
        for path in self._paths:
            name, quantity, unit = self._bending
            summary = self._summary(
                labelled(name, path), "turn", quantity, unit, scaling(1.0), path
            )
            found += [summary, *(self._flank_radii(summary, path) if self._has_curvature else ())]
        return found

    def jumps(self) -> list[CurveJump]:
        """Every jump of s, s', s'' and of the curvature, in the order of the cam angle."""
        found, junctions = [], set()
        for order in range(3):
            unit, to_wire = (
                self.cam.machine.derivative_unit(order),
                self.cam.machine.wire_factor(order),
            )
            for junction in self._discontinuities(order).tolist():
                before, after = (
                    side[order] * to_wire for side in self.cam.motion.one_sided_values(junction)
                )
                found.append(self._jump(DERIVATIVES[order], unit, junction, before, after))
                junctions.add(junction)
        name, quantity, unit = self._bending
        for junction in junctions:
            for path in self._paths:
                sides = self.cam.one_sided((quantity, path), junction)
                found.append(self._jump(labelled(name, path), unit, junction, *sides))
        return sorted(found, key=lambda jump: jump.angle_deg)

    def undercut(self) -> Undercut | None:
        """Where the profile is undercut or has a cusp; of several flanks the worst."""
        if not self._has_curvature:
            return self._face_undercut()
        each = map(self._roller_undercut, self.cam.machine.follower.flanks)
        found = [undercut for undercut in each if undercut is not None]
        return max(found, key=lambda undercut: undercut.excess_mm, default=None)

    def self_crossing(self) -> SelfCrossing | None:
        """Where a roller cuts deepest into a far part of its flank."""
        found = deepest_interference(self.cam)
        if found is None:
            return None
        flank, pair = found
        return SelfCrossing(
            profile_deg=_degrees(pair.profile_angle), roller_deg=_degrees(pair.roller_angle),
            depth_mm=flank.distance - pair.distance, flank=flank.name,
        )  # fmt: skip

    # -- undercut ----------------------------------------------------------------------------

    def _roller_undercut(self, flank: Flank) -> Undercut | None:
        """Where the roller is larger than the radius of the traced curve, convex for the flank."""
        roller = flank.distance
        if roller <= 0.0:
            return None
        # junctions at which the traced curve has a corner that is convex for the flank
        turns = ((k, self.cam.turning_at(flank.path, k)) for k in self._discontinuities(1).tolist())
        corner = next((k for k, turn in turns if flank.side * turn > 0.0), None)
        if corner is not None:
            return Undercut(
                kind="corner", angle_deg=self._angle(corner), pitch_radius_mm=0.0,
                roller_radius_mm=roller, excess_mm=roller, flank=flank.name,
            )  # fmt: skip
        sharpest = self._extreme(CURVATURE, self._everywhere, flank.side, flank.path)
        curvature = flank.side * sharpest.value
        excess = roller - 1.0 / curvature if curvature > 0.0 else -math.inf
        if excess < -CUSP * roller:
            return None
        return Undercut(
            kind="undercut" if excess > CUSP * roller else "cusp",
            angle_deg=_degrees(sharpest.angle), pitch_radius_mm=1.0 / curvature,
            roller_radius_mm=roller, excess_mm=excess, flank=flank.name,
        )  # fmt: skip

    def _face_undercut(self) -> Undercut | None:
        """Where the profile's radius under a flat face is not positive."""
        _, quantity, _ = self._bending
        least = self._extreme(quantity, self._everywhere, -1)
        cusp = CUSP * prime_radius(self.cam.machine.follower, self.cam.size)
        if least.value > cusp:
            return None
        return Undercut(
            kind="undercut" if least.value < -cusp else "cusp",
            angle_deg=_degrees(least.angle), pitch_radius_mm=least.value, roller_radius_mm=0.0,
            excess_mm=-least.value,
        )  # fmt: skip

    # -- extremes ----------------------------------------------------------------------------

    @cached_property
    def _paths(self) -> Mapping[str, TracePoint]:
        """The traced curves."""
        return paths(self.cam.machine.follower)

    @cached_property
    def _has_curvature(self) -> bool:
        """Whether the profile's radius follows from the curvature of a traced curve.

        Under a flat face it does not.
        """
        return not self.cam.machine.follower.always_convex

    @cached_property
    def _bending(self) -> tuple[str, Quantity, str]:
        """The quantity that says how sharply the profile bends: its name, itself, its unit."""
        if self._has_curvature:
            return "pitch_curvature", CURVATURE, CURVATURE_UNIT
        return "profile_radius", QUANTITIES["face_radius"], "mm"

    def _summary(
        self,
        name: str,
        over: Over,
        quantity: Quantity,
        unit: str,
        to_wire: ToWire,
        path: str = "",
    ) -> CurveSummary:
        kinds = () if over == "turn" else (over,)
        segments = segment_indices(self.cam.motion.segments, *kinds)
        largest, smallest = (
            self._peak(quantity, self._extreme(quantity, segments, side, path), to_wire, path)
            for side in (1, -1)
        )
        return CurveSummary(
            curve=name, over=over, unit=unit, largest=largest, smallest=smallest,
            infinite_deg=self._infinite(quantity),
        )  # fmt: skip

    def _flank_radii(self, curvature: CurveSummary, path: str) -> Iterator[CurveSummary]:
        """The smallest convex and the smallest concave radius of every flank of a path.

        A flank at the signed distance D from the traced curve has the radius ρ − D where it is
        convex, ρ + D where it is concave (see ``catalogue/followers/kinematics.py``).
        """
        for flank in self.cam.machine.follower.flanks:
            if flank.path != path:
                continue
            ends = (curvature.largest, curvature.smallest)
            convex, hollow = ends if flank.side > 0 else ends[::-1]
            for name, peak, sign in (
                ("convex_radius", convex, 1.0), ("hollow_radius", hollow, -1.0)
            ):  # fmt: skip
                least = None
                if peak is not None and flank.side * peak.value * sign > 0.0:
                    radius = flank.side * sign / peak.value
                    value, width = radius - sign * flank.distance, radius * radius * peak.width
                    least = peak.model_copy(update={"value": value, "width": width})
                yield CurveSummary(
                    curve=labelled(name, flank.name), over="turn", unit="mm", largest=None,
                    smallest=least, infinite_deg=[],
                )  # fmt: skip

    def _extreme(
        self, quantity: Quantity, segments: Sequence[int], side: int, path: str = ""
    ) -> Enclosure:
        """The largest value (side 1) or the smallest (−1) on these segments."""
        lower, upper = (-math.inf, 0.0) if side > 0 else (0.0, math.inf)
        question = ExtremumQuery(self.cam.motion.pieces_of(segments), lower, upper)
        return self.cam.enclose([(quantity, path)], [question])[0].enclosure

    def _peak(
        self, quantity: Quantity, found: Enclosure, to_wire: ToWire, path: str = ""
    ) -> Peak | None:
        if not math.isfinite(found.value):
            return None
        ends = to_wire(found.lower), to_wire(found.upper)
        return Peak(
            value=to_wire(found.value), angle_deg=_degrees(found.angle),
            side=self._side(quantity, found, path), width=abs(ends[1] - ends[0]),
        )  # fmt: skip

    def _side(self, quantity: Quantity, found: Enclosure, path: str = "") -> Side:
        """On which side of a junction an extreme lies, where the curve jumps there."""
        ends = self.cam.motion.curve.breaks[1:]
        junction = int(np.argmin(np.abs(ends - found.angle)))
        if found.angle <= ANGLE_ROUNDING:
            junction = len(ends) - 1
        elif abs(float(ends[junction]) - found.angle) > ANGLE_ROUNDING:
            return "both"
        if not any(junction in self._discontinuities(k) for k in range(quantity.order + 1)):
            return "both"
        before, after = self.cam.one_sided((quantity, path), junction)
        return "left" if abs(before - found.value) <= abs(after - found.value) else "right"

    # -- junctions ---------------------------------------------------------------------------

    @cached_property
    def _everywhere(self) -> tuple[int, ...]:
        return segment_indices(self.cam.motion.segments)

    def _discontinuities(self, order: int) -> Indices:
        return self.cam.motion.discontinuities(order, np.arange(self.cam.motion.curve.count))

    def _angle(self, junction: int) -> float:
        """Cam angle of a junction; the one that closes the turn is at 0."""
        last = junction == self.cam.motion.curve.count - 1
        return 0.0 if last else _degrees(float(self.cam.motion.curve.breaks[junction + 1]))

    def _jump(self, name: str, unit: str, junction: int, before: float, after: float) -> CurveJump:
        return CurveJump(
            curve=name, unit=unit, angle_deg=self._angle(junction), before=before, after=after,
            jump=after - before,
        )  # fmt: skip

    def _infinite(self, quantity: Quantity) -> list[float]:
        """Cam angles at which a curve is infinite [deg]."""
        orders = range(1, 2) if quantity.infinite_at_corners else range(quantity.continuous_below)
        junctions = {k for order in orders for k in self._discontinuities(order).tolist()}
        return sorted(self._angle(junction) for junction in junctions)


def _degrees(angle: float) -> float:
    return round(angle / DEGREE, ANGLE_DIGITS)
