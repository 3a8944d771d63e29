"""Linkages as data for other viewers, such as the studio: shapes, named parts, positions."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np

from synthesis.exporters.animations.animation_page import tag, told_part
from synthesis.exporters.exporter import untold
from synthesis.exporters.figures.parts import Box
from synthesis.exporters.options import Options
from synthesis.machines.linkages.arm import PalletisingArm
from synthesis.machines.linkages.arm.report import ArmPose
from synthesis.machines.linkages.files import arm_shapes
from synthesis.machines.linkages.files.arm_shapes import Plan
from synthesis.machines.linkages.files.linkage_file import LinkageFile
from synthesis.machines.linkages.files.shaper_pictures import Stage
from synthesis.machines.linkages.shaper import SixBarShaper
from synthesis.units import DEGREE

FRAMES = 360
DECIMALS = 4
SCALED = (
    "shapes: SVG elements, y upwards, scale times as large as in mm; parts carry data-part. "
    "extent: left, bottom, right and top, in the same scale. "
)
TURNING = (
    "parts: over a turn of the crank, evenly spaced, the angle [deg] of a turn, counter-clockwise, "
    "or x and y of a shift; two values are a straight line."
)
STANDING = (
    "arm: the elements of the arm. poses: where its parts are for each solution, as a turn's angle "
    "[deg] or x and y of a shift; mirror: -1 where the base is turned away, and the arm is to be "
    "mirrored at axis 1; target: the pose's r and z. plan: seen from above, x to the right, y "
    "upwards; its part base points to where the base is turned, by base_deg; its target is x, y."
)


def _shaper(found: SixBarShaper, options: Options) -> bytes:
    stage = Stage.of(found, FRAMES)
    parts = [told_part(part, DECIMALS) for part in stage.moving() if part.moves]
    shapes = "\n".join(stage.shapes(tag))
    return _body(found, SCALED + TURNING, stage.by, stage.extent, shapes, parts=parts, mirror=1)


def _arm(found: PalletisingArm, options: Options) -> bytes:
    stage, plan = arm_shapes.Stage.of(found), Plan.of(found)
    still = stage.moving(np.zeros(1), np.zeros(1))
    return _body(
        found, SCALED + STANDING, stage.by, stage.extent, "\n".join(stage.ground()),
        arm="\n".join(stage.parts(tag, still)),
        poses=[_pose(stage, one) for one in found.poses],
        plan={"extent": plan.extent, "shapes": "\n".join(plan.shapes(tag))},
    )  # fmt: skip


def _pose(stage: arm_shapes.Stage, pose: ArmPose) -> dict[str, Any]:
    """Positions of the parts for each solution of a pose."""
    ways = pose.solutions
    upper, fore = (
        DEGREE * np.array([getattr(one, name) for one in ways])
        for name in ("upper_arm_deg", "forearm_deg")
    )
    parts = stage.moving(upper, fore) if ways else []
    place = stage.by * np.array([pose.x_mm, pose.y_mm, pose.z_mm])
    return {
        "target": _rounded([np.hypot(*place[:2]), place[2]]),
        "plan_target": _rounded(place[:2]),
        "solutions": [
            {"mirror": -1 if one.base == "over" else 1, "base_deg": one.base_deg,
             "parts": [{"name": part.name, "kind": part.kind, "at": _rounded(part.values[k])}
                       for part in parts]}
            for k, one in enumerate(ways)
        ],
    }  # fmt: skip


def _rounded(values: Sequence[float] | np.ndarray) -> list[float]:
    return [round(float(value), DECIMALS) + 0.0 for value in values]


def _body(
    found: SixBarShaper | PalletisingArm, frame: str, scale: float, extent: Box, shapes: str,
    **more: Any,
) -> bytes:  # fmt: skip
    body = {
        "kind": "animation",
        "linkage": {"id": found.id, "name": found.name, "status": found.status},
        "frame": frame,
        "scale": scale,
        "extent": list(extent),
        "shapes": shapes,
        **more,
    }
    text = json.dumps(body, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.encode() + b"\n"


SHAPER = LinkageFile(
    "animation.json", "Shapes and positions of its links over a turn", "application/json", ".json",
    untold(_shaper), Options, "For pages that show the machine their own way.", usual=False,
)  # fmt: skip
ARM = LinkageFile(
    "animation.json", "Shapes and positions of its links in every solution", "application/json",
    ".json", untold(_arm), Options, "For pages that show the machine their own way.", usual=False,
)  # fmt: skip
