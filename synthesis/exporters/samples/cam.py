"""The finished cam as a file sees it: evaluated anywhere, with the places where its parts meet."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from synthesis.catalogue.fields import Rotation
from synthesis.catalogue.followers import Follower
from synthesis.catalogue.followers.kinematics import Flank, labelled
from synthesis.catalogue.motion import Motion
from synthesis.catalogue.profile import CamProfile, cam_profile
from synthesis.design.design import Design
from synthesis.errors import InputError
from synthesis.exporters.options import CURVES, CurveName, PlacedCurve, is_pitch
from synthesis.numerics.piecewise import Array, Mask, Side
from synthesis.units import FULL_TURN, Travel, rad_per_s

# A step of a derivative smaller than this part of its peak is rounding, not a jump.
ROUNDING = 1e-6
SMOOTH = 4  # order of a joint where no derivative up to the third jumps


@dataclass(frozen=True, eq=False)
class Joints:
    """Where pieces of the motion meet, the first at cam angle 0.

    Attributes:
        theta: (n,) cam angles in [0, 2π) [rad].
        order: (n,) lowest derivative of s that jumps there; SMOOTH if none up to the third does.
        border: (n,) whether two segments meet there.
    """

    theta: Array
    order: NDArray[np.intp]
    border: Mask

    def breaking(self, highest: int) -> Array:
        """Angles where a derivative up to the given one jumps [rad]."""
        return self.theta[self.order <= highest]

    def marked(self, highest: int) -> Array:
        """The same, and every border of a segment [rad]."""
        return self.theta[self.border | (self.order <= highest)]


@dataclass(frozen=True, eq=False)
class Turn:
    """One turn of a shaft: the follower's motion, the unit of its travel, the speed [rad/s]."""

    motion: Motion
    travel: Travel
    omega: float

    def rate(self, order: int) -> float:
        """Factor from s^(order) per radian to the time derivative in the unit of travel."""
        return self.travel.wire_factor(order, self.omega)

    def derivatives(self, theta: Array, left: Mask) -> Array:
        """s and its derivatives (4, n) at θ [mm, per radian], one-sided likewise."""
        s = self.motion.derivatives(theta, 3, "right")
        s[:, left] = self.motion.derivatives(theta[left], 3, "left")
        return s

    @cached_property
    def advance(self) -> float:
        """How much further s is after a turn [mm]: 0 of a cam, but an indexer's step."""
        segments = self.motion.segments
        heights = [each.s_end for each in segments]
        step = heights[-1] - segments[0].s_start
        return step if abs(step) > ROUNDING * max(map(abs, heights)) else 0.0

    @cached_property
    def joints(self) -> Joints:
        """Where pieces of the motion meet."""
        theta = self.motion.curve.breaks[:-1]
        left = self.motion.derivatives(theta, 3, "left")
        left[0, 0] -= self.advance  # at cam angle 0, the turn before
        right = self.motion.derivatives(theta, 3, "right")
        turn = np.linspace(0.0, FULL_TURN, 721)
        everywhere = np.abs(np.hstack([left, right, self.motion.derivatives(turn, 3)]))
        peak = np.max(everywhere, axis=1, keepdims=True)
        # Where a derivative vanishes altogether, its rounding is measured by the displacement's.
        jumps = np.abs(right - left) > ROUNDING * np.maximum(peak, 0.1 * peak[0])
        order = np.where(jumps.any(axis=0), np.argmax(jumps, axis=0), SMOOTH)
        starts = [s.start for s in self.motion.segments if s.angle > 0.0]
        return Joints(theta, order, np.isin(theta, starts))

    @cached_property
    def seam(self) -> float:
        """Middle of the longest dwell [rad], where a closed curve is best cut; without one, 0.

        Dwells that touch count as one, also across cam angle 0.
        """
        moving = [s for s in self.motion.segments if s.angle > 0.0 and s.kind != "dwell"]
        ends = [s.end for s in moving]
        starts = [s.start for s in moving[1:]] + [moving[0].start + FULL_TURN]
        still = [(start - end, end) for end, start in zip(ends, starts, strict=True)]
        length, begin = max(still, key=lambda rest: (round(rest[0], 9), -rest[1]))
        return (begin + 0.5 * length) % FULL_TURN if length > 1e-9 else 0.0


@dataclass(frozen=True, eq=False)
class Cam(Turn):
    """A design's cam and one of its curves.

    Attributes:
        flank: the flank that the curve is, or belongs to.
        gap: of the curve inwards from the traced one, along its outward normal [mm]: σD of the
            flank itself, 0 of the pitch curve, σ(D − Rc) of the path of a cutter of radius Rc.
        the rest as of ``Turn`` and in ``cam_profile``.
    """

    follower: Follower
    size: tuple[float, ...]
    rotation: Rotation
    flank: Flank
    gap: float

    @classmethod
    def of(cls, design: Design, options: PlacedCurve | None = None) -> Cam:
        """The cam of a design and the curve that is asked for, its first profile unless said.

        A given cam that breaks its limits is infeasible, and yet can be drawn. InputError: the
        design found no cam, or its cam has no such curve.
        """
        if not design.motion:
            raise InputError(
                "/status",
                design.status,
                "A design that found no cam has no profile and no motion.",
                "Take a value of `needed` from its field `conflict`, and ask again.",
            )
        follower = design.completed_spec.follower
        flank = _flank(follower, options.curve if options else "profile")
        return cls(
            design.curve, follower.travel, rad_per_s(design.speed_rpm), follower,
            tuple(design.size), design.rotation, flank, _gap(flank, options),
        )  # fmt: skip

    def flanks(self) -> Iterator[Cam]:
        """The same cam once for each of its flanks."""
        for flank in self.follower.flanks:
            yield replace(self, flank=flank, gap=_gap(flank, None))

    def at(self, theta: Array, left: Mask | None = None) -> CamProfile:
        """The cam at θ (n,) [rad]; where ``left`` (n,) holds, the limits from the left."""
        at = self._one_sided(theta, "right")
        if left is not None and left.any():
            before = self._one_sided(theta[left], "left")
            for field in fields(CamProfile):
                if field.name != "theta":
                    getattr(at, field.name)[..., left] = getattr(before, field.name)
        return at

    def place(self, at: CamProfile) -> tuple[Array, Array]:
        """x and y of the curve [mm], in the cam's frame."""
        return at.pitch_x - self.gap * at.normal_x, at.pitch_y - self.gap * at.normal_y

    def _one_sided(self, theta: Array, side: Side) -> CamProfile:
        return cam_profile(
            self.motion, self.follower, self.size, self.rotation, theta, side, self.flank
        )


def profiles(design: Design) -> dict[str, CurveName]:
    """Every flank of a design's cam as a curve, by the stem of its file: profile, profile-outer."""
    further = {flank.name for flank in design.completed_spec.follower.flanks[1:]}
    curves: dict[str, CurveName] = {"profile": "profile"}
    return curves | {f"profile-{each}": each for each in CURVES if each in further}


def _flank(follower: Follower, curve: CurveName) -> Flank:
    """The flank that a curve is of; InputError where the cam has none of this name."""
    first, *others = follower.flanks
    counter_paths = follower.closure.counter_paths
    curves = {"profile": first, "pitch": first}
    curves |= {flank.name: flank for flank in follower.flanks if flank.name}
    curves |= {labelled(each.path, "pitch"): each for each in others if each.path in counter_paths}
    curves |= {"cutter": first, **{f"{flank.name}_cutter": flank for flank in others}}
    if curve in curves:
        return curves[curve]
    raise InputError(
        "/curve", curve, f"This cam has no such curve. Its curves are {', '.join(curves)}.",
        "Choose one of these.",
    )  # fmt: skip


def _gap(flank: Flank, options: PlacedCurve | None) -> float:
    """See ``Cam.gap``."""
    if options is not None and is_pitch(options.curve):
        return 0.0
    diameter = options.cutter_diameter_mm if options is not None else None  # of cutters only
    return flank.side * (flank.distance - 0.5 * (diameter or 0.0))
