"""The curves of a given cam: their extremes, their jumps, and where the profile is undercut."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import get_args

import numpy as np

from synthesis.certify.course import Course, Indices
from synthesis.certify.joints import NAMES
from synthesis.certify.quantities import (
    QUANTITIES,
    Quantity,
    Sight,
    Size,
    enclose_all,
    traced,
)
from synthesis.certify.simple import deepest
from synthesis.findings import CurveJump, CurveSummary, Over, Peak, SelfCrossing, Side, Undercut
from synthesis.followers.flank import Flank, labelled
from synthesis.followers.trace import Trace
from synthesis.limits.base import Machine, times, where
from synthesis.motion import Motion
from synthesis.numerics.enclosure import Enclosed, Question
from synthesis.units import DEGREE

Map = Callable[[float], float]
CURVATURE = QUANTITIES["pitch_curvature"]
CURVATURE_UNIT = "1/mm"
AT_JOINT = 1e-9  # rad: an extreme this near to a joint is at it
CUSP = 1e-9  # of the roller radius: as large as the pitch curve's radius


@dataclass(frozen=True, eq=False)
class Curves:
    """A cam, given in full, as something to be summed up."""

    motion: Motion
    machine: Machine
    size: Size

    @cached_property
    def course(self) -> Course:
        """The motion as the judge sees it."""
        return Course(self.motion)

    def summaries(self) -> list[CurveSummary]:
        """The extremes of every curve."""
        found, degrees = list[CurveSummary](), times(1.0 / DEGREE)
        for order, name in enumerate(NAMES[:4]):
            unit, to_wire = self.machine.told(order), times(self.machine.rate(order))
            found.append(self._summary(name, "turn", QUANTITIES[name], unit, to_wire))
        for path in self._paths:
            name, quantity = labelled("pressure_angle", path), QUANTITIES["pressure_angle"]
            found += [
                self._summary(name, over, quantity, "deg", degrees, path)
                for over in get_args(Over)
                if over == "turn" or where(self.motion.stretches, over)
            ]
        for path in self._paths:
            name, quantity, unit = self._bend
            bend = self._summary(labelled(name, path), "turn", quantity, unit, times(1.0), path)
            found += [bend, *(self._radii(bend, path) if self._faceless else ())]
        return found

    def jumps(self) -> list[CurveJump]:
        """Every jump of s, s', s'' and of the curvature, in the order of the cam angle."""
        found, bent = [], set()
        for order in range(3):
            unit, to_wire = self.machine.told(order), self.machine.rate(order)
            for joint in self._breaches(order):
                before, after = (side[order] * to_wire for side in self.course.sides(int(joint)))
                found.append(self._jump(NAMES[order], unit, int(joint), before, after))
                bent.add(int(joint))
        for joint in bent:
            name, quantity, unit = self._bend
            for path in self._paths:
                sides = self._both(quantity, joint, path)
                found.append(self._jump(labelled(name, path), unit, joint, *sides))
        return sorted(found, key=lambda jump: jump.angle_deg)

    def undercut(self) -> Undercut | None:
        """Where the profile turns back: under a roller too large for it, or under a flat face.

        Of several flanks the one that is undercut most.
        """
        if not self._faceless:
            return self._undercut_face()
        each = map(self._undercut_flank, self.machine.follower.flanks)
        found = [undercut for undercut in each if undercut is not None]
        return max(found, key=lambda undercut: undercut.too_large_mm, default=None)

    def _undercut_flank(self, flank: Flank) -> Undercut | None:
        """Where the roller is too large for one flank."""
        roller = flank.distance
        if roller <= 0.0:
            return None
        corner = next(self._corners(flank), None)
        if corner is not None:
            return Undercut(
                kind="corner", angle_deg=self._angle(corner), pitch_radius_mm=0.0,
                roller_radius_mm=roller, too_large_mm=roller, flank=flank.name,
            )  # fmt: skip
        sharpest = self._extreme(CURVATURE, self._everywhere, flank.side, flank.path)
        bend = flank.side * sharpest.value
        excess = roller - 1.0 / bend if bend > 0.0 else -math.inf
        if excess < -CUSP * roller:
            return None
        return Undercut(
            kind="undercut" if excess > CUSP * roller else "cusp",
            angle_deg=_degrees(sharpest.angle), pitch_radius_mm=1.0 / bend,
            roller_radius_mm=roller, too_large_mm=excess, flank=flank.name,
        )  # fmt: skip

    def self_crossing(self) -> SelfCrossing | None:
        """Where far parts of a flank cross deepest; only under a roller do they."""
        found = deepest(self.course, self.machine, self.size)
        if found is None:
            return None
        flank, near = found
        return SelfCrossing(
            profile_deg=_degrees(near.profile), roller_deg=_degrees(near.roller),
            depth_mm=flank.distance - near.least, flank=flank.name,
        )  # fmt: skip

    def _undercut_face(self) -> Undercut | None:
        """Where the radius under a flat face is not positive."""
        _, quantity, _ = self._bend
        least = self._extreme(quantity, self._everywhere, -1)
        cusp = CUSP * self.machine.follower.radius(self.size)
        if least.value > cusp:
            return None
        return Undercut(
            kind="undercut" if least.value < -cusp else "cusp",
            angle_deg=_degrees(least.angle), pitch_radius_mm=least.value, roller_radius_mm=0.0,
            too_large_mm=-least.value,
        )  # fmt: skip

    # -- extremes ----------------------------------------------------------------------------

    @cached_property
    def _paths(self) -> Mapping[str, Trace]:
        """The traced curves."""
        return self.machine.follower.paths

    @cached_property
    def _faceless(self) -> bool:
        """Whether the profile's radius comes from a traced curve's curvature, not from a face."""
        follower = self.machine.follower
        measure = follower.profile_radius_measure(follower.flanks[0], 0.0)
        return measure is None or QUANTITIES[measure.quantity] is CURVATURE

    @cached_property
    def _bend(self) -> tuple[str, Quantity, str]:
        """What tells how sharply the profile bends: name, quantity, unit."""
        if self._faceless:
            return "pitch_curvature", CURVATURE, CURVATURE_UNIT
        return "profile_radius", QUANTITIES["face_radius"], "mm"

    def _summary(
        self, name: str, over: Over, quantity: Quantity, unit: str, to_wire: Map, path: str = ""
    ) -> CurveSummary:
        kinds = () if over == "turn" else (over,)
        stretches = where(self.motion.stretches, *kinds)
        largest, smallest = (
            self._peak(quantity, self._extreme(quantity, stretches, side, path), to_wire, path)
            for side in (1, -1)
        )
        return CurveSummary(
            curve=name, over=over, unit=unit, largest=largest, smallest=smallest,
            infinite_deg=self._infinite(quantity),
        )  # fmt: skip

    def _radii(self, curvature: CurveSummary, path: str) -> Iterator[CurveSummary]:
        """The sharpest convex and the sharpest hollow radius of every flank of a path."""
        for flank in self.machine.follower.flanks:
            if flank.path == path:
                yield from self._radii_of(flank, curvature)

    def _radii_of(self, flank: Flank, curvature: CurveSummary) -> Iterator[CurveSummary]:
        ends = (curvature.largest, curvature.smallest)
        convex, hollow = ends if flank.side > 0 else ends[::-1]
        for name, peak, sign in (("convex_radius", convex, 1.0), ("hollow_radius", hollow, -1.0)):
            least = None
            if peak is not None and flank.side * peak.value * sign > 0.0:
                pitch = flank.side * sign / peak.value
                width = pitch * pitch * peak.width
                value = pitch - sign * flank.distance
                least = peak.model_copy(update={"value": value, "width": width})
            yield CurveSummary(
                curve=labelled(name, flank.name), over="turn", unit="mm", largest=None,
                smallest=least, infinite_deg=[],
            )  # fmt: skip

    def _extreme(
        self, quantity: Quantity, stretches: Sequence[int], side: int, path: str = ""
    ) -> Enclosed:
        """The largest value (side 1) or the smallest (−1) on these stretches."""
        lower, upper = (-math.inf, 0.0) if side > 0 else (0.0, math.inf)
        question = Question(self.course.pieces(stretches), lower, upper)
        subjects = [(quantity, path)]
        (answer,) = enclose_all(subjects, self.course, self.machine, self.size, [question])
        return answer.extreme

    def _peak(
        self, quantity: Quantity, found: Enclosed, to_wire: Map, path: str = ""
    ) -> Peak | None:
        if not math.isfinite(found.value):
            return None
        ends = to_wire(found.lower), to_wire(found.upper)
        return Peak(
            value=to_wire(found.value), angle_deg=_degrees(found.angle),
            side=self._side(quantity, found, path), width=abs(ends[1] - ends[0]),
        )  # fmt: skip

    def _side(self, quantity: Quantity, found: Enclosed, path: str = "") -> Side:
        """Which side of a joint an extreme belongs to, where the curve jumps there."""
        ends = self.course.curve.breaks[1:]
        joint = int(np.argmin(np.abs(ends - found.angle)))
        if found.angle <= AT_JOINT:
            joint = len(ends) - 1
        elif abs(float(ends[joint]) - found.angle) > AT_JOINT:
            return "both"
        if not any(joint in self._breaches(order) for order in range(quantity.order + 1)):
            return "both"
        before, after = self._both(quantity, joint, path)
        return "left" if abs(before - found.value) <= abs(after - found.value) else "right"

    # -- joints ------------------------------------------------------------------------------

    @cached_property
    def _everywhere(self) -> tuple[int, ...]:
        return where(self.motion.stretches)

    def _breaches(self, order: int) -> Indices:
        return self.course.breaches(order, np.arange(self.course.curve.count))

    def _angle(self, joint: int) -> float:
        """Cam angle of a joint; the one that closes the turn is at 0."""
        last = joint == self.course.curve.count - 1
        return 0.0 if last else _degrees(float(self.course.curve.breaks[joint + 1]))

    def _both(self, quantity: Quantity, joint: int, path: str) -> tuple[float, float]:
        """A curve's values on the left and on the right of a joint."""
        before, after = (
            float(quantity.formula(Sight(traced(self.machine, path), self.size, side)))
            for side in self.course.sides(joint)
        )
        return before, after

    def _jump(self, name: str, unit: str, joint: int, before: float, after: float) -> CurveJump:
        return CurveJump(
            curve=name, unit=unit, angle_deg=self._angle(joint), before=before, after=after,
            jump=after - before,
        )  # fmt: skip

    def _infinite(self, quantity: Quantity) -> list[float]:
        """Cam angles at which a curve is infinite."""
        orders = range(1, 2) if quantity.turns else range(quantity.smooth)
        joints = {int(joint) for order in orders for joint in self._breaches(order)}
        return sorted(self._angle(joint) for joint in joints)

    def _corners(self, flank: Flank) -> Iterator[int]:
        """Joints at which the pitch curve turns on the spot, convexly as the flank sees it."""
        for joint in self._breaches(1):
            before, after = (
                Sight(flank.trace, self.size, side).tangent
                for side in self.course.sides(int(joint))
            )
            if flank.side * (before[1] * after[0] - before[0] * after[1]) > 0.0:
                yield int(joint)


def _degrees(angle: float) -> float:
    """An angle as it was asked for: without the trace of the way to rad and back."""
    return round(angle / DEGREE, 9)
