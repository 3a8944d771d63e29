"""Files of a shaper: tables of its motion, a cam for its ram, diagrams and animations."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Annotated, Any, Final

import numpy as np
from pydantic import Field

from synthesis.errors import InputError
from synthesis.exporters.animations import scene as animations
from synthesis.exporters.animations.scene import Scene, lasting
from synthesis.exporters.animations.scene import tag as data_tag
from synthesis.exporters.diagrams.plot import Frame, Plot, curve_plot, diagram
from synthesis.exporters.diagrams.sheet import FOOTER, GAP, HEIGHT, LEFT, RIGHT, WIDTH, angle_axis
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.canvas import TURNS, two_lines
from synthesis.exporters.figures.machine import Tag, moving_group
from synthesis.exporters.figures.parts import display_scale
from synthesis.exporters.options import MotionOptions, Options, PictureOptions
from synthesis.exporters.samples.columns import Column
from synthesis.exporters.tables import csv_table
from synthesis.machines.linkages.files import linkage_file as links
from synthesis.machines.linkages.files.linkage_file import CSV, SVG, LinkageFile, shifted
from synthesis.machines.linkages.shaper import SixBarShaper
from synthesis.machines.linkages.shaper.mechanism import Drive, Motion, Shaper, angle
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE, FULL_TURN

MIN_ROWS: Final = 36  # of a table: one in 10°
TOLERANCE: Final = 1e-4  # of the stroke: default tolerance of the cam's table
ROLLER: Final = 0.1  # of the stroke: default roller radius
DRAWN = 720  # points of a diagram
FRAMES = 360  # of the animation as data
HEADER = 24.0  # mm, above the diagrams of the sheet
SHAFT = "Crank angle from the start"
TITLE = "Six-bar shaper"
FRAME = (
    "parts: over a turn of the crank, evenly spaced, the angle [deg] of a turn, counter-clockwise, "
    "or x and y of a shift; two values are a straight line."
)
PLOTS = {"ram_mm": "Ram x", "ram_mm_per_s": "Ram's velocity v",
         "ram_mm_per_s2": "Ram's acceleration a", "guide_deg": "Guide's angle ψ"}  # fmt: skip
READINGS = {"ram_mm": ("x", "Ram"), "ram_mm_per_s": ("v", "Velocity"),
            "ram_mm_per_s2": ("a", "Acceleration"), "guide_deg": ("psi", "Guide's angle"),
            "transmission_deg": ("mu", "Transmission angle")}  # fmt: skip


@dataclass(frozen=True, eq=False)
class SampledTurn:
    """A shaper at evenly spaced angles of a turn."""

    shaper: Shaper
    drive: Drive
    travel: Array  # (n,) angle turned by the crank since its start [rad]
    motion: Motion  # of arrays (n,)

    @classmethod
    def of(
        cls, answer: SixBarShaper, count: int, closed: bool = True, turns: int = 1
    ) -> SampledTurn:
        """``count`` angles of a turn, of so many turns, and the end too where it is to be closed.

        Raises:
            InputError: the crank changes its speed over the turn; what it does then is not said.
        """
        if turns > 1 and answer.spec.acceleration_rad_per_s2:
            raise InputError(
                "/turns", turns,
                "The crank changes its speed over one turn; nothing is said of the next.",
                "Leave turns out, or request the linkage without acceleration_rad_per_s2.",
            )  # fmt: skip
        shaper, drive = answer.spec.shaper(answer.dimensions), answer.spec.drive
        travel = FULL_TURN * np.arange(count * turns + closed) / count
        return cls(shaper, drive, travel, shaper.motion(drive.phi(travel)))

    @cached_property
    def columns(self) -> dict[str, Column]:
        """All quantities by name, as columns of a table."""
        motion, drive, travel = self.motion, self.drive, self.travel
        rows: list[tuple[str, str, str, Any]] = [
            ("crank_travel_deg", "deg", "angle turned by the crank", travel),
            ("crank_deg", "deg", "crank angle", drive.phi(travel)),
            ("time_s", "s", "time since the start of the turn", drive.time(travel)),
        ]
        # Positions with their time derivatives, from those by the crank angle.
        for name, unit, meaning, (value, first, second) in (
            ("ram", "mm", "position of the ram's pin", motion.ram),
            ("guide", "deg", "angle of the guide", (angle(motion.guide), *motion.guide_turn)),
            ("coupler", "deg", "angle of the coupler",
             (angle(motion.coupler), *motion.coupler_turn)),
        ):  # fmt: skip
            velocity, acceleration = drive.first(first, travel), drive.second(first, second, travel)
            rows += [
                (f"{name}_{unit}", unit, meaning, value),
                (f"{name}_{unit}_per_s", f"{unit}/s", "its velocity", velocity),
                (f"{name}_{unit}_per_s2", f"{unit}/s²", "its acceleration", acceleration),
            ]
        upright = 0.5 * np.pi - np.abs(np.arcsin(motion.coupler[1]))
        _, first, second = motion.slide
        rows += [
            ("slide_mm", "mm", "crank's pin to the guide's pivot", motion.slide[0]),
            ("slide_mm_per_s", "mm/s", "velocity of the block along the guide, not the ram's",
             drive.first(first, travel)),
            ("slide_mm_per_s2", "mm/s²", "its acceleration along the guide",
             drive.second(first, second, travel)),
            ("transmission_deg", "deg", "transmission angle at the ram", upright),
        ]  # fmt: skip
        return {
            name: Column(name, unit, meaning, values / (DEGREE if unit[:3] == "deg" else 1.0))
            for name, unit, meaning, values in rows
        }


def _motion_columns(answer: SixBarShaper, options: MotionOptions) -> list[Column]:
    turn = SampledTurn.of(answer, max(MIN_ROWS, round(options.count)), turns=options.turns)
    return [*turn.columns.values()]


def _motion_json(answer: SixBarShaper, options: MotionOptions) -> bytes:
    columns = _motion_columns(answer, options)
    return _json(
        {
            "kind": "shaper motion",
            "shaper": {"id": answer.id, "name": answer.name, "status": answer.status},
            "dimensions": answer.dimensions,
            "rotation": answer.spec.rotation,
            "rows": len(columns[0].values),
            "columns": [vars(each) | {"values": each.values.tolist()} for each in columns],
        }
    )


@dataclass(frozen=True)
class CamOptions(Options):
    """The cam's follower and limits."""

    points: Annotated[int, Field(ge=36, le=3600, description="Rows of the table.")] = 360
    tolerance_mm: Annotated[float | None, Field(ge=1e-7, le=1e3)] = None
    """How far the follower may pass a row; left out: 1e-4 of the stroke."""
    roller_radius_mm: Annotated[float | None, Field(gt=0.0, le=1e6)] = None
    """Of the follower; left out: a tenth of the stroke."""
    pressure_angle_deg: Annotated[float, Field(gt=0.0, lt=90.0)] = 35.0
    """Largest pressure angle."""


def cam_spec(answer: SixBarShaper, options: CamOptions) -> bytes:
    """The ram's motion as a table of a DesignSpec, with a translating roller.

    Raises:
        InputError: the crank accelerates, so that the motion does not repeat.
    """
    if answer.spec.acceleration_rad_per_s2:
        raise InputError(
            "/acceleration_rad_per_s2", answer.spec.acceleration_rad_per_s2,
            "A cam turns at constant speed and repeats its motion; this crank changes its speed.",
            "Request the linkage at constant speed, without the acceleration.",
        )  # fmt: skip
    turn = SampledTurn.of(answer, options.points, closed=False)
    stroke, ram = float(answer.stroke_mm or 0.0), turn.motion.ram[0]
    motion = {
        "kind": "table",
        "angle_deg": 360.0,
        "angles_deg": np.degrees(turn.travel).tolist(),
        "displacements_mm": (ram - ram.min()).tolist(),
        "tolerance_mm": options.tolerance_mm or TOLERANCE * stroke,
    }
    roller, angle_deg = options.roller_radius_mm or ROLLER * stroke, options.pressure_angle_deg
    return _json(
        {
            "name": f"{answer.name.strip() or 'shaper'}: motion of the ram",
            "speed_rpm": answer.spec.speed_rpm,
            "rotation": answer.spec.rotation,
            "program": [motion],
            "follower": {"kind": "translating_roller", "roller_radius_mm": roller},
            "limits": [{"kind": "pressure_angle", "rise_deg": angle_deg, "return_deg": angle_deg}],
        }
    )


def _json(body: dict[str, Any]) -> bytes:
    return json.dumps(body, ensure_ascii=False, allow_nan=False).encode() + b"\n"


def _about(answer: SixBarShaper) -> str:
    rotation, speed = TURNS[answer.spec.rotation], svg.figure(answer.spec.speed_rpm, 6)
    stroke = "" if answer.stroke_mm is None else f" · stroke {svg.figure(answer.stroke_mm, 6)} mm"
    quick = answer.quick_return
    ratio = "" if quick is None else f" · quick return {svg.figure(quick.ratio, 5)}"
    return f"six-bar shaper · {rotation} at {speed} rpm{stroke}{ratio} · {answer.id[:8]}"


def _plots(turn: SampledTurn) -> list[Plot]:
    """Diagrams of quantities over the turn."""
    degrees = turn.columns["crank_travel_deg"].values.astype(float)
    return [
        curve_plot(title, svg.unit(one.unit), degrees, one.values.astype(float))
        for title, one in ((title, turn.columns[name]) for name, title in PLOTS.items())
    ]


def _grounds(answer: SixBarShaper, frame: Frame) -> list[str]:
    """Background: the quick stroke shaded, a line at every dead centre."""
    assert answer.quick_return is not None  # there is a shaper to draw
    centres = sorted(answer.dead_centres, key=lambda one: one.ram_mm)
    first, last = centres[-1].crank_travel_deg, centres[0].crank_travel_deg
    if answer.quick_return.slow_towards == "left":
        first, last = last, first
    spans = [(first, last)] if first <= last else [(first, 360.0), (0.0, last)]
    places = [frame.x(np.array(span)).tolist() for span in spans]
    across = frame.x(np.array([one.crank_travel_deg for one in answer.dead_centres])).tolist()
    return [
        *(svg.box("rest", a, frame.top, b - a, frame.height) for a, b in places),
        *(svg.line("border", x, frame.top, x, frame.top + frame.height) for x in across),
    ]


def _motion(answer: SixBarShaper, options: PictureOptions) -> bytes:
    """Diagrams below each other."""
    name, frame = answer.name.strip() or TITLE, Frame(LEFT, HEADER, WIDTH - LEFT - RIGHT, HEIGHT)
    body = two_lines(name, _about(answer), LEFT, WIDTH - RIGHT, 1.0)
    for k, plot in enumerate(_plots(SampledTurn.of(answer, DRAWN))):
        frame = replace(frame, top=HEADER + k * (HEIGHT + GAP))
        body += [*_grounds(answer, frame), *diagram(plot, frame)]
    body += angle_axis(frame, name=SHAFT)
    title = f"Motion of {name}"
    text = "Position, velocity and acceleration of the ram over a turn."
    height = frame.top + HEIGHT + FOOTER
    return svg.document(WIDTH, height, 1.0, title, text, body, theme=options.theme)


def _drawing(turn: SampledTurn) -> links.Drawing:
    """Bearings, the crank's circle, the ram's ways, and the links; the guide's pivot is 0."""
    shaper, motion = turn.shaper, turn.motion
    r, a = shaper.crank, shaper.pivot_distance
    by = display_scale(max(shaper.guide, r + a, abs(shaper.ram_line)))
    along, ram = motion.guide[0] + 1j * motion.guide[1], by * motion.ram[0]
    places = {
        "block": by * motion.slide[0] * along,
        "coupler": by * shaper.guide * along,
        "ram": ram + 1j * by * shaper.ram_line,
    }
    turns = {
        "crank": turn.drive.phi(turn.travel),
        "guide": angle(motion.guide),
        "block-turn": angle(motion.guide),
        "coupler-turn": angle(motion.coupler),
    }
    moving = links.moving_parts(places | turns)
    circle = by * np.array([0.0, complex(-r, a - r), complex(r, a + r)])
    u, extent = links.unit_and_extent(np.concatenate([circle, *places.values()]), 8.0)
    lengths = (r, a, shaper.guide, shaper.coupler, shaper.ram_line, float(np.max(motion.slide[0])))
    r, a, guide, coupler, level, slot = (by * length for length in lengths)
    low, high = float(ram.min()) - 6.0 * u, float(ram.max()) + 6.0 * u

    def shapes(tag: Tag) -> list[str]:
        def group(name: str, body: list[str]) -> list[str]:
            return moving_group(name, tag, moving, body)

        pin = svg.circle(links.PIN, guide, 0.0, 0.9 * u)
        return [
            *(svg.line("line axis", low, level + k * 3.0 * u, high, level + k * 3.0 * u)
              for k in (-1.0, 1.0)),
            svg.circle("line circle", 0.0, a, r),
            *links.bearing(0.0, 0.0, u),
            *links.bearing(0.0, a, u),
            *group("guide", [*links.bar(max(guide, slot), 2.0 * u), pin]),
            *group("ram", links.block(9.0 * u, 6.0 * u)),
            *group("coupler", group("coupler-turn", links.bar(coupler, 1.4 * u))),
            *shifted(0.0, a, group("crank", links.bar(r, 1.7 * u))),
            *group("block", group("block-turn", links.block(7.0 * u, 4.6 * u))),
        ]  # fmt: skip

    return links.Drawing(by, extent, moving, shapes)


def _scene(answer: SixBarShaper, count: int) -> Scene:
    turn = SampledTurn.of(answer, count)
    return links.linkage_scene(
        answer, TITLE, _about(answer), _drawing(turn),
        _plots(turn)[:2],
        [(*titles, turn.columns[name].unit, turn.columns[name].values.astype(float))
         for name, titles in READINGS.items()],
        partial(_grounds, answer),
        shaft=SHAFT,
        titles=("Six-bar shaper", "Position and velocity of the ram"),
        described="The crank turns, the guide swings, the coupler moves the ram, and points run on "
        "its diagrams.",
        footer=lasting(float(turn.drive.time(turn.travel[-1]))),
    )  # fmt: skip


def _data(answer: SixBarShaper, options: Options) -> bytes:
    drawing = _drawing(SampledTurn.of(answer, FRAMES))
    return links.scene_json(
        answer, FRAME, drawing.by, drawing.extent, shapes="\n".join(drawing.shapes(data_tag)),
        parts=[part.data(links.DECIMALS) for part in drawing.moving if part.moves], mirror=1,
    )  # fmt: skip


FILES = (
    LinkageFile("motion.csv", "Table of the motion", CSV, ".csv",
                lambda answer, options: csv_table(_motion_columns(answer, options)), MotionOptions,
                "For spreadsheets: the motion of crank, guide and ram, a row for each angle."),
    LinkageFile("motion.json", "Table of the motion, with units and meanings", "application/json",
                ".json", _motion_json, MotionOptions, "For programs: the same by columns."),
    LinkageFile(
        "cam.json", "Question for a cam that moves its follower as the ram", "application/json",
        ".json", cam_spec, CamOptions,
        "A body for POST /v1/designs: the ram's motion as a table, a translating roller and a "
        "limit on the pressure angle, to be edited as needed.",
        suits=lambda answer: not answer.spec.acceleration_rad_per_s2,
    ),
    LinkageFile("motion.svg", "Diagrams of the motion", SVG, ".svg", _motion,
                PictureOptions,
                "The quick stroke is shaded; a line stands at every dead centre."),
    *animations.pictures(
        LinkageFile, _scene, "Animation", "For a document or a web page; no script."
    ),
    animations.data(LinkageFile, _data, "Shapes and positions of its links over a turn"),
)  # fmt: skip
