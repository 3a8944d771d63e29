"""A cam in motion: the machine, two diagrams with moving points, numbers; and as data."""

from __future__ import annotations

from functools import partial

import numpy as np

from synthesis.design.design import Design
from synthesis.exporters.animations import scene as animations
from synthesis.exporters.animations.scene import DIAGRAMS, EDGE, MACHINE, Reading, Scene
from synthesis.exporters.diagrams.sheet import grounds, motion_bounds, motion_plot, pressure_plot
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.canvas import about, heading
from synthesis.exporters.exporter import Exporter, compact_json
from synthesis.exporters.figures.machine import Stage
from synthesis.exporters.figures.parts import line_style, outline, place_in_panel
from synthesis.exporters.options import Options
from synthesis.exporters.samples.cam import Cam
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

FRAMES = 360  # positions of the data over a turn
FRAME = (
    "shapes: SVG elements in mm of the machine's frame, y upwards; its parts carry data-part. "
    "outline: the cam's own at cam angle 0. mirror: -1 where all of it, moves too, is to be "
    "mirrored at the y axis, as the cam turns clockwise. parts: over a turn, evenly spaced, "
    "the angle [deg] of a turn, counter-clockwise, or x and y [mm] of a shift; two values are a "
    "straight line. extent: left, bottom, right and top of all that is swept [mm]."
)
LEGEND = (
    ("line circle", "base circle"),
    ("line pitch", "path of the roller's centre"),
    ("line normal", "common normal"),
    ("line front", "follower is driven this way"),
)


def cam_scene(design: Design, count: int) -> Scene:
    """A cam in motion, at ``count`` + 1 angles."""
    cam, shaft = Cam.of(design), "Cam angle"
    stage = Stage.of(cam, design.dimensions["base_radius_mm"], count)
    machine = stage.mechanism
    pressure_angle = machine.contacts[0].curve.pressure_angle / DEGREE
    points, diagrams = animations.traced_diagrams(
        (motion_plot(cam, 0, limits=motion_bounds(design, 0)), pressure_plot(design, cam)),
        machine.theta / DEGREE,
        (machine.s, pressure_angle),
        partial(grounds, design.motion),
        shaft,
    )
    s = cam.motion.derivatives(machine.theta, 2)
    units = [cam.travel.derivative_unit(order) for order in range(3)]
    return Scene(
        name=design.name.strip(),
        about=about(design),
        key=design.id,
        heading=heading(design, EDGE, EDGE + MACHINE[0] + DIAGRAMS[0], 1.0),
        shaft=shaft,
        titles=("Cam and follower", "Displacement and pressure angle"),
        described="The cam turns, the follower with its roller moves, and points run on its "
        "diagrams.",
        machine=lambda tag: place_in_panel(stage.shapes(tag), stage.extent, MACHINE, stage.mirror),
        diagrams=lambda tag: [*diagrams(tag), *_legend(stage)],
        moving=[part for part in (*stage.moving(), *points) if part.moves],
        readings=[
            _reading("s", "Displacement", units[0], machine.s),
            _reading("v", "Velocity", units[1], s[1] * cam.rate(1)),
            _reading("a", "Acceleration", units[2], s[2] * cam.rate(2)),
            _reading("alpha", "Pressure angle", "deg", pressure_angle),
            _reading("radius", "Profile radius", "mm", machine.contacts[0].curve.radius),
        ],
        decimals=stage.decimals,
        rules=line_style(stage.extent, MACHINE),
        footer=animations.lasting(60.0 / design.speed_rpm),
    )


def _reading(name: str, title: str, unit: str, values: Array) -> Reading:
    finite = np.abs(values[np.isfinite(values) & (np.abs(values) < 1e6)])
    size = float(np.median(finite)) if name == "radius" else float(finite.max(initial=0.0))
    return animations.reading(name, title, unit, values, size)


def _legend(stage: Stage) -> list[str]:
    """Kinds of lines in two columns; without a roller there is no path of its centre."""
    rows = [row for row in LEGEND if stage.prime > 0.0 or row[0] != "line pitch"]
    top = animations.TOP + 2.0 * animations.HEIGHT + animations.GAP + 14.5
    body = []
    for k, (kind, text) in enumerate(rows):
        x, y = 4.0 + (k % 2) * 0.5 * DIAGRAMS[0], top + (k // 2) * 5.0
        body += [svg.line(kind, x, y, x + 9.0, y), svg.text("tick", x + 11.0, y + 0.9, text)]
    return body


def _cam_json(design: Design, options: Options) -> bytes:
    stage = Stage.of(Cam.of(design), design.dimensions["base_radius_mm"], FRAMES, in_mm=True)
    left, bottom, right, top = stage.extent
    sides = (left, right) if stage.mirror > 0.0 else (-right, -left)
    body = {
        "kind": "animation",
        "design": {"id": design.id, "name": design.name, "status": design.status},
        "frame": FRAME,
        "mirror": int(stage.mirror),
        "extent": [sides[0], bottom, sides[1], top],
        "shapes": "\n".join(stage.shapes(animations.tag)),
        "outline": outline(stage.flanks, 1.0, stage.decimals),
        "parts": [p.data(stage.decimals) for p in stage.moving() if p.moves],
    }
    return compact_json(body) + b"\n"


FORMATS = (
    *animations.pictures(
        Exporter, cam_scene, "Animation of cam and follower",
        "For a document or a web page; no script.",
    ),
    animations.data(Exporter, _cam_json, "Shapes and positions of cam and follower"),
)  # fmt: skip
