"""The cam's figure: curves, circles, follower and rotation."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from synthesis.catalogue.followers.base import prime_radius
from synthesis.catalogue.profile import CamProfile, follower_outline
from synthesis.design.design import Design
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.figures.parts import (
    HUB,
    PIVOT,
    STEM,
    Box,
    Flanks,
    Point,
    bar,
    half_width,
    outline,
    polygon,
    rim_of,
)
from synthesis.exporters.options import ProfileOptions
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.sampling import ring

BELOW, TICK, ARC_SPAN = 13.5, 2.0, math.radians(105.0)
UNITS_ACROSS = 160.0


@dataclass(frozen=True, eq=False)
class Scene:
    """What is drawn, in the cam's frame (y up) at cam angle 0.

    Attributes:
        flanks: every flank with its closed curve. starts: they at cam angle 0.
        rim: radius of the material around flanks that are touched from inside, 0 without [mm].
        borders, middles: the cam at the borders of segments and half-way between them.
        rotation: +1 where the cam turns counter-clockwise, −1 clockwise.
        centre: where the follower's stem begins: the roller's centre [mm].
        drive: unit vector along the stem: of a slide's motion, or from the roller to the pivot.
        face: how far a flat face reaches to the left and to the right [mm].
        along: unit vector along the face, to the right.
        pivot: of the follower's arm, None where it slides [mm].
        roller, base, prime: radii [mm].
        u: the sheet's unit [mm]. decimals: of coordinates.
    """

    flanks: Flanks
    starts: tuple[CamProfile, ...]
    rim: float
    borders: CamProfile
    middles: CamProfile
    rotation: float
    centre: Point
    drive: Point
    face: tuple[float, float]
    along: Point
    pivot: Point | None
    roller: float
    base: float
    prime: float
    u: float
    decimals: int

    @classmethod
    def of(cls, design: Design, cam: Cam, options: ProfileOptions) -> Scene:
        """The scene of a design."""
        zero, sign = np.zeros(1), -1.0 if cam.rotation == "cw" else 1.0
        moving = [s for s in cam.motion.segments if s.angle > 0.0]
        shape = follower_outline(cam.follower, cam.motion, cam.size)
        prime = prime_radius(cam.follower, cam.size)
        x, y = centre = sign * shape.centre[0], shape.centre[1]
        pivot, drive = None, (0.0, 1.0)  # where a face points at its pivot
        if shape.pivot is None:
            (gx, gy), _ = cam.follower.drive_direction(cam.at(zero).s, cam.size)
            drive = sign * float(gx[0]), float(gy[0])
        else:
            pivot = sign * shape.pivot[0], shape.pivot[1]
            length = math.hypot(pivot[0] - x, pivot[1] - y)
            if length > 0.0:
                drive = (pivot[0] - x) / length, (pivot[1] - y) / length
        flanks = tuple(
            (one.flank, ring(one, options.count, options.chord_mm)) for one in cam.flanks()
        )
        rim = rim_of(flanks)
        sizes = [np.ptp(way) for _, one in flanks for way in (one.pitch_x, one.pitch_y)]
        across = float(max(2.0 * prime, 2.0 * rim, *sizes))
        return cls(
            flanks=flanks,
            starts=tuple(one.at(zero) for one in cam.flanks()),
            rim=rim,
            borders=cam.at(np.array([s.start for s in moving if s.start > 0.0])),
            middles=cam.at(np.array([s.start + 0.5 * s.angle for s in moving])),
            rotation=sign,
            centre=centre,
            drive=drive,
            face=(shape.left, shape.right) if sign > 0.0 else (shape.right, shape.left),
            along=(shape.along[0], sign * shape.along[1]),
            pivot=pivot,
            roller=shape.roller,
            base=design.dimensions["base_radius_mm"],
            prime=prime,
            u=across / UNITS_ACROSS,
            decimals=max(4, 7 - math.floor(math.log10(across))),
        )

    @cached_property
    def extent(self) -> Box:
        """Left, bottom, right and top of all that is drawn, texts excepted [mm]."""
        (x, y), (tx, ty), (left, right) = self.centre, self.along, self.face
        stem, reach = self.roller + STEM * self.u, max(self.prime, self.rim)
        xs, ys = [-reach, reach], [-reach, reach]
        for _, curve in self.flanks:
            xs += [float(curve.pitch_x.min()), float(curve.pitch_x.max())]
            ys += [float(curve.pitch_y.min()), float(curve.pitch_y.max())]
        xs += [x - self.roller, x + self.roller, x - left * tx, x + right * tx]
        ys += [y - self.roller, y + self.roller, y - left * ty, y + right * ty]
        xs, ys = [*xs, x + stem * self.drive[0]], [*ys, y + stem * self.drive[1]]
        if self.pivot is not None:
            eye = PIVOT * (STEM * self.u)
            xs += [self.pivot[0] - eye, self.pivot[0] + eye]
            ys += [self.pivot[1] - eye, self.pivot[1] + eye]
        return min(xs), min(ys), max(xs), max(ys)

    @property
    def offset(self) -> float:
        """Signed distance of a slide's line from the cam's axis, to the right [mm]."""
        if self.pivot is not None:
            return 0.0
        (x, y), (gx, gy) = self.centre, self.drive
        return x * gy - y * gx

    @property
    def arc(self) -> tuple[float, float, float]:
        """Radius of the rotation arrow, its first and last polar angle [rad]."""
        middle = math.radians(225.0 if self.offset >= 0.0 else 315.0)
        half = 0.5 * self.rotation * ARC_SPAN
        return max(0.45 * self.base, 7.0 * self.u), middle - half, middle + half


def shapes(scene: Scene) -> list[str]:
    """All lines and areas, y upwards."""
    (_, curve), decimals = scene.flanks[0], scene.decimals
    body = [*_centre_lines(scene), svg.circle("line circle", 0.0, 0.0, scene.base)]
    if scene.roller > 0.0:
        body.append(svg.circle("line prime", 0.0, 0.0, scene.prime))
        steps = svg.steps(curve.pitch_x, curve.pitch_y, decimals, closed=True)
        body.append(svg.path("line pitch", steps))
    body.append(outline(scene.flanks, scene.rim, scene.rotation, scene.decimals))
    body += _counters(scene)
    body.append(svg.circle("outline metal", 0.0, 0.0, HUB * scene.u))
    return [*body, *_border_ticks(scene), *_rotation(scene), *_follower(scene)]


def _counters(scene: Scene) -> list[str]:
    """Profile, pitch curve and roller of a second cam on the shaft."""
    body: list[str] = []
    for (flank, curve), start in zip(scene.flanks, scene.starts, strict=True):
        if flank.path == scene.flanks[0][0].path:
            continue
        for kind, x, y in (("pitch", curve.pitch_x, curve.pitch_y), ("curve", curve.x, curve.y)):
            body.append(svg.path(f"line {kind}", svg.steps(x, y, scene.decimals, closed=True)))
        centre = float(start.pitch_x[0]), float(start.pitch_y[0])
        body.append(svg.circle("line outline", *centre, flank.distance))
        if scene.pivot is not None:
            body += bar(centre, scene.pivot, flank.distance, scene.u)
    return body


def _centre_lines(scene: Scene) -> list[str]:
    """Axes through the cam's centre, the follower's line, and the dimension between them."""
    u, (left, bottom, right, top) = scene.u, scene.extent
    (x, y), (gx, gy) = scene.centre, scene.drive
    low = bottom - BELOW * u
    body = [
        svg.line("line centre", left - 2.0 * u, 0.0, right + 2.0 * u, 0.0),
        svg.line("line centre", 0.0, low, 0.0, max(scene.prime, top - STEM * u) + 2.0 * u),
    ]
    if scene.pivot is not None:
        return [*body, svg.line("line centre", *scene.pivot, x, y)]
    if abs(scene.offset) < 0.2 * u:
        return body
    down, up = math.hypot(x, y - low), scene.roller + (STEM + 2.0) * u
    body.append(svg.line("line centre", x - down * gx, y - down * gy, x + up * gx, y + up * gy))
    if gx == 0.0:
        # the dimension line; its arrows stand outside where there is no room
        inside, level = abs(x) > 7.0 * u, low + 2.0 * u
        ends, over = (min(x, 0.0), max(x, 0.0)), 0.0 if inside else 4.0 * u
        turns = (math.pi, 0.0) if inside else (0.0, math.pi)
        body.append(svg.line("axis", ends[0] - over, level, ends[1] + over, level))
        body += [
            svg.arrow_head("solid", end, level, turn, 2.0 * u)
            for end, turn in zip(ends, turns, strict=True)
        ]
    return body


def _border_ticks(scene: Scene) -> list[str]:
    """From the profile through the pitch curve, where two segments meet."""
    at, over = scene.borders, TICK * scene.u
    x, y = at.pitch_x + over * at.normal_x, at.pitch_y + over * at.normal_y
    ends = zip(at.x.tolist(), at.y.tolist(), x.tolist(), y.tolist(), strict=True)
    return [svg.line("border", *points) for points in ends]


def _rotation(scene: Scene) -> list[str]:
    """An arrow round the centre in the sense of the cam's turning."""
    radius, first, last = scene.arc
    size, sweep = 3.2 * scene.u, int(scene.rotation > 0.0)
    neck = last - scene.rotation * 0.8 * size / radius
    x1, y1 = radius * math.cos(first), radius * math.sin(first)
    x2, y2 = radius * math.cos(neck), radius * math.sin(neck)
    x3, y3 = radius * math.cos(last), radius * math.sin(last)
    # The head is a chord of the arc: turn it half of what it spans.
    along = last + scene.rotation * (0.5 * math.pi - 0.5 * size / radius)
    r = svg.num(radius)
    steps = f"M{svg.num(x1)} {svg.num(y1)}A{r} {r} 0 0 {sweep} {svg.num(x2)} {svg.num(y2)}"
    return [svg.path("line outline", steps), svg.arrow_head("solid", x3, y3, along, size)]


def _follower(scene: Scene) -> list[str]:
    """Roller and stem or arm, a flat face or a knife edge, at cam angle 0."""
    u, centre, pivot, roller = scene.u, scene.centre, scene.pivot, scene.roller
    half, end = half_width(roller, u), roller + STEM * u
    foot = math.sqrt(max(roller**2 - half**2, 0.0))
    wheel = [svg.circle("line outline", *centre, roller),
             svg.circle("line axis", *centre, min(0.25 * roller, HUB * u))]  # fmt: skip
    if any(scene.face):
        return _face(scene)
    if pivot is not None:
        body = [*bar(centre, pivot, roller, u), *(wheel if roller > 0.0 else ())]
        eye = svg.circle("line outline", *pivot, PIVOT * STEM * u)
        return [*body, eye, svg.circle("outline metal", *pivot, HUB * u)]
    if roller == 0.0:
        corners = [(end, -half), (3.0 * u, -half), (0.0, 0.0), (3.0 * u, half), (end, half)]
        return [polygon("outline metal", centre, scene.drive, corners, closed=False)]
    edges = [
        polygon("line outline", centre, scene.drive, [(end, side), (foot, side)], closed=False)
        for side in (-half, half)
    ]
    return [*edges, *wheel]


def _face(scene: Scene) -> list[str]:
    """A plate as wide as contact needs, and its stem, which it covers where they meet.

    On a pivot: from the foot of the pivot to where contact ends, the link, and the pivot's eye.
    """
    u, (left, right), (tx, ty), (gx, gy) = scene.u, scene.face, scene.along, scene.drive
    centre, pivot, half = scene.centre, scene.pivot, 1.5 * u
    least = half if pivot is None else 0.0
    left, right = max(left, least), max(right, least)
    corners = [(0.0, -left), (0.0, right), (2.0 * u, right), (2.0 * u, -left)]
    plate = polygon("outline metal", centre, (-ty, tx), corners)
    if pivot is not None:
        return [
            svg.line("line outline", *centre, *pivot),
            plate,
            svg.circle("outline metal", *pivot, PIVOT * STEM * u),
            svg.circle("outline metal", *pivot, HUB * u),
        ]
    foot = half * abs(gx * tx + gy * ty) / (gy * tx - gx * ty)  # the stem's corner on the face
    corners = [(foot, -half), (foot, half), (STEM * u, half), (STEM * u, -half)]
    return [polygon("outline metal", centre, scene.drive, corners), plate]
