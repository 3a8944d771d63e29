"""The cam's figure: curves, circles, follower and rotation."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from synthesis.catalogue.followers.base import prime_radius
from synthesis.catalogue.followers.outline import follower_outline
from synthesis.catalogue.profile import CamProfile
from synthesis.design.design import Design
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.figures.parts import (
    HUB,
    PIVOT,
    STEM,
    Flanks,
    bar,
    half_width,
    outline,
    point_from,
    rim_of,
)  # fmt: skip
from synthesis.exporters.options import ProfileOptions
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.sampling import ring

BELOW, TICK, ARC_SPAN = 13.5, 2.0, math.radians(105.0)
UNITS_ACROSS = 160.0

Box = tuple[float, float, float, float]


@dataclass(frozen=True, eq=False)
class Scene:
    """What is drawn, in the cam's frame (y up) at cam angle 0.

    Attributes:
        ring: the closed curve.
        flanks: every flank with its curve, the first is the ring. starts: they at cam angle 0.
        rim: radius of the material around flanks that are touched from inside, 0 without [mm].
        borders, middles: the cam at the borders of segments and half-way between them.
        drive: unit vector along the follower's stem, in which a slide moves; along an arm.
        rotation: +1 where the cam turns counter-clockwise, −1 clockwise.
        centre: where the follower's stem begins: the roller's centre [mm].
        roller, base, prime: radii [mm].
        face: how far a flat face reaches to the left and to the right [mm].
        along: unit vector along the face, to the right.
        pivot: of the follower's arm, None where it slides [mm].
        extent: left, bottom, right and top of all that is drawn, texts excepted [mm].
        u: the sheet's unit [mm]. decimals: of coordinates.
    """

    ring: CamProfile
    flanks: Flanks
    rim: float
    starts: tuple[CamProfile, ...]
    borders: CamProfile
    middles: CamProfile
    drive: tuple[float, float]
    rotation: float
    centre: tuple[float, float]
    roller: float
    face: tuple[float, float]
    along: tuple[float, float]
    base: float
    prime: float
    pivot: tuple[float, float] | None
    extent: Box
    u: float
    decimals: int

    @classmethod
    def of(cls, design: Design, cam: Cam, options: ProfileOptions) -> Scene:
        """The scene of a design."""
        curve, start = ring(cam, options), cam.at(np.zeros(1))
        sign = -1.0 if cam.rotation == "cw" else 1.0
        moving = [s for s in cam.motion.segments if s.angle > 0.0]
        shape = follower_outline(cam.follower, cam.motion, cam.size)
        roller, prime = shape.roller, prime_radius(cam.follower, cam.size)
        centre = sign * shape.centre[0], shape.centre[1]
        face = (shape.left, shape.right) if sign > 0.0 else (shape.right, shape.left)
        along = shape.along[0], sign * shape.along[1]
        flanks = tuple((one.flank, ring(one, options)) for one in cam.flanks())
        rim = rim_of(flanks)
        pivot = None if shape.pivot is None else (sign * shape.pivot[0], shape.pivot[1])
        drive = _stem(cam, start, sign, centre, pivot)
        across = max(2.0 * prime, 2.0 * rim, *(_across(one) for _, one in flanks))
        u = across / UNITS_ACROSS
        return cls(
            ring=curve,
            flanks=flanks,
            rim=rim,
            starts=tuple(one.at(np.zeros(1)) for one in cam.flanks()),
            borders=cam.at(np.array([s.start for s in moving if s.start > 0.0])),
            middles=cam.at(np.array([s.start + 0.5 * s.angle for s in moving])),
            drive=drive,
            rotation=sign,
            centre=centre,
            roller=roller,
            face=face,
            along=along,
            base=design.dimensions["base_radius_mm"],
            prime=prime,
            pivot=pivot,
            extent=_extent(
                flanks, rim, centre, drive, prime, roller, (face, along), STEM * u, pivot
            ),
            u=u,
            decimals=max(4, 7 - math.floor(math.log10(across))),
        )

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


def _across(curve: CamProfile) -> float:
    """Extent of a pitch curve [mm]."""
    return max(float(np.ptp(curve.pitch_x)), float(np.ptp(curve.pitch_y)))


def _stem(
    cam: Cam,
    start: CamProfile,
    sign: float,
    centre: tuple[float, float],
    pivot: tuple[float, float] | None,
) -> tuple[float, float]:
    """Direction of the follower's stem: that of its motion, or from the roller to the pivot."""
    if pivot is not None:
        length = math.hypot(pivot[0] - centre[0], pivot[1] - centre[1])
        if length == 0.0:  # a face that points at its pivot
            return 0.0, 1.0
        return (pivot[0] - centre[0]) / length, (pivot[1] - centre[1]) / length
    (gx, gy), _ = cam.follower.drive_direction(start.s, cam.size)
    return sign * float(gx[0]), float(gy[0])


def _extent(
    flanks: Flanks,
    rim: float,
    centre: tuple[float, float],
    drive: tuple[float, float],
    prime: float,
    roller: float,
    face: tuple[tuple[float, float], tuple[float, float]],
    stem: float,
    pivot: tuple[float, float] | None,
) -> Box:
    (x, y), ((left, right), (tx, ty)) = centre, face
    end_x, end_y = x + (roller + stem) * drive[0], y + (roller + stem) * drive[1]
    reach = max(prime, rim)
    xs, ys = [-reach, reach], [-reach, reach]
    for _, curve in flanks:
        xs += [float(curve.pitch_x.min()), float(curve.pitch_x.max())]
        ys += [float(curve.pitch_y.min()), float(curve.pitch_y.max())]
    xs += [x - roller, x + roller, end_x, x - left * tx, x + right * tx]
    ys += [y - roller, y + roller, end_y, y - left * ty, y + right * ty]
    if pivot is not None:
        xs += [pivot[0] - PIVOT * stem, pivot[0] + PIVOT * stem]
        ys += [pivot[1] - PIVOT * stem, pivot[1] + PIVOT * stem]
    return min(xs), min(ys), max(xs), max(ys)


def shapes(scene: Scene) -> list[str]:
    """All lines and areas, y upwards."""
    ring, decimals = scene.ring, scene.decimals
    body = [*_centre_lines(scene), svg.circle("line circle", 0.0, 0.0, scene.base)]
    if scene.roller > 0.0:
        body.append(svg.circle("line prime", 0.0, 0.0, scene.prime))
        steps = svg.steps(ring.pitch_x, ring.pitch_y, decimals, closed=True)
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
        body += _dimension(x, low + 2.0 * u, u)
    return body


def _dimension(x: float, y: float, u: float) -> list[str]:
    """A dimension line from 0 to x; its arrows stand outside where there is no room."""
    inside = abs(x) > 7.0 * u
    low, high = min(x, 0.0), max(x, 0.0)
    over = 0.0 if inside else 4.0 * u
    along = (math.pi, 0.0) if inside else (0.0, math.pi)
    return [
        svg.line("axis", low - over, y, high + over, y),
        svg.arrow_head("solid", low, y, along[0], 2.0 * u),
        svg.arrow_head("solid", high, y, along[1], 2.0 * u),
    ]


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


def _flat_face(scene: Scene) -> list[str]:
    """A plate as wide as contact needs, and its stem, which it covers where they meet."""
    u, (left, right) = scene.u, scene.face
    (tx, ty), (gx, gy) = scene.along, scene.drive
    half, left, right = 1.5 * u, max(left, 1.5 * u), max(right, 1.5 * u)
    foot = half * abs(gx * tx + gy * ty) / (gy * tx - gx * ty)  # the stem's corner on the face
    stem = scene.drive, [(foot, -half), (foot, half), (STEM * u, half), (STEM * u, -half)]
    plate = (-ty, tx), [(0.0, -left), (0.0, right), (2.0 * u, right), (2.0 * u, -left)]
    return [
        svg.path(
            "outline metal", "M" + "L".join(point_from(scene.centre, up, *c) for c in corners) + "Z"
        )
        for up, corners in (stem, plate)
    ]


def _swinging_face(scene: Scene) -> list[str]:
    """A plate from the foot of the pivot to where contact ends, the link to the pivot, its eye."""
    u, (left, right), (tx, ty), pivot = scene.u, scene.face, scene.along, scene.pivot
    assert pivot is not None
    eye, left, right = PIVOT * STEM * u, max(left, 0.0), max(right, 0.0)
    plate = [(0.0, -left), (0.0, right), (2.0 * u, right), (2.0 * u, -left)]
    steps = "M" + "L".join(point_from(scene.centre, (-ty, tx), *corner) for corner in plate) + "Z"
    return [
        svg.line("line outline", *scene.centre, *pivot),
        svg.path("outline metal", steps),
        svg.circle("outline metal", *pivot, eye),
        svg.circle("outline metal", *pivot, HUB * u),
    ]


def _arm(scene: Scene) -> list[str]:
    """Roller, arm and the eye at its pivot."""
    u, (x, y), pivot = scene.u, scene.centre, scene.pivot
    assert pivot is not None
    body = bar(scene.centre, pivot, scene.roller, u)
    if scene.roller > 0.0:
        body.append(svg.circle("line outline", x, y, scene.roller))
        body.append(svg.circle("line axis", x, y, min(0.25 * scene.roller, HUB * u)))
    return [
        *body,
        svg.circle("line outline", *pivot, PIVOT * STEM * u),
        svg.circle("outline metal", *pivot, HUB * u),
    ]


def _follower(scene: Scene) -> list[str]:
    """Roller and stem, a flat face or a knife edge, at cam angle 0."""
    u, (x, y) = scene.u, scene.centre
    half = half_width(scene.roller, u)
    end, foot = scene.roller + STEM * u, math.sqrt(max(scene.roller**2 - half**2, 0.0))

    def at(along: float, across: float) -> str:
        return point_from(scene.centre, scene.drive, along, across)

    if any(scene.face):
        return _flat_face(scene) if scene.pivot is None else _swinging_face(scene)
    if scene.pivot is not None:
        return _arm(scene)
    if scene.roller == 0.0:
        corners = [(end, -half), (3.0 * u, -half), (0.0, 0.0), (3.0 * u, half), (end, half)]
        return [svg.path("outline metal", "M" + "L".join(at(*corner) for corner in corners))]
    return [
        svg.path("line outline", f"M{at(end, -half)}L{at(foot, -half)}"),
        svg.path("line outline", f"M{at(end, half)}L{at(foot, half)}"),
        svg.circle("line outline", x, y, scene.roller),
        svg.circle("line axis", x, y, min(0.25 * scene.roller, HUB * u)),
    ]
