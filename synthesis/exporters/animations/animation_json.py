"""The cam in motion as data: shapes with named parts, and where every part is over one turn.

For pages that show the machine their own way, as the studio does.
"""

from __future__ import annotations

import json

from synthesis.design.design import Design
from synthesis.exporters.animations.animation_page import tag
from synthesis.exporters.exporter import Exporter
from synthesis.exporters.figures.machine import Stage
from synthesis.exporters.options import Options
from synthesis.exporters.samples.cam import Cam

FRAMES = 360
FRAME = (
    "shapes: SVG elements in mm of the machine's frame, y upwards; its parts carry data-part. "
    "outline: the cam's own at cam angle 0. mirror: -1 where all of it, moves too, is to be "
    "mirrored at the y axis, as the cam turns clockwise. parts: over a turn, evenly spaced, "
    "the angle [deg] of a turn, counter-clockwise, or x and y [mm] of a shift; two values are a "
    "straight line. extent: left, bottom, right and top of all that is swept [mm]."
)


def _scene(design: Design, options: Options) -> bytes:
    stage = Stage.of(Cam.of(design), design.dimensions["base_radius_mm"], FRAMES, in_mm=True)
    left, bottom, right, top = stage.extent
    sides = (left, right) if stage.mirror > 0.0 else (-right, -left)
    body = {
        "kind": "animation",
        "design": {"id": design.id, "name": design.name, "status": design.status},
        "frame": FRAME,
        "mirror": int(stage.mirror),
        "extent": [sides[0], bottom, sides[1], top],
        "shapes": "\n".join(stage.shapes(tag)),
        "outline": stage.outline(),
        "parts": [p.data(stage.decimals) for p in stage.moving() if p.moves],
    }
    text = json.dumps(body, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.encode() + b"\n"


DATA = Exporter(
    "animation.json", "Shapes and positions of cam and follower", "application/json", ".json",
    _scene, Options, "For pages that show the machine their own way.", by_default=False,
)  # fmt: skip
