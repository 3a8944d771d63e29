"""Drawing of the cam as SVG, in mm: the cam, its circles, and the follower.

The shapes stand in a group with y upwards, so their numbers are those of the cam's frame; a place
on a shaft, ``turn_deg`` and ``z_mm``, is not drawn.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from synthesis.catalogue.followers.base import prime_radius
from synthesis.catalogue.profile import CamProfile
from synthesis.design.design import Design
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.canvas import TURNS, Sheet, heading
from synthesis.exporters.exporter import design_format
from synthesis.exporters.figures import parts
from synthesis.exporters.figures.mechanism import Mechanism, face_at_rest
from synthesis.exporters.figures.parts import HUB, PIVOT, STEM, Box, Flanks
from synthesis.exporters.options import CamDrawingOptions, ProfileOptions
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.sampling import in_degrees, ring

BELOW, TICK, ARC_SPAN = 13.5, 2.0, math.radians(105.0)  # in units; of the rotation arrow [rad]
UNITS_ACROSS = 160.0  # units of the sheet from side to side of a cam
ENLARGED = 1.6  # units of a picture that is set into a page at half the width of its sheet
HEADER, MARGIN, ROW = 22.0, 14.0, 5.2  # in units of the sheet


@dataclass(frozen=True, eq=False)
class Scene:
    """What is drawn, in the cam's frame (y up) at cam angle 0.

    Attributes:
        flanks: every flank with its closed curve. borders: the cam where two segments meet.
        rotation: +1 where the cam turns counter-clockwise, −1 clockwise.
        centre: where the follower's stem begins: the roller's centre [mm].
        drive: unit vector along the stem: of a slide's motion, or from the roller to the pivot.
        face: how far a flat face reaches to the left and to the right [mm].
        along: unit vector along the face, to the right.
        pivot: of the follower's arm, None where it slides [mm].
        roller, prime: radii [mm].
        u: the sheet's unit [mm]. decimals: of coordinates.
    """

    design: Design
    cam: Cam
    flanks: Flanks
    borders: CamProfile
    rotation: float
    centre: complex
    drive: complex
    face: tuple[float, float]
    along: complex
    pivot: complex | None
    roller: float
    prime: float
    u: float
    decimals: int

    @classmethod
    def of(cls, design: Design, options: ProfileOptions) -> Scene:
        """The scene of a design."""
        cam = Cam.of(design)
        sign = -1.0 if cam.rotation == "cw" else 1.0
        # of a ccw cam; its mirror image where it turns clockwise
        machine = Mechanism.of(replace(cam, rotation="ccw"), 1)

        def mirrored(point: complex) -> complex:
            return complex(sign * point.real, point.imag)

        first, prime = machine.contacts[0], prime_radius(cam.follower, cam.size)
        centre = mirrored(machine.carried(first.place, machine.moved[0]))
        drive = 1j if machine.slide is None else mirrored(machine.slide)
        pivot = None if machine.pivot is None else mirrored(machine.pivot)
        if pivot is not None and pivot != centre:  # a face points at its pivot
            drive = (pivot - centre) / abs(pivot - centre)
        face, along = face_at_rest(cam, machine)
        flanks = tuple(
            (one.flank, ring(one, options.count, options.chord_mm)) for one in cam.flanks()
        )
        sizes = [np.ptp(way) for _, one in flanks for way in (one.pitch_x, one.pitch_y)]
        across = float(max(2.0 * prime, 2.0 * parts.rim_of(flanks), *sizes))
        return cls(
            design=design,
            cam=cam,
            flanks=flanks,
            borders=cam.at(np.array([s.start for s in cam.motion.segments if s.start * s.angle])),
            rotation=sign,
            centre=centre,
            drive=drive,
            face=face if sign > 0.0 else face[::-1],
            along=complex(along.real, sign * along.imag),
            pivot=pivot,
            roller=first.roller,
            prime=prime,
            u=across / UNITS_ACROSS,
            decimals=max(4, 7 - math.floor(math.log10(across))),
        )

    @cached_property
    def extent(self) -> Box:
        """Left, bottom, right and top of all that is drawn, texts excepted [mm]."""
        (left, right), square = self.face, 1.0 + 1.0j
        reach, eye = (
            max(self.prime, parts.rim_of(self.flanks)) * square,
            PIVOT * STEM * self.u * square,
        )
        points = [-reach, reach]
        for _, at in self.flanks:
            points += [complex(end(at.pitch_x), end(at.pitch_y)) for end in (np.min, np.max)]
        points += [self.centre + self.roller * to for to in (-square, square)]
        points += [self.centre + to * self.along for to in (-left, right)]
        points.append(self.centre + (self.roller + STEM * self.u) * self.drive)
        if self.pivot is not None:
            points += [self.pivot - eye, self.pivot + eye]
        return parts.box_around(points)

    @property
    def offset(self) -> float:
        """Signed distance of a slide's line from the cam's axis, to the right [mm]."""
        return (self.centre.conjugate() * self.drive).imag if self.pivot is None else 0.0

    @property
    def arc(self) -> tuple[float, float, float]:
        """Radius of the rotation arrow, its first and last polar angle [rad]."""
        middle = math.radians(225.0 if self.offset >= 0.0 else 315.0)
        half = 0.5 * self.rotation * ARC_SPAN
        radius = max(0.45 * self.design.dimensions["base_radius_mm"], 7.0 * self.u)
        return radius, middle - half, middle + half


def shapes(scene: Scene) -> list[str]:
    """All lines and areas, y upwards."""
    (first, curve), base = scene.flanks[0], scene.design.dimensions["base_radius_mm"]
    body = [*_centre_lines(scene), svg.circle("line circle", 0.0, 0.0, base)]
    if scene.roller > 0.0:
        body.append(svg.circle("line prime", 0.0, 0.0, scene.prime))
        body.append(parts.pitch_curve(curve, scene.decimals))
    body.append(parts.outline(scene.flanks, scene.rotation, scene.decimals))
    # profile, pitch curve and roller of a second cam on the shaft
    for (flank, curve), one in zip(scene.flanks, scene.cam.flanks(), strict=True):
        if flank.path != first.path:
            start = one.at(np.zeros(1))
            centre = complex(start.pitch_x[0], start.pitch_y[0])
            body += [
                parts.pitch_curve(curve, scene.decimals),
                parts.profile_curve(curve, scene.decimals),
                parts.circle("line outline", centre, flank.distance),
            ]
            if scene.pivot is not None:
                body += parts.bar(centre, scene.pivot, flank.distance, scene.u)
    body.append(svg.circle("outline metal", 0.0, 0.0, HUB * scene.u))
    # from the profile through the pitch curve, where two segments meet
    at, over = scene.borders, TICK * scene.u
    ends = at.pitch_x + over * at.normal_x, at.pitch_y + over * at.normal_y
    ticks = np.stack([at.x, at.y, *ends], axis=1).tolist()
    body += [svg.line("border", *tick) for tick in ticks]
    return [*body, *_rotation(scene), *_follower(scene)]


def _centre_lines(scene: Scene) -> list[str]:
    """Axes through the cam's centre, the follower's line, and the dimension between them."""
    u, (left, bottom, right, top), x = scene.u, scene.extent, scene.centre.real
    low = bottom - BELOW * u
    body = [
        svg.line("line centre", left - 2.0 * u, 0.0, right + 2.0 * u, 0.0),
        svg.line("line centre", 0.0, low, 0.0, max(scene.prime, top - STEM * u) + 2.0 * u),
    ]
    if scene.pivot is not None:
        return [*body, parts.line("line centre", scene.pivot, scene.centre)]
    if abs(scene.offset) < 0.2 * u:
        return body
    down, up = abs(scene.centre - low * 1j), scene.roller + (STEM + 2.0) * u
    ends = (scene.centre + to * scene.drive for to in (-down, up))
    body.append(parts.line("line centre", *ends))
    if scene.drive.real == 0.0:
        # the dimension line; its arrows stand outside where there is no room
        inside, level = abs(x) > 7.0 * u, low + 2.0 * u
        first, last, over = min(x, 0.0), max(x, 0.0), 0.0 if inside else 4.0 * u
        turns = (math.pi, 0.0) if inside else (0.0, math.pi)
        body += [
            svg.line("axis", first - over, level, last + over, level),
            svg.arrow_head("solid", first, level, turns[0], 2.0 * u),
            svg.arrow_head("solid", last, level, turns[1], 2.0 * u),
        ]
    return body


def _rotation(scene: Scene) -> list[str]:
    """An arrow round the centre in the sense of the cam's turning."""
    radius, first, last = scene.arc
    size, sweep = 3.2 * scene.u, int(scene.rotation > 0.0)
    neck = last - scene.rotation * 0.8 * size / radius
    start, end, tip = (cmath.rect(radius, at) for at in (first, neck, last))
    # The head is a chord of the arc: turn it half of what it spans.
    along = last + scene.rotation * (0.5 * math.pi - 0.5 * size / radius)
    r = svg.num(radius)
    steps = f"M{parts.place(start)}A{r} {r} 0 0 {sweep} {parts.place(end)}"
    head = svg.arrow_head("solid", tip.real, tip.imag, along, size)
    return [svg.path("line outline", steps), head]


def _follower(scene: Scene) -> list[str]:
    """Roller and stem or arm, a flat face or a knife edge, at cam angle 0."""
    u, centre, pivot, roller = scene.u, scene.centre, scene.pivot, scene.roller
    half, end = parts.half_width(roller, u), roller + STEM * u
    foot = math.sqrt(max(roller**2 - half**2, 0.0))
    radii = {"line outline": roller, "line axis": min(0.25 * roller, HUB * u)}
    wheel = [parts.circle(kind, centre, radius) for kind, radius in radii.items()]
    if any(scene.face):
        return _face(scene)
    if pivot is not None:
        body = [*parts.bar(centre, pivot, roller, u), *(wheel if roller > 0.0 else ())]
        eye = parts.circle("line outline", pivot, PIVOT * STEM * u)
        return [*body, eye, parts.circle("outline metal", pivot, HUB * u)]
    if roller == 0.0:
        corners = [(end, -half), (3.0 * u, -half), (0.0, 0.0), (3.0 * u, half), (end, half)]
        return [parts.polygon("outline metal", centre, scene.drive, corners, closed=False)]
    return [*parts.edges(centre, scene.drive, (foot, end), half), *wheel]


def _face(scene: Scene) -> list[str]:
    """A plate as wide as contact needs, and its stem, which it covers where they meet.

    On a pivot: from the foot of the pivot to where contact ends, the link, and the pivot's eye.
    """
    u, (left, right), along = scene.u, scene.face, scene.along
    centre, pivot, half = scene.centre, scene.pivot, 1.5 * u
    least = half if pivot is None else 0.0
    left, right = max(left, least), max(right, least)
    corners = [(0.0, -left), (0.0, right), (2.0 * u, right), (2.0 * u, -left)]
    plate = parts.polygon("outline metal", centre, 1j * along, corners)
    if pivot is not None:
        return [parts.line("line outline", centre, pivot), plate, *parts.eye(pivot, u)]
    stem = along.conjugate() * scene.drive  # as seen from the face
    foot = half * abs(stem.real) / stem.imag  # the stem's corner on the face
    corners = [(foot, -half), (foot, half), (STEM * u, half), (STEM * u, -half)]
    return [parts.polygon("outline metal", centre, scene.drive, corners), plate]


def _profile(design: Design, options: CamDrawingOptions) -> bytes:
    Cam.of(design, options)  # a curve that the cam has not is refused; all are drawn
    scene = Scene.of(design, options)
    u, (left, bottom, right, top) = scene.u, scene.extent
    width = right - left + 2.0 * MARGIN * u
    x, y = MARGIN * u - left, HEADER * u + top
    legend = y - bottom + (BELOW + 3.0) * u
    rows, remarks = _legend(scene), _remarks(scene)
    height = legend + (max(5, len(rows)) + 1.0) * ROW * u
    widest = max(svg.width_of(text, svg.LABEL * u) for _, text in rows)
    second = max(0.5 * width + 8.0 * u, (MARGIN + 13.0) * u + widest + 3.0 * u)
    scale, lines = svg.shown_at(width), list[str]()
    for k, (kind, text) in enumerate(rows):
        first, row = MARGIN * u, legend + (k + 0.5) * ROW * u
        lines.append(svg.line(kind, first, row, first + 11.0 * u, row))
        lines.append(svg.text("label", first + 13.0 * u, row + 1.0 * u, text))
    lines += [
        svg.text("label", second, legend + ((k + 0.5) * ROW + 1.0) * u, text)
        for k, text in enumerate(remarks)
    ]
    body = [
        f'<g transform="translate({svg.num(x)} {svg.num(y)}) scale(1 -1)">',
        *shapes(scene),
        "</g>",
        *labels(scene, x, y),
        *heading(design, MARGIN * u, width - MARGIN * u, u),
        *lines,
        *svg.scale_bar(second, legend + 4.0 * ROW * u, u, svg.ratio(scale)),
    ]
    title = f"Cam {design.name or design.id}"
    text = (
        f"The cam's profile and pitch curve, drawn {svg.ratio(scale)}, with the follower at cam "
        "angle 0. One unit of the coordinates is 1 mm of the cam."
    )
    return svg.document(width, height, u, title, text, body, scale, options.theme)


def _legend(scene: Scene) -> list[tuple[str, str]]:
    """Kinds of lines and what they stand for."""
    size = {name: svg.figure(value, 6) for name, value in scene.design.dimensions.items()}
    first = scene.flanks[0][0]
    rows = []
    for flank, curve in scene.flanks:
        radius = np.hypot(curve.x, curve.y)
        least, largest = svg.figure(float(radius.min()), 5), svg.figure(float(radius.max()), 5)
        text = f"{flank.name} profile, radius {least} to {largest} mm".strip()
        rows.append(("line outline" if flank.path == first.path else "line curve", text))
    rows.append(("line circle", f"base circle, radius {size['base_radius_mm']} mm"))
    if scene.roller > 0.0:
        rows.insert(len(scene.flanks), ("line pitch", "pitch curve, path of the roller's centre"))
        rows.append(("line prime", f"prime circle, radius {size['prime_radius_mm']} mm"))
    if "offset_mm" in size:
        rows.append(("line centre", f"line of the follower, offset {size['offset_mm']} mm"))
    if scene.pivot is not None:
        arm = f"arm {size['arm_mm']} mm, " if "arm_mm" in size else ""
        rows.append(("line centre", f"{arm}pivot at {size['centre_distance_mm']} mm"))
    return rows


def _remarks(scene: Scene) -> list[str]:
    design = scene.design
    tip = "knife edge"
    if any(scene.face):
        tip = f"flat face, contact over {svg.figure(sum(scene.face), 6)} mm"
    elif scene.roller > 0.0:
        tip = f"roller radius {svg.figure(scene.roller, 6)} mm"
    return [
        tip,
        f"{'stroke' if scene.pivot is None else 'swing'} {svg.stroke(design)}",
        "follower shown at cam angle 0°",
        f"cam angles run {TURNS['cw' if design.rotation == 'ccw' else 'ccw']}",
    ]


def labels(scene: Scene, x: float, y: float) -> list[str]:
    """Texts on the sheet, the cam's centre at (x, y); those that would overlap are left out."""
    body, taken = list[str](), _occupied(scene)
    for kind, at, text in _texts(scene):
        corner = complex(0.5 * svg.width_of(text, svg.LABEL * scene.u), 1.6 * scene.u)
        left, bottom, right, top = around = parts.box_around([at - corner, at + corner])
        if not any(left < b[2] and b[0] < right and bottom < b[3] and b[1] < top for b in taken):
            taken.append(around)
            body.append(svg.text(kind, x + at.real, y - at.imag + 1.0 * scene.u, text, "middle"))
    return body + _offset_text(scene, x, y)


def _occupied(scene: Scene) -> list[Box]:
    """Boxes that texts must not touch: the roller, the stem and the rotation arrow."""
    u, (radius, first, last) = scene.u, scene.arc
    stem = np.arange(0.0, scene.roller / u + STEM, 2.0) * u
    points = [cmath.rect(radius, at) for at in np.linspace(first, last, 12)]
    points += [scene.centre + float(at) * scene.drive for at in stem]
    boxes = [parts.box_around([point], 2.5 * u) for point in points]
    return [*boxes, parts.box_around([scene.centre], 0.9 * scene.roller + 0.5 * u)]


def _texts(scene: Scene) -> Iterator[tuple[str, complex, str]]:
    """Kind, middle and what it says: cam angles outside, and inside what segments do."""
    u, at = scene.u, scene.borders

    def clear(text: str, normal: complex) -> float:
        """How far along a normal the middle of a text must stand to keep clear of its foot."""
        half = 0.5 * svg.width_of(text, svg.LABEL * u)
        return half * abs(normal.real) + 1.5 * u * abs(normal.imag) + 0.8 * u

    normals = (at.normal_x + 1j * at.normal_y).tolist()
    feet = (at.pitch_x + 1j * at.pitch_y).tolist()
    for angle, foot, normal in zip(in_degrees(at.theta).tolist(), feet, normals, strict=True):
        text = f"{svg.figure(angle, 6)}°"
        yield "label halo", foot + (TICK * u + clear(text, normal)) * normal, text
    moving = [s for s in scene.cam.motion.segments if s.angle > 0.0]
    at = scene.cam.at(np.array([s.start + 0.5 * s.angle for s in moving]))
    normals, feet = (at.normal_x + 1j * at.normal_y).tolist(), (at.x + 1j * at.y).tolist()
    for segment, foot, normal in zip(moving, feet, normals, strict=True):
        place = foot - (clear(segment.kind, normal) + 1.0 * u) * normal
        # where it is long enough
        if segment.angle * abs(place) > svg.width_of(segment.kind, svg.LABEL * u) + 2.0 * u:
            yield "quiet inner", place, segment.kind


def _offset_text(scene: Scene, x: float, y: float) -> list[str]:
    if abs(scene.offset) < 0.2 * scene.u or scene.drive.real != 0.0:
        return []
    u, text = scene.u, svg.figure(abs(scene.offset), 6)
    level = y - scene.extent[1] + (BELOW - 2.0) * u
    if svg.width_of(text, svg.LABEL * u) + 5.0 * u < abs(scene.offset):
        middle = x + 0.5 * scene.centre.real
        return [svg.text("label", middle, level - 1.0 * u, text, "middle")]
    return [svg.text("label", x + max(scene.centre.real, 0.0) + 5.0 * u, level + 1.0 * u, text)]


def cam_picture(design: Design, options: CamDrawingOptions) -> Sheet:
    """The drawing alone, without heading and legend, to be set into a page."""
    scene = Scene.of(design, options)
    scene = replace(scene, u=ENLARGED * scene.u)
    u, (left, bottom, right, top) = scene.u, scene.extent
    width, height = right - left + 2.0 * MARGIN * u, top - bottom + (BELOW + 9.0) * u
    x, y = MARGIN * u - left, 7.0 * u + top
    body = [
        f'<g transform="translate({svg.num(x)} {svg.num(y)}) scale(1 -1)">',
        *shapes(scene),
        "</g>",
        *labels(scene, x, y),
    ]
    title = f"Cam {design.name or design.id}"
    data = svg.document(width, height, u, title, "The cam.", body, theme=options.theme)
    return Sheet(data, width, height)


PROFILE = design_format("profile", "svg", _profile, CamDrawingOptions)
