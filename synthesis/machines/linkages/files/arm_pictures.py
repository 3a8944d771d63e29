"""Drawings of a palletising arm: workspace from the side, and animation through the poses."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from synthesis.exporters.animations.panels import DIAGRAMS, EDGE, MACHINE
from synthesis.exporters.animations.scene import TURN_S, Scene, reading
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.heading import two_lines
from synthesis.exporters.drawing.picture_options import PictureOptions
from synthesis.exporters.drawing.theme import lines
from synthesis.exporters.exporter import untold
from synthesis.exporters.figures.parts import placed, scale_in
from synthesis.machines.linkages.arm import PalletisingArm
from synthesis.machines.linkages.arm.geometry import Arm
from synthesis.machines.linkages.arm.statics import moments
from synthesis.machines.linkages.arm.workspace import regions
from synthesis.machines.linkages.files import arm_shapes as shapes
from synthesis.machines.linkages.files.diagrams import TracedDiagrams, plot
from synthesis.machines.linkages.files.linkage_file import (
    LinkageFile,
    animation_page,
    animation_svg,
)
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

TITLE = "Palletising arm"
SHEET = (190.0, 176.0)
TOP, BOTTOM = 20.0, 16.0
SHAFT = "Path through the poses"


def _about(found: PalletisingArm) -> str:
    area = sum(region.area_mm2 for region in found.regions) * 1e-6
    taken = sum(pose.reachable for pose in found.poses)
    poses = f" · {taken} of {len(found.poses)} poses" if found.poses else ""
    reach = svg.figure(found.reach_mm, 6)
    return f"reach {reach} mm · area {svg.figure(area)} m²{poses} · {found.id[:8]}"


def _workspace(found: PalletisingArm, options: PictureOptions) -> bytes:
    stage = shapes.Stage.of(found)
    room = (SHEET[0] - 2.0 * EDGE, SHEET[1] - TOP - BOTTOM)
    body = [
        *two_lines(found.name.strip() or TITLE, _about(found), EDGE, SHEET[0] - EDGE, 1.0),
        f'<g transform="translate({svg.num(EDGE)} {svg.num(TOP)})">',
        *placed([*stage.ground(), *stage.stood(reachable_angles(found))], stage.extent, room),
        "</g>",
        svg.text("tick", EDGE, SHEET[1] - 4.0, "Seen from the side, in the plane through axis 1; "
                 "the tool's point reaches what is shaded."),
    ]  # fmt: skip
    rules = "".join(lines(1.0 / scale_in(stage.extent, room), ".camwright .mechanism"))
    title = f"Workspace of {found.name.strip() or TITLE}"
    told = "The arm in its poses, and where its tool gets to."
    return svg.document(*SHEET, 1.0, title, told, body, theme=options.theme, rules=rules)


def reachable_angles(found: PalletisingArm) -> list[tuple[float, float]]:
    """Arm angles of every reachable pose [rad]."""
    best = [pose.solutions[0] for pose in found.poses if pose.reachable]
    return [(one.upper_arm_deg * DEGREE, one.forearm_deg * DEGREE) for one in best]


@dataclass(frozen=True, eq=False)
class PosePath:
    """Arm angles (n,) along a closed path, each joint with a cycloidal law from stop to stop."""

    upper: Array
    fore: Array
    share: Array

    @classmethod
    def of(cls, found: PalletisingArm, count: int) -> PosePath:
        """Through the poses, or along the limits where there are fewer than two."""
        stops = reachable_angles(found)
        if len(stops) < 2:
            stops = list(regions(found.spec.arm, found.spec.limits)[0].corners)
        at = np.array([*stops, stops[0]])
        share = np.linspace(0.0, 1.0, count + 1)
        place = share * (len(at) - 1)
        k = np.minimum(place.astype(int), len(at) - 2)
        x = place - k
        eased = (x - np.sin(2.0 * math.pi * x) / (2.0 * math.pi))[:, None]  # cycloidal
        upper, fore = (at[k] + eased * (at[k + 1] - at[k])).T
        return cls(upper, fore, share)

    @cached_property
    def degrees(self) -> Array:
        """Progress in degrees; the whole path is 360°."""
        return 360.0 * self.share


def _scene(found: PalletisingArm, count: int) -> Scene:
    stage, way = shapes.Stage.of(found), PosePath.of(found, count)
    arm: Arm = found.spec.arm
    first, second = moments(found.spec.weights)
    upper, fore = -first * np.sin(way.upper), -second * np.cos(way.fore)
    plots = (plot("Torque at axis 2", "N·m", way.degrees, upper, extremes=False),
             plot("Torque at axis 3", "N·m", way.degrees, fore, extremes=False))  # fmt: skip
    traced = TracedDiagrams(plots, SHAFT, lambda _: [])
    name = found.name.strip() or TITLE
    moving = stage.moving(way.upper, way.fore)
    told: Sequence[tuple[str, str, str, Array]] = (
        ("r", "Radius r", "mm", arm.radius(way.upper, way.fore)),
        ("z", "Level z", "mm", arm.level(way.upper, way.fore)),
        ("t2", "Upper arm", "deg", way.upper / DEGREE),
        ("t3", "Forearm", "deg", way.fore / DEGREE),
        ("m2", "Torque at axis 2", "N·m", upper),
        ("m3", "Torque at axis 3", "N·m", fore),
    )
    return Scene(
        name=name,
        about=_about(found),
        key=found.id,
        heading=two_lines(name, _about(found), EDGE, EDGE + MACHINE[0] + DIAGRAMS[0], 1.0),
        shaft=SHAFT,
        titles=("The arm from the side", "Torques that hold it"),
        described="The arm goes through its poses, and points run on the diagrams of its torques.",
        machine=lambda tag: placed(
            [*stage.ground(), *stage.parts(tag, moving)], stage.extent, MACHINE
        ),
        diagrams=traced.panel,
        moving=[part for part in (*moving, *traced.moving()) if part.moves],
        readings=[reading(key, title, unit, values, float(np.max(np.abs(values))))
                  for key, title, unit, values in told],
        decimals=4,
        rules="".join(lines(1.0 / scale_in(stage.extent, MACHINE), ".camwright .mechanism")),
        footer=f"The path is shown in {TURN_S:g} s. Torques are static.",
    )  # fmt: skip


WORKSPACE = LinkageFile(
    "workspace.svg",
    "Workspace from the side",
    "image/svg+xml",
    ".svg",
    untold(_workspace),
    PictureOptions,
    "Borders are drawn as true arcs, with the arm in every reachable pose.",
)
ANIMATION = animation_svg(
    _scene, "Through the poses and back, or along the limits where there are fewer than two."
)
PAGE = animation_page(_scene)
