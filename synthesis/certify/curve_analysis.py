"""The curves of a given cam: extremes, discontinuities, undercut and self-intersection."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final, get_args

import numpy as np

from synthesis.catalogue.followers.base import paths, prime_radius
from synthesis.catalogue.followers.kinematics import Flank, labelled
from synthesis.catalogue.limits.base import segment_indices
from synthesis.certify.motion_checks import DERIVATIVES
from synthesis.certify.piecewise_motion import ANGLE_ROUNDING
from synthesis.certify.quantities import BOUNDS, QUANTITIES, MeasuredCam, Quantity
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
from synthesis.numerics.enclosure import Enclosure
from synthesis.numerics.piecewise import Indices
from synthesis.units import DEGREE

CUSP: Final = 1e-9  # profile radii of this share of the roller, or of the cam, count as zero
ANGLE_DIGITS: Final = 9  # decimals of a cam angle: drops the rounding of degrees to rad and back


@dataclass(frozen=True, eq=False)
class _Curve:
    """A curve of the analysis: name, unit and factor on the wire, and what is measured where."""

    name: str
    unit: str
    factor: float
    quantity: Quantity
    path: str = ""


@dataclass(frozen=True, eq=False)
class CurveAnalysis:
    """The curves of a given cam."""

    cam: MeasuredCam

    def summaries(self) -> list[CurveSummary]:
        """The extremes of every curve."""
        found = [self._summary(curve) for curve in self._derivatives]
        for path in self._paths:
            name, quantity = labelled("pressure_angle", path), QUANTITIES["pressure_angle"]
            curve = _Curve(name, "deg", 1.0 / DEGREE, quantity, path)
            found += [
                self._summary(curve, over)
                for over in get_args(Over)
                if over == "turn" or segment_indices(self.cam.motion.segments, over)
            ]
        for curve in self._bends:
            summary = self._summary(curve)
            found += [summary, *self._flank_radii(summary, curve.path)]
        return found

    def jumps(self) -> list[CurveJump]:
        """Every jump of s, s', s'' and of the curvature, in the order of the cam angle."""
        found, junctions = list[CurveJump](), dict[int, None]()
        for order in range(3):
            for junction in self._discontinuities(order).tolist():
                found.append(self._jump(self._derivatives[order], junction))
                junctions[junction] = None
        found += [self._jump(curve, junction) for junction in junctions for curve in self._bends]
        return sorted(found, key=lambda jump: jump.angle_deg)

    def undercut(self) -> Undercut | None:
        """Where the profile is undercut or has a cusp; of several flanks the worst."""
        if self._has_curvature:
            each = [self._roller_undercut(flank) for flank in self.cam.machine.follower.flanks]
        else:  # where the profile's radius under a flat face is not positive
            least = self._extreme(self._bends[0], self._everywhere, -1)
            small = CUSP * prime_radius(self.cam.machine.follower, self.cam.size)
            each = [_undercut("", 0.0, least.value, _degrees(least.angle), small)]
        return max(filter(None, each), key=lambda found: found.excess_mm, default=None)

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

    def _roller_undercut(self, flank: Flank) -> Undercut | None:
        """Where the roller is larger than the radius of the traced curve, convex for the flank."""
        roller = flank.distance
        if roller <= 0.0:
            return None
        # junctions at which the traced curve has a corner that is convex for the flank
        for junction in self._discontinuities(1).tolist():
            if flank.side * self.cam.turning_at(flank.path, junction) > 0.0:
                return Undercut(
                    kind="corner", angle_deg=self._angle(junction), pitch_radius_mm=0.0,
                    roller_radius_mm=roller, excess_mm=roller, flank=flank.name,
                )  # fmt: skip
        curve = next(curve for curve in self._bends if curve.path == flank.path)
        sharpest = self._extreme(curve, self._everywhere, flank.side)
        curvature = flank.side * sharpest.value
        radius = 1.0 / curvature if curvature > 0.0 else math.inf
        return _undercut(flank.name, roller, radius, _degrees(sharpest.angle), CUSP * roller)

    @cached_property
    def _paths(self) -> list[str]:
        """Names of the traced curves."""
        return list(paths(self.cam.machine.follower))

    @cached_property
    def _has_curvature(self) -> bool:
        """Whether the profile's radius follows from the curvature of a traced curve.

        Under a flat face it does not.
        """
        return not self.cam.machine.follower.always_convex

    @cached_property
    def _derivatives(self) -> list[_Curve]:
        """Displacement to jerk."""
        machine = self.cam.machine
        return [
            _Curve(name, machine.derivative_unit(k), machine.wire_factor(k), QUANTITIES[name])
            for k, name in enumerate(DERIVATIVES[:4])
        ]

    @cached_property
    def _bends(self) -> list[_Curve]:
        """How sharply the profile bends, path by path."""
        name, quantity, unit = "profile_radius", QUANTITIES["face_radius"], "mm"
        if self._has_curvature:
            name, quantity, unit = "pitch_curvature", QUANTITIES["pitch_curvature"], "1/mm"
        return [_Curve(labelled(name, path), unit, 1.0, quantity, path) for path in self._paths]

    def _summary(self, curve: _Curve, over: Over = "turn") -> CurveSummary:
        kinds = () if over == "turn" else (over,)
        segments = segment_indices(self.cam.motion.segments, *kinds)
        largest, smallest = (
            self._peak(curve, self._extreme(curve, segments, side)) for side in (1, -1)
        )
        return CurveSummary(
            curve=curve.name, over=over, unit=curve.unit, largest=largest, smallest=smallest,
            infinite_deg=self._infinite(curve.quantity),
        )  # fmt: skip

    def _flank_radii(self, curvature: CurveSummary, path: str) -> Iterator[CurveSummary]:
        """The smallest convex and the smallest concave radius of every flank of a path.

        A flank at the signed distance D from the traced curve has the radius ρ − D where it is
        convex, ρ + D where it is concave (see ``catalogue/followers/kinematics.py``).
        """
        for flank in self.cam.machine.follower.flanks if self._has_curvature else ():
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

    def _extreme(self, curve: _Curve, segments: Sequence[int], side: int) -> Enclosure:
        """The largest value (side 1) or the smallest (−1) on these segments."""
        return self.cam.extreme((curve.quantity, curve.path), segments, BOUNDS[side]).enclosure

    def _peak(self, curve: _Curve, found: Enclosure) -> Peak | None:
        if not math.isfinite(found.value):
            return None
        return Peak(
            value=found.value * curve.factor, angle_deg=_degrees(found.angle),
            side=self._side(curve, found),
            width=abs(found.upper * curve.factor - found.lower * curve.factor),
        )  # fmt: skip

    def _side(self, curve: _Curve, found: Enclosure) -> Side:
        """On which side of a junction an extreme lies, where the curve jumps there."""
        ends = self.cam.motion.curve.breaks[1:]
        junction = int(np.argmin(np.abs(ends - found.angle)))
        if found.angle <= ANGLE_ROUNDING:
            junction = len(ends) - 1
        elif abs(float(ends[junction]) - found.angle) > ANGLE_ROUNDING:
            return "both"
        if not any(junction in self._discontinuities(k) for k in range(curve.quantity.order + 1)):
            return "both"
        before, after = self._one_sided(curve, junction)
        return "left" if abs(before - found.value) <= abs(after - found.value) else "right"

    @cached_property
    def _everywhere(self) -> tuple[int, ...]:
        return segment_indices(self.cam.motion.segments)

    def _discontinuities(self, order: int) -> Indices:
        return self.cam.motion.discontinuities(order, np.arange(self.cam.motion.curve.count))

    def _angle(self, junction: int) -> float:
        """Cam angle of a junction; the one that closes the turn is at 0."""
        last = junction == self.cam.motion.curve.count - 1
        return 0.0 if last else _degrees(float(self.cam.motion.curve.breaks[junction + 1]))

    def _one_sided(self, curve: _Curve, junction: int) -> tuple[float, float]:
        """Values of a curve on the left and on the right of a junction."""
        left, right = map(curve.quantity.formula, self.cam.sides(curve.path, junction))
        return float(left), float(right)

    def _jump(self, curve: _Curve, junction: int) -> CurveJump:
        before, after = (value * curve.factor for value in self._one_sided(curve, junction))
        return CurveJump(
            curve=curve.name, unit=curve.unit, angle_deg=self._angle(junction), before=before,
            after=after, jump=after - before,
        )  # fmt: skip

    def _infinite(self, quantity: Quantity) -> list[float]:
        """Cam angles at which a curve is infinite [deg]."""
        orders = range(1, 2) if quantity.infinite_at_corners else range(quantity.continuous_below)
        junctions = {k for order in orders for k in self._discontinuities(order).tolist()}
        return sorted(self._angle(junction) for junction in junctions)


def _undercut(
    flank: str, roller: float, radius: float, angle_deg: float, small: float
) -> Undercut | None:
    """What a radius of the traced curve, or under a face of the profile, means for a flank.

    ``small``: difference of roller and radius that counts as none [mm].
    """
    excess = roller - radius
    if excess < -small:
        return None
    return Undercut(
        kind="undercut" if excess > small else "cusp", angle_deg=angle_deg, pitch_radius_mm=radius,
        roller_radius_mm=roller, excess_mm=excess, flank=flank,
    )  # fmt: skip


def _degrees(angle: float) -> float:
    return round(angle / DEGREE, ANGLE_DIGITS)
