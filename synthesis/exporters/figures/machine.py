"""The machine as a drawing whose parts can be moved: cam, link, rollers, contacts (y upwards).

The shapes are those of a ccw cam, in its mm, or in a power of ten of them where it is very small or
very large; a clockwise one is mirrored as a whole. Each moving
part is a group of its own with a name, and stands as at cam angle 0.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from synthesis.catalogue.followers.base import prime_radius
from synthesis.catalogue.followers.kinematics import Face
from synthesis.catalogue.profile import CamProfile
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.figures import parts
from synthesis.exporters.figures.mechanism import Contact, Mechanism
from synthesis.exporters.figures.parts import HUB, PIVOT, STEM, Box, Flanks
from synthesis.exporters.options import ProfileOptions
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.sampling import ring
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

Tag = Callable[[str], str]  # name of a part -> the attribute that its group carries
ACROSS = 92.0  # units from side to side of a cam
DRAWN = ProfileOptions(points_per_degree=2.0)
GUIDE, OVER = (4.0, 12.0), 2.0  # of a slide, in units: from and to above its highest place; more
SPOKES = (0.0, 60.0, 120.0)  # of a roller [deg]
STILL = 1e-9  # what moves less, or departs less from a line [mm, deg], does not


@dataclass(frozen=True, eq=False)
class Moving:
    """How a part moves: ``turn`` by an angle [deg, ccw], or ``shift`` by (x, y); (n, 1 or 2)."""

    name: str
    kind: Literal["turn", "shift"]
    values: Array
    rolls: bool = False  # not back where it began after a turn; drawn within a group of its mean

    @property
    def moves(self) -> bool:
        """Whether it does."""
        return bool(np.max(np.ptp(self.values, axis=0)) > STILL)

    @property
    def first(self) -> str:
        """Where it stands at cam angle 0, as SVG has it."""
        place = " ".join(svg.num(value, 6) for value in self.values[0].tolist())
        return f"{'rotate' if self.kind == 'turn' else 'translate'}({place})"

    def data(self, decimals: int) -> dict[str, Any]:
        """Its name, and its columns over one turn; two values are a straight line."""
        digits, columns = 3 if self.kind == "turn" else decimals, []
        for values in self.values.T:
            straight = np.linspace(values[0], values[-1], len(values))
            shown = values[[0, -1]] if np.max(np.abs(values - straight)) < STILL else values
            columns.append([round(v, digits) + 0.0 for v in shown.tolist()])
        return {"name": self.name, "kind": self.kind, "columns": columns}


def moving_group(name: str, tag: Tag, moving: Sequence[Moving], body: Sequence[str]) -> list[str]:
    """A part that moves, where it stands first."""
    first = next((part.first for part in moving if part.name == name), "translate(0 0)")
    return [f'<g {tag(name)} transform="{first}">', *body, "</g>"]


@dataclass(frozen=True, eq=False)
class Stage:
    """The machine on its place of the sheet.

    Attributes:
        mechanism: how it moves. flanks: the cam's curves. mirror: −1 where the cam turns clockwise.
        base, prime: radii [mm]; prime is 0 without a roller.
        u: length that shapes are drawn with: widths of stems, of the shaft [mm].
        extent: left, bottom, right and top of all that it sweeps [mm].
        decimals: of coordinates.
    """

    mechanism: Mechanism
    flanks: Flanks
    mirror: float
    base: float
    prime: float
    u: float
    extent: Box
    decimals: int

    @classmethod
    def of(cls, cam: Cam, base: float, count: int, in_mm: bool = False) -> Stage:
        """The stage of a cam with its base radius [mm], at ``count`` + 1 angles.

        ``in_mm``: of any size in millimetres, not in a power of ten of them.
        """
        mirror = -1.0 if cam.rotation == "cw" else 1.0
        cam = replace(cam, rotation="ccw")
        flanks = tuple((one.flank, ring(one, DRAWN.count, None)) for one in cam.flanks())
        paths = [xy for _, at in flanks for xy in ((at.x, at.y), (at.pitch_x, at.pitch_y))]
        reach = max(parts.rim_of(flanks), *(float(np.hypot(x, y).max()) for x, y in paths))
        by = 1.0 if in_mm else parts.display_scale(reach)
        mechanism, reach = Mechanism.of(cam, count, by), by * reach
        u = 2.0 * reach / ACROSS

        def scaled(at: CamProfile) -> CamProfile:
            pitch_x, pitch_y = by * at.pitch_x, by * at.pitch_y
            return replace(at, x=by * at.x, y=by * at.y, pitch_x=pitch_x, pitch_y=pitch_y)

        prime = prime_radius(cam.follower, cam.size) if mechanism.contacts[0].roller > 0.0 else 0.0
        return cls(
            mechanism,
            tuple((flank.scaled(by), scaled(curve)) for flank, curve in flanks),
            mirror,
            by * base,
            by * prime,
            u,
            _extent(mechanism, reach, u),
            max(3, 6 - math.floor(math.log10(reach))),
        )

    def shapes(self, tag: Tag) -> list[str]:
        """Its elements in its own mm."""
        return [
            *_ground(self),
            *moving_group("cam", tag, self.moving(), _cam(self)),
            *_link(self, tag),
        ]

    def moving(self) -> list[Moving]:
        """Every part that can move."""
        machine, slide = self.mechanism, self.mechanism.slide
        moved = machine.moved
        link = _turn("link", moved) if slide is None else _shift("link", moved, slide)
        movable = [_turn("cam", machine.theta), link]
        for k, contact in enumerate(machine.contacts):
            along = cmath.rect(1.0, contact.heading)
            movable += [
                _shift(f"along{k}", contact.along, along),
                _turn(f"normal{k}", contact.normal),
                _turn(f"drive{k}", contact.drive),
                _turn(f"roll{k}", contact.roll, rolls=True),
            ]
        return movable


def _turn(name: str, angle: Array, rolls: bool = False) -> Moving:
    """A part that turns by angles (n,) [rad]."""
    return Moving(name, "turn", angle[:, None] / DEGREE, rolls)


def _shift(name: str, by: Array, along: complex) -> Moving:
    """A part that is shifted so far (n,) along a unit vector."""
    return Moving(name, "shift", np.outer(by, (along.real, along.imag)))


def _extent(machine: Mechanism, reach: float, u: float) -> Box:
    """What cam and follower sweep."""
    points = [complex(-reach, -reach), complex(reach, reach)]
    ends = np.linspace(machine.moved.min(), machine.moved.max(), 9).tolist()
    points += [machine.carried(corner, at) for corner in _corners(machine, u) for at in ends]
    if machine.pivot is not None:
        eye = PIVOT * STEM * u
        points += [machine.pivot + eye * to for to in (-1.6 - 2.2j, 1.6 + 1.6j)]
    return parts.box_around(points, u)


def _corners(machine: Mechanism, u: float) -> Iterator[complex]:
    """The outermost points of rollers, a face and a stem, on the link at displacement 0."""
    for contact in machine.contacts:
        r = contact.roller
        yield from (contact.place + complex(a, b) for a in (-r, r) for b in (-r, r))
        for end in _face_ends(contact, machine, u) if machine.face is not None else ():
            yield contact.place + cmath.rect(1.0, contact.heading) * end
    if machine.slide is not None:
        top = machine.contacts[0].place + _stem_length(machine, u) * machine.slide
        yield from (top + a * u for a in (-4.0, 4.0))


def _ground(stage: Stage) -> list[str]:
    """What stands still: centre lines, a slide's guide, a pivot's bearing."""
    (left, bottom, right, top), u, machine = stage.extent, stage.u, stage.mechanism
    body = [svg.line("line centre", left, 0.0, right, 0.0),
            svg.line("line centre", 0.0, bottom, 0.0, top)]  # fmt: skip
    first = machine.contacts[0]
    if machine.slide is not None:
        half, above = parts.half_width(first.roller, u), first.roller + float(machine.moved.max())
        a, b = (above + k * u for k in GUIDE)
        for sign in (-1.0, 1.0):
            c, d = (sign * (half + k * u) for k in (0.3, 2.0))
            corners = [(a, c), (a, d), (b, d), (b, c)]
            body.append(parts.polygon("solid", first.place, machine.slide, corners))
    if machine.pivot is not None:
        eye = PIVOT * STEM * u
        foot = [(0.0, 0.0), (-2.0 * eye, -1.2 * eye), (-2.0 * eye, 1.2 * eye)]
        body.append(parts.polygon("line border", machine.pivot, 1j, foot))
    return body


def _cam(stage: Stage) -> list[str]:
    """The cam with its shaft, and a mark where its cam angle 0 is."""
    u, decimals, first = stage.u, stage.decimals, stage.flanks[0][0]
    body = [svg.circle("line circle", 0.0, 0.0, stage.base)]
    pitch = {flank.path: curve for flank, curve in stage.flanks if flank.distance > 0.0}
    body += [parts.pitch_curve(curve, decimals) for curve in pitch.values()]
    body.append(parts.outline(stage.flanks, 1.0, decimals))
    others = (curve for flank, curve in stage.flanks if flank.path != first.path)
    body += [parts.profile_curve(curve, decimals) for curve in others]
    start, wide, tall = complex(-0.9 * u, 2.2 * HUB * u), 1.8 * u, svg.num(1.6 * u)
    mark = f"M{parts.place(start)}h{svg.num(wide)}v{tall}h{svg.num(-wide)}Z"
    return [*body, svg.circle("outline metal", 0.0, 0.0, 2.5 * HUB * u), svg.path("solid", mark)]


def _link(stage: Stage, tag: Tag) -> list[str]:
    """The follower's link with everything on it."""
    machine, u = stage.mechanism, stage.u
    face, pivot = machine.face, machine.pivot
    body = _holders(machine, u) if face is None else _plate(machine, face, u)
    for number in range(len(machine.contacts)):
        body += _contact(stage, number, tag)
    if pivot is None:
        return moving_group("link", tag, stage.moving(), body)
    body += parts.eye(pivot, u)
    inner = [f'<g transform="translate({parts.place(-pivot)})">', *body, "</g>"]
    return [
        f'<g transform="translate({parts.place(pivot)})">',
        *moving_group("link", tag, stage.moving(), inner),
        "</g>",
    ]


def _contact(stage: Stage, number: int, tag: Tag) -> list[str]:
    """Roller, contact point, common normal and direction of motion, from the traced point."""
    contact, u = stage.mechanism.contacts[number], stage.u
    reach = contact.flank.side * contact.flank.distance
    beyond = math.copysign(7.0 * u, contact.flank.side)
    normal = [svg.line("line normal", -reach - beyond, 0.0, 15.0 * u, 0.0),
              svg.circle("mark", -reach, 0.0, 1.1 * u)]  # fmt: skip
    drive = [svg.line("line front", 0.0, 0.0, 14.0 * u, 0.0),
             svg.arrow_head("start", 16.0 * u, 0.0, 0.0, 2.6 * u)]  # fmt: skip
    body = _wheel(contact.roller, u)
    if body:
        mean = f"<g {tag(f'roll{number}-mean')}>"
        body = [mean, *moving_group(f"roll{number}", tag, stage.moving(), body), "</g>"]
    inner = [*moving_group(f"drive{number}", tag, stage.moving(), drive),
             *moving_group(f"normal{number}", tag, stage.moving(), normal)]  # fmt: skip
    return [f'<g transform="translate({parts.place(contact.place, 6)})">', *body,
            *moving_group(f"along{number}", tag, stage.moving(), inner), "</g>"]  # fmt: skip


def _stem_length(machine: Mechanism, u: float) -> float:
    """From a slide's roller or face to the end of its stem, through the guide [mm]."""
    roller = machine.contacts[0].roller
    return roller + float(machine.moved.max()) + (GUIDE[1] + OVER) * u


def _face_ends(contact: Contact, machine: Mechanism, u: float) -> tuple[float, float]:
    """From where to where a face is drawn [mm]: as far as contact needs it; on a pivot from it."""
    low, high = float(contact.along.min()), float(contact.along.max())
    if machine.pivot is not None:
        return min(low, 0.0), max(high, 0.0)
    return min(low, -1.5 * u), max(high, 1.5 * u)


def _holders(machine: Mechanism, u: float) -> list[str]:
    """Stem or arms of the rollers, and what joins two of them on one slide."""
    pivot, up, first = machine.pivot, machine.slide, machine.contacts[0]
    if pivot is not None:
        return [
            edge for one in machine.contacts for edge in parts.bar(one.place, pivot, one.roller, u)
        ]
    assert up is not None
    half, length = parts.half_width(first.roller, u), _stem_length(machine, u)
    foot = math.sqrt(max(first.roller**2 - half**2, 0.0)) if first.roller else 3.0 * half
    corners = [(length, -half), (foot, -half), (foot, half), (length, half)]
    body = [parts.line("line axis", first.place, one.place) for one in machine.contacts[1:]]
    body.append(parts.polygon("outline metal", first.place, up, corners))
    if first.roller == 0.0:
        corners = [(foot, -half), (0.0, 0.0), (foot, half)]
        body.append(parts.polygon("outline metal", first.place, up, corners, closed=False))
    return body


def _plate(machine: Mechanism, face: Face, u: float) -> list[str]:
    """The plate, and its stem or the link to its pivot."""
    pivot, up, contact = machine.pivot, machine.slide, machine.contacts[0]
    normal, along = (complex(float(x), float(y)) for x, y in (face.normal, face.along))
    low, high = _face_ends(contact, machine, u)
    right = 1.0 if (along.conjugate() * normal).imag > 0.0 else -1.0
    ends, thick = (right * low, right * high), 2.0 * u
    corners = [(0.0, ends[0]), (0.0, ends[1]), (thick, ends[1]), (thick, ends[0])]
    body = parts.polygon("outline metal", contact.place, normal, corners)
    if pivot is not None:
        return [parts.line("line outline", contact.place, pivot), body]
    assert up is not None
    half, length = parts.half_width(0.0, u), _stem_length(machine, u)
    corners = [(length, -half), (0.0, -half), (0.0, half), (length, half)]
    return [parts.polygon("outline metal", contact.place, up, corners), body]


def _wheel(radius: float, u: float) -> list[str]:
    """A roller with spokes, one of them marked, so that it is seen to turn."""
    if radius == 0.0:
        return []
    hub = min(0.2 * radius, 2.0 * HUB * u)
    spokes = [
        svg.line("line axis", -a * radius, -b * radius, a * radius, b * radius)
        for a, b in ((math.cos(t * DEGREE), math.sin(t * DEGREE)) for t in SPOKES)
    ]
    return [svg.circle("outline glass", 0.0, 0.0, radius), *spokes,
            svg.circle("outline metal", 0.0, 0.0, hub),
            svg.circle("solid", 0.0, 0.72 * radius, min(0.12 * radius, 1.2 * u))]  # fmt: skip
