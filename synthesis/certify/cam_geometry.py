"""The finished cam as a body: radii, perimeter, area, mass; its rollers' speed, a face's sliding.

A flank q = p − g n, g = σ D, runs along its traced curve p with q' = T (1 − κ g), T = D p (see
``quantities``). All integrals are along it, by Green's theorem: area ½ ∮ q × q', first and second
moments likewise. Where the velocity jumps the roller turns about its centre, which stands still,
and the flank goes on along an arc about it; along a face it goes on straight.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np

from synthesis.catalogue.fields import Rotation
from synthesis.catalogue.followers.base import base_gap, flat_face, prime_radius
from synthesis.catalogue.followers.kinematics import Flank, Link
from synthesis.catalogue.forces.reduced import MILLI
from synthesis.certify.motion_summary import degrees
from synthesis.certify.quantities import MeasuredCam, TracedPoint, face_radius, pitch_curvature
from synthesis.design.summary import CamGeometry, FlankGeometry, MassProperties, PeakValue
from synthesis.numerics.chebyshev import EQUAL, Grid
from synthesis.numerics.geometry.plane import to_cam
from synthesis.numerics.piecewise import Array, Indices, gauss_points
from synthesis.spec.body import CamBody
from synthesis.units import DEGREE, FULL_TURN, PER_MINUTE

WIDEST: Final = 0.1  # [rad] of an interval on which a polynomial of degree 14 stands for a figure
ARC_NODES: Final = 24  # of Gauss's rule along the arc about a corner, of at most half a turn
STRAIGHT: Final = 1e-9  # curvature times prime radius: less is rounding, neither convex nor hollow
LARGE: Final = 1e100  # stands for the infinite curvature of a cusp [1/mm]


def summarise_geometry(
    cam: MeasuredCam, rotation: Rotation, body: CamBody | None = None
) -> CamGeometry:
    """Radii, perimeter, area and mass of a finished cam; speeds of its rollers or face."""
    flanks = cam.machine.follower.flanks
    grid = Grid.of(cam.motion.curve.breaks, WIDEST)
    measured = [_Measured(cam, flank, grid, -1.0 if rotation == "cw" else 1.0) for flank in flanks]
    each = [one.geometry() for one in measured]
    prime = prime_radius(cam.machine.follower, cam.size)
    return CamGeometry(
        base_radius_mm=prime - base_gap(cam.machine.follower),
        prime_radius_mm=prime,
        flanks=each,
        mass_properties=None if body is None else _mass(flanks, each, body),
    )


@dataclass(frozen=True, eq=False, kw_only=True)
class _FlankPoint(TracedPoint):
    """A traced point with the point of a flank at the distance ``gap`` = σ D inwards from it."""

    gap: float

    @cached_property
    def curvature(self) -> Any:
        """κ of the traced curve [1/mm]."""
        return pitch_curvature(self)

    @cached_property
    def curve(self) -> tuple[Array, Array, Array, Array]:
        """x, y of the flank and their derivatives along it, in the machine frame."""
        (px, py), (tx, ty) = self.position[0], self.tangent
        if self.gap == 0.0:
            return px, py, tx, ty
        nx, ny = self.trace.normal(self.tangent, self.s, self.size)
        offset, forward = self.gap / np.hypot(nx, ny), 1.0 - self.gap * self.curvature
        return px - offset * nx, py - offset * ny, forward * tx, forward * ty


@dataclass(frozen=True, eq=False)
class _Measured:
    """A flank of a cam on a grid of cam angles. ``mirror``: −1 of a cam that turns clockwise."""

    cam: MeasuredCam
    flank: Flank
    grid: Grid
    mirror: float

    def geometry(self) -> FlankGeometry:
        perimeter, area, centroid, polar = self._integrals()
        peaks = self._peaks()
        smallest = peaks["smallest_radius"]
        return FlankGeometry(
            flank=self.flank.name,
            largest_radius_mm=peaks["largest_radius"],
            smallest_radius_mm=_with(smallest, -smallest.value),
            perimeter_mm=perimeter,
            area_mm2=area,
            centroid_mm=centroid,
            polar_moment_mm4=polar,
            **self._radii(peaks),
            hollows=self._hollows(),
            sliding_speed_mm_per_s=_larger(peaks, "sliding"),
            roller_speed_rpm=_larger(peaks, "spin", PER_MINUTE),
            roller_acceleration_rad_per_s2=_larger(peaks, "spin_up"),
        )

    # the curve

    @cached_property
    def _points(self) -> _FlankPoint:
        return self._at(tuple(self.cam.motion.curve.jet(self.grid.x, self.grid.piece, 3)))

    def _at(self, s: tuple[Array, ...]) -> _FlankPoint:
        gap = self.flank.side * self.flank.distance
        return _FlankPoint(self.flank.trace, self.cam.size, s, gap=gap)

    def _integrals(self) -> tuple[float, float, tuple[float, float], float]:
        """Perimeter [mm], area [mm²], its centroid [mm] and its polar moment [mm⁴]."""
        theta, weights = self.grid.x, self.grid.weights
        parts: list[tuple[Array, ...]] = [(theta, weights, *self._points.curve)]
        parts += [self._bridge(int(k)) for k in self._corners]
        theta, weights, x, y, dx, dy = (np.concatenate(each) for each in zip(*parts, strict=True))
        cross = -weights * (x * dy - y * dx)  # the curve runs clockwise
        area = 0.5 * float(cross.sum())
        first = [float(cross @ each) / (3.0 * area) for each in to_cam(theta, x, y)]
        return (
            float(weights @ np.hypot(dx, dy)),
            area,
            (self.mirror * first[0] + 0.0, first[1] + 0.0),
            0.25 * float(cross @ (x * x + y * y)),
        )

    @cached_property
    def _corners(self) -> Indices:
        """Junctions at which the velocity jumps."""
        motion = self.cam.motion
        return motion.discontinuities(1, np.arange(motion.curve.count))

    def _bridge(self, junction: int) -> tuple[Array, ...]:
        """The part of the flank at a corner: an arc about the roller's centre, or straight."""
        motion = self.cam.motion
        before, after = (
            self._at(tuple(np.array([rate]) for rate in s))
            for s in motion.one_sided_values(junction)
        )
        theta = float(motion.curve.breaks[junction + 1])
        share, weights = (each.ravel() for each in gauss_points(np.array([0.0, 1.0]), ARC_NODES))
        (x0, y0, *_), (x1, y1, *_) = before.curve, after.curve
        if before.gap == 0.0:
            x, y = x0 + share * (x1 - x0), y0 + share * (y1 - y0)
            dx, dy = np.full_like(x, x1 - x0), np.full_like(y, y1 - y0)
        else:
            (cx, cy), *_ = before.position
            ux, uy, vx, vy = x0 - cx, y0 - cy, x1 - cx, y1 - cy
            turn = np.arctan2(ux * vy - uy * vx, ux * vx + uy * vy)
            cos, sin = np.cos(turn * share), np.sin(turn * share)
            rx, ry = cos * ux - sin * uy, sin * ux + cos * uy
            x, y, dx, dy = cx + rx, cy + ry, -turn * ry, turn * rx
        return np.full(ARC_NODES, theta), weights, x, y, dx, dy

    # extremes

    @property
    def _extremes(self) -> Mapping[str, tuple[str, float]]:
        """What is sought: of which measure the largest value, or with −1 the smallest."""
        found = {"largest_radius": ("radius", 1.0), "smallest_radius": ("radius", -1.0)}
        if self.cam.machine.follower.always_convex:
            found["convex"] = ("face", -1.0)
        else:
            found |= {"convex": ("bend", 1.0), "hollow": ("bend", -1.0)}
        both = ["sliding"] if flat_face(self.flank.trace) is not None else []
        both += ["spin", "spin_up"] if self.flank.roller > 0.0 else []
        for name in both:
            found |= {f"{name}_forward": (name, 1.0), f"{name}_back": (name, -1.0)}
        return found

    def _measures(self, at: _FlankPoint) -> dict[str, Array]:
        """What has extremes, by name, at n places."""
        x, y, *_ = at.curve
        omega = self.cam.machine.omega
        found = {"radius": np.hypot(x, y)}
        if self.cam.machine.follower.always_convex:
            found["face"] = face_radius(at)
        else:
            found["bend"] = self.flank.side * at.curvature
        if flat_face(at.trace) is not None:
            found["sliding"] = omega * self._sliding(at)
        if self.flank.roller > 0.0:
            spin, rate = self.flank.roller_spin(at.s, self.cam.size)
            found |= {"spin": omega * spin, "spin_up": omega**2 * rate}
        return found

    def _peaks(self) -> dict[str, PeakValue]:
        """Every extreme times its sign, at a point of the grid or at the top between."""
        grid, motion, extremes = self.grid, self.cam.motion, self._extremes
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            seen = self._measures(self._points)
            row = {name: k for k, name in enumerate(seen)}
            wanted = [(row[name], sign) for name, sign in extremes.values()]
            values = np.stack(list(seen.values()))
            if not np.isfinite(values).all():  # a cusp of the traced curve
                values = np.clip(np.nan_to_num(values), -LARGE, LARGE)
            interval, x = grid.highest(values, wanted)
            piece = grid.owner[interval]
            again = self._measures(self._at(tuple(motion.curve.jet(x, piece, 3))))
        # the highest and the lowest point of the grid of every measure
        points = {1.0: values.argmax(axis=1).tolist(), -1.0: values.argmin(axis=1).tolist()}
        peaks = {}
        for k, (title, (name, sign)) in enumerate(extremes.items()):
            # a point of the grid counts where the top found is lower by more than rounding
            point = points[sign][row[name]]
            value, other = sign * float(again[name][k]), sign * float(values[row[name], point])
            at, owner = float(x[k]), int(piece[k])
            if not value >= other - EQUAL * abs(other):
                value, at, owner = other, float(grid.x[point]), int(grid.piece[point])
            segment = int(motion.segment_of_piece[owner])
            peaks[title] = PeakValue(value=value + 0.0, angle_deg=degrees(at), segment=segment)
        return peaks

    def _radii(self, peaks: Mapping[str, PeakValue]) -> dict[str, PeakValue | None]:
        """The least convex and the least hollow radius of the flank."""
        convex = peaks["convex"]
        if self.cam.machine.follower.always_convex:
            return {"convex_radius_mm": _with(convex, -convex.value), "hollow_radius_mm": None}
        found: dict[str, PeakValue | None] = {}
        for name, peak, sign in (("convex", convex, 1.0), ("hollow", peaks["hollow"], -1.0)):
            bent = peak.value > self._straight
            radius = 1.0 / peak.value - sign * self.flank.distance if bent else 0.0
            found[f"{name}_radius_mm"] = _with(peak, radius) if bent else None
        return found

    @property
    def _straight(self) -> float:
        """Curvature that counts as none [1/mm]."""
        return STRAIGHT / prime_radius(self.cam.machine.follower, self.cam.size)

    def _hollows(self) -> int:
        """Arcs on which the flank is hollow, from the signs of its curvature round the turn."""
        if self.cam.machine.follower.always_convex:
            return 0
        hollow = self.flank.side * self._points.curvature < -self._straight
        starts = int(np.count_nonzero(hollow & ~np.roll(hollow, 1)))
        return starts or int(bool(hollow.any()))

    def _sliding(self, at: TracedPoint) -> Any:
        """Speed of the face past the cam's material, along the face, per radian of cam angle."""
        face = flat_face(at.trace)
        assert face is not None
        (px, py), (_, (ex, ey)) = at.position[0], face.face_axis(at.s, at.size)
        link = self._link
        if link.slide is not None:
            ux, uy = link.slide[0] * at.s[1], link.slide[1] * at.s[1]
        else:
            assert link.pivot is not None
            rate = link.turn * self._radian * at.s[1]
            ux, uy = -rate * (py - link.pivot[1]), rate * (px - link.pivot[0])
        return (ux + py) * ex + (uy - px) * ey  # less the cam's ω × p = (−y, x)

    @property
    def _radian(self) -> float:
        """Swing in radians for a millimetre of s."""
        return DEGREE / self.cam.machine.follower.travel.per_unit

    @cached_property
    def _link(self) -> Link:
        return self.cam.machine.follower.link(self.cam.size, DEGREE)


def _with(peak: PeakValue, value: float) -> PeakValue:
    return peak.model_copy(update={"value": value + 0.0})


def _larger(peaks: Mapping[str, PeakValue], name: str, unit: float = 1.0) -> PeakValue | None:
    """The larger of the peaks forward and back, in a unit; None where there is no such measure."""
    both = [peaks[key] for key in (f"{name}_forward", f"{name}_back") if key in peaks]
    if not both:
        return None
    best = max(both, key=lambda peak: peak.value)
    return _with(best, unit * best.value)


def _mass(
    flanks: tuple[Flank, ...], each: list[FlankGeometry], body: CamBody
) -> MassProperties | None:
    """Of plates within their flanks, less the bore; None of rings and grooves."""
    if any(flank.side < 0 for flank in flanks):
        return None
    hole = 0.25 * math.pi * (body.bore_mm or 0.0) ** 2
    areas = [one.area_mm2 - hole for one in each]
    moments = [one.polar_moment_mm4 - hole * hole / FULL_TURN for one in each]
    density = body.density_kg_per_m3 * body.thickness_mm * MILLI**3  # kg per mm²
    # the bore is about the axis: the first moments are those of the whole areas
    place = [sum(one.area_mm2 * one.centroid_mm[k] for one in each) / sum(areas) for k in range(2)]
    return MassProperties(
        mass_kg=density * sum(areas),
        centre_of_gravity_mm=(place[0], place[1]),
        moment_of_inertia_kg_m2=density * sum(moments) * MILLI**2,
    )
