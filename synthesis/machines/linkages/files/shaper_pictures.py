"""Drawings of a shaper: animation, and diagrams of its motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from synthesis.exporters.animations.panels import DIAGRAMS, EDGE, MACHINE
from synthesis.exporters.animations.scene import Scene, grouped, lasting, reading
from synthesis.exporters.diagrams.diagram import Frame
from synthesis.exporters.diagrams.plot import Plot
from synthesis.exporters.diagrams.sheet import LEFT, RIGHT, WIDTH
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.heading import TURNS, two_lines
from synthesis.exporters.drawing.picture_options import PictureOptions
from synthesis.exporters.drawing.theme import lines
from synthesis.exporters.exporter import untold
from synthesis.exporters.figures.machine import Moving, Tag
from synthesis.exporters.figures.parts import Box, placed, scale_in
from synthesis.machines.linkages.files import links
from synthesis.machines.linkages.files.diagrams import TracedDiagrams, plot, sheet
from synthesis.machines.linkages.files.linkage_file import (
    LinkageFile,
    animation_page,
    animation_svg,
)
from synthesis.machines.linkages.files.shaper_tables import Rows
from synthesis.machines.linkages.shaper import SixBarShaper
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

DRAWN = 720  # points of a diagram
SHAFT = "Crank angle from the start"
TITLE = "Six-bar shaper"


def _about(found: SixBarShaper) -> str:
    rotation, speed = TURNS[found.spec.rotation], svg.figure(found.spec.speed_rpm, 6)
    stroke = "" if found.stroke_mm is None else f" · stroke {svg.figure(found.stroke_mm, 6)} mm"
    quick = found.quick_return
    ratio = "" if quick is None else f" · quick return {svg.figure(quick.ratio, 5)}"
    return f"six-bar shaper · {rotation} at {speed} rpm{stroke}{ratio} · {found.id[:8]}"


def _plots(rows: Rows, extremes: bool) -> list[Plot]:
    degrees = rows.turned / DEGREE
    told: Sequence[tuple[str, str, Array]] = (
        ("Ram x", "mm", rows.motion.ram[0]),
        ("Ram's velocity v", "mm/s", rows.velocity),
        ("Ram's acceleration a", "mm/s²", rows.acceleration),
        ("Guide's angle ψ", "°", rows.guide / DEGREE),
    )
    return [plot(title, unit, degrees, values, extremes) for title, unit, values in told]


def _grounds(found: SixBarShaper, frame: Frame) -> list[str]:
    """Background: the quick stroke shaded, a line at every dead centre."""
    centres = sorted(found.dead_centres, key=lambda one: one.ram_mm)
    quick = found.quick_return
    assert quick is not None  # there is a shaper to draw
    first, last = centres[-1], centres[0]
    if quick.slow_towards == "left":
        first, last = last, first
    spans = [(first.crank_travel_deg, last.crank_travel_deg)]
    if last.crank_travel_deg < first.crank_travel_deg:
        spans = [(first.crank_travel_deg, 360.0), (0.0, last.crank_travel_deg)]
    places = [frame.x(np.array(span)).tolist() for span in spans]
    shaded = [svg.box("rest", a, frame.top, b - a, frame.height) for a, b in places]
    across = frame.x(np.array([one.crank_travel_deg for one in found.dead_centres])).tolist()
    return [
        *shaded,
        *(svg.line("border", x, frame.top, x, frame.top + frame.height) for x in across),
    ]


def _motion(found: SixBarShaper, options: PictureOptions) -> bytes:
    plots = _plots(Rows.of(found, DRAWN), extremes=True)
    name = found.name.strip() or TITLE
    told = f"Motion of {name}", "Position, velocity and acceleration of the ram over a turn."
    heading = two_lines(name, _about(found), LEFT, WIDTH - RIGHT, 1.0)
    return sheet(plots, heading, told, SHAFT, partial(_grounds, found), options.theme)


@dataclass(frozen=True, eq=False)
class Stage:
    """The shaper as drawn; lengths in mm times the scale ``by``."""

    rows: Rows
    by: float

    @classmethod
    def of(cls, found: SixBarShaper, count: int) -> Stage:
        """The stage of an answer, at ``count`` + 1 angles of its crank."""
        rows = Rows.of(found, count)
        shaper = rows.shaper
        reach = max(shaper.guide, shaper.crank + shaper.pivot_distance, abs(shaper.ram_line))
        return cls(rows, links.display_scale(reach))

    @cached_property
    def places(self) -> dict[str, Array]:
        """Positions of the crank's pin, the guide's end and the ram's pin: (n, 2) each."""
        shaper, motion = self.rows.shaper, self.rows.motion
        cosine, sine = motion.guide
        ram = motion.ram[0]
        return {
            "block": self.by * np.stack([motion.slide[0] * cosine, motion.slide[0] * sine], axis=1),
            "coupler": self.by * shaper.guide * np.stack([cosine, sine], axis=1),
            "ram": self.by * np.stack([ram, shaper.ram_line + 0.0 * ram], axis=1),
        }

    @property
    def u(self) -> float:
        """Unit of line widths and symbols."""
        left, bottom, right, top = links.extent_of(self._points(), 0.0)
        return max(right - left, top - bottom) / links.ACROSS

    def _points(self) -> list[tuple[float, float]]:
        shaper = self.rows.shaper
        r, a = self.by * shaper.crank, self.by * shaper.pivot_distance
        found = [(0.0, 0.0), (-r, a - r), (r, a + r)]
        return found + [(x, y) for each in self.places.values() for x, y in each.tolist()]

    @property
    def extent(self) -> Box:
        """Bounding box of the whole motion."""
        return links.extent_of(self._points(), 8.0 * self.u)

    def moving(self) -> list[Moving]:
        """Every part that moves."""
        rows = self.rows
        guide, coupler = rows.guide[:, None] / DEGREE, rows.coupler[:, None] / DEGREE
        crank = rows.drive.phi(rows.turned)[:, None] / DEGREE
        shifts = [Moving(name, "shift", values) for name, values in self.places.items()]
        turns = [Moving("crank", "turn", crank), Moving("guide", "turn", guide),
                 Moving("block-turn", "turn", guide),
                 Moving("coupler-turn", "turn", coupler)]  # fmt: skip
        return [*shifts, *turns]

    def shapes(self, tag: Tag) -> list[str]:
        """The shaper's elements."""
        shaper, u, moving = self.rows.shaper, self.u, self.moving()
        r, a = self.by * shaper.crank, self.by * shaper.pivot_distance
        guide, coupler = self.by * shaper.guide, self.by * shaper.coupler
        slot = max(guide, self.by * float(np.max(self.rows.motion.slide[0])))
        rail = [*links.bar(slot, 2.0 * u), links.pin(guide, 0.0, 0.9 * u)]

        def group(name: str, body: Sequence[str]) -> list[str]:
            return grouped(name, tag, moving, body)

        crank = [f'<g transform="translate(0 {svg.num(a)})">',
                 *group("crank", links.bar(r, 1.7 * u)), "</g>"]  # fmt: skip
        return [
            *self._ground(),
            *group("guide", rail),
            *group("ram", links.block(9.0 * u, 6.0 * u)),
            *group("coupler", group("coupler-turn", links.bar(coupler, 1.4 * u))),
            *crank,
            *group("block", group("block-turn", links.block(7.0 * u, 4.6 * u))),
        ]

    def _ground(self) -> list[str]:
        """Bearings, the crank's circle, the ram's ways."""
        shaper, u = self.rows.shaper, self.u
        a, level = self.by * shaper.pivot_distance, self.by * shaper.ram_line
        x = self.places["ram"][:, 0]
        low, high = float(x.min()) - 6.0 * u, float(x.max()) + 6.0 * u
        ways = [svg.line("line axis", low, level + k * 3.0 * u, high, level + k * 3.0 * u)
                for k in (-1.0, 1.0)]  # fmt: skip
        return [*ways, svg.circle("line circle", 0.0, a, self.by * shaper.crank),
                *links.bearing(0.0, 0.0, u), *links.bearing(0.0, a, u)]  # fmt: skip


def _scene(found: SixBarShaper, count: int) -> Scene:
    stage = Stage.of(found, count)
    rows = stage.rows
    traced = TracedDiagrams(
        tuple(_plots(rows, extremes=False)[:2]), SHAFT, partial(_grounds, found)
    )
    name = found.name.strip() or TITLE
    size = {key: float(np.max(np.abs(values))) for key, values in _read(rows).items()}
    u_scale = 1.0 / scale_in(stage.extent, MACHINE)
    return Scene(
        name=name,
        about=_about(found),
        key=found.id,
        heading=two_lines(name, _about(found), EDGE, EDGE + MACHINE[0] + DIAGRAMS[0], 1.0),
        shaft=SHAFT,
        titles=("Six-bar shaper", "Position and velocity of the ram"),
        described="The crank turns, the guide swings, the coupler moves the ram, and points run "
        "on its diagrams.",
        machine=lambda tag: placed(stage.shapes(tag), stage.extent, MACHINE),
        diagrams=traced.panel,
        moving=[part for part in (*stage.moving(), *traced.moving()) if part.moves],
        readings=[
            reading(key, title, unit, _read(rows)[key], size[key]) for key, title, unit in READ
        ],
        decimals=4,
        rules="".join(lines(u_scale, ".camwright .mechanism")),
        footer=lasting(float(rows.drive.time(rows.turned[-1]))),
    )


READ = (("x", "Ram", "mm"), ("v", "Velocity", "mm/s"), ("a", "Acceleration", "mm/s²"),
        ("psi", "Guide's angle", "deg"), ("mu", "Transmission angle", "deg"))  # fmt: skip


def _read(rows: Rows) -> dict[str, Array]:
    transmission = 90.0 - np.abs(rows.coupler_slope) / DEGREE
    return {"x": rows.motion.ram[0], "v": rows.velocity, "a": rows.acceleration,
            "psi": rows.guide / DEGREE, "mu": transmission}  # fmt: skip


MOTION = LinkageFile(
    "motion.svg",
    "Diagrams of the motion",
    "image/svg+xml",
    ".svg",
    untold(_motion),
    PictureOptions,
    "The quick stroke is shaded; a line stands at every dead centre.",
)
ANIMATION = animation_svg(_scene, "For a document or a web page; no script.")
PAGE = animation_page(_scene)
