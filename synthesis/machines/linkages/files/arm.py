"""Files of a palletising arm: tables, the workspace from the side, animations through the poses.

Shapes: lengths in mm, or in a power of ten of them; y is the level z, x the radius r.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from synthesis.exporters.animations import formats as animations
from synthesis.exporters.animations.animation_page import tag
from synthesis.exporters.animations.scene import EDGE, TURN_S, Scene
from synthesis.exporters.diagrams.plot import curve_plot
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.heading import two_lines
from synthesis.exporters.figures.machine import Moving, Tag, moving_group
from synthesis.exporters.figures.parts import Box, display_scale, place_in_panel
from synthesis.exporters.options import Options, PictureOptions
from synthesis.machines.linkages.arm import PalletisingArm
from synthesis.machines.linkages.arm.geometry import Arm, holding_torques
from synthesis.machines.linkages.arm.report import ArmPose
from synthesis.machines.linkages.arm.workspace import (
    Arc,
    Corner,
    Region,
    Span,
    regions,
    singular_segments,
    tool_arc,
)
from synthesis.machines.linkages.files import links
from synthesis.machines.linkages.files.linkage_file import (
    CSV,
    DECIMALS,
    SVG,
    LinkageFile,
    line_rules,
    linkage_scene,
    scene_json,
)
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE, FULL_TURN

ROD = 0.11  # of the upper arm: distance of the parallelogram's rod
TITLE = "Palletising arm"
SHEET = (190.0, 176.0)  # mm
TOP, BOTTOM = 20.0, 16.0  # mm, above and below the workspace
FRAME = (
    "arm: the elements of the arm. poses: where its parts are for each solution, as a turn's angle "
    "[deg] or x and y of a shift; mirror: -1 where the base is turned away, and the arm is to be "
    "mirrored at axis 1; target: the pose's r and z. plan: seen from above, x to the right, y "
    "upwards; its part base points to where the base is turned, by base_deg; its target is x, y."
)
BORDER = ("region", "elbow", "keeps", "centre_r_mm", "centre_z_mm", "radius_mm", "start_deg",
          "sweep_deg", "from_r_mm", "from_z_mm", "to_r_mm", "to_z_mm")  # fmt: skip
POSES = ("pose", "name", "x_mm", "y_mm", "z_mm", "yaw_deg", "base", "elbow", "base_deg",
         "upper_arm_deg", "forearm_deg", "tool_deg", "within_limits", "in_line",
         "torque_upper_nm", "torque_forearm_nm")  # fmt: skip


@dataclass(frozen=True, eq=False)
class Stage:
    """The arm as drawn from the side.

    Attributes:
        arm: scaled for drawing. regions: its workspace, in the same scale.
        singular: where the arms are in line within the limits. u: unit of shapes.
        extent: left, bottom, right and top. by: scale factor.
    """

    arm: Arm
    regions: tuple[Region, ...]
    singular: tuple[Arc, ...]
    u: float
    extent: Box
    by: float

    @classmethod
    def of(cls, found: PalletisingArm) -> Stage:
        """The stage for an answer."""
        given = found.spec.arm
        by = display_scale(given.upper + given.fore)
        arm = Arm(*(by * each for each in vars(given).values()))
        reached = tuple(regions(arm, found.spec.limits))
        singular = tuple(tool_arc(arm, *ends) for ends in singular_segments(found.spec.limits))
        points = [arc.point(s) for one in reached for arc in one.border
                  for s in np.linspace(0.0, 1.0, 33).tolist()]  # fmt: skip
        points += [(-0.1 * arm.upper, 0.0), (arm.shoulder, arm.height)]
        return cls(arm, reached, singular, *links.unit_and_extent(points, 6.0), by)

    def ground(self) -> list[str]:
        """Floor, axis 1, column, workspace, and the singular arcs."""
        left, bottom, right, top = self.extent
        u, arm = self.u, self.arm
        half = 3.0 * u
        column = f"M{svg.num(-half)} 0L{svg.num(-half)} {svg.num(0.85 * arm.height)}L" + "L".join(
            f"{svg.num(arm.shoulder + k * half)} {svg.num(arm.height)}" for k in (-1.0, 1.0)
        )
        return [
            *(svg.path("outline body", f"{_arc_path(one.border)}Z") for one in self.regions),
            *(svg.path("line limit", _arc_path([arc])) for arc in self.singular),
            *links.hatched(left + 2.0 * u, right - 2.0 * u, 0.0, u),
            svg.line("line centre", 0.0, bottom, 0.0, top),
            svg.path("outline rest", f"{column}L{svg.num(half)} 0Z"),
        ]

    def moving(self, upper: Array, fore: Array) -> list[Moving]:
        """The parts that move, along arm angles (n,) [rad]."""
        arm = self.arm
        elbow = np.stack([arm.shoulder + arm.upper * np.sin(upper),
                          arm.height + arm.upper * np.cos(upper)], axis=1)  # fmt: skip
        wrist = elbow + arm.fore * np.stack([np.cos(fore), -np.sin(fore)], axis=1)
        first, second = 90.0 - upper[:, None] / DEGREE, -fore[:, None] / DEGREE
        return [
            Moving("upper", "turn", first), Moving("rod", "turn", first),
            Moving("elbow", "shift", elbow), Moving("fore", "turn", second),
            Moving("fore-rod", "turn", second), Moving("wrist", "shift", wrist),
        ]  # fmt: skip

    def parts(self, tag: Tag, moving: Sequence[Moving]) -> list[str]:
        """The arm's parts in their first positions."""
        arm, u = self.arm, self.u
        beside = ROD * arm.upper

        def at(x: float, y: float, body: Sequence[str]) -> list[str]:
            return [f'<g transform="translate({svg.num(x)} {svg.num(y)})">', *body, "</g>"]

        def rod(name: str, length: float) -> list[str]:
            return moving_group(name, tag, moving, [svg.line("line axis", 0.0, 0.0, length, 0.0)])

        upper = moving_group("upper", tag, moving, links.bar(arm.upper, 2.0 * u))
        fore = moving_group("fore", tag, moving, links.bar(arm.fore, 1.6 * u))
        plate = svg.path("outline rest", f"M0 0L{svg.num(-beside)} 0L0 {svg.num(beside)}Z")
        hand = svg.path("line outline", f"M0 {svg.num(beside)}L0 0H{svg.num(arm.wrist)}")
        tool = svg.line("outline", arm.wrist, 0.0, arm.wrist, -arm.tool)
        return [
            *at(arm.shoulder - beside, arm.height, rod("rod", arm.upper)),
            *at(arm.shoulder, arm.height, upper),
            *moving_group("elbow", tag, moving, [
                plate, *fore, *at(0.0, beside, rod("fore-rod", arm.fore))]),
            *moving_group("wrist", tag, moving, [
                hand, tool, links.pin(0.0, 0.0, u),
                svg.circle("mark", arm.wrist, -arm.tool, 0.9 * u)]),
        ]  # fmt: skip


def _arc_path(arcs: Sequence[Arc]) -> str:
    """A chain of arcs as a path."""
    x, y = arcs[0].point(0.0)
    steps = [f"M{svg.num(x)} {svg.num(y)}"]
    for arc in arcs:
        (x, y), radius = arc.point(1.0), svg.num(arc.radius)
        flags = f"{int(abs(arc.sweep) > math.pi)} {int(arc.sweep > 0.0)}"
        steps.append(f"A{radius} {radius} 0 {flags} {svg.num(x)} {svg.num(y)}")
    return "".join(steps)


def plan_view(found: PalletisingArm, by: float) -> tuple[Box, list[str]]:
    """The workspace from above with the base as a moving part, in the scale of the side view.

    The tool reaches an annular sector in front of the base, and one over it, turned by 180°.

    Returns:
        bounding box for all base angles, and the elements.
    """
    radius, base = by * found.reach_mm, found.spec.base_deg
    nearest = by * min(region.r_min.value_mm for region in found.regions)
    farthest = by * max(region.r_max.value_mm for region in found.regions)
    low, high = base.min * DEGREE, base.max * DEGREE
    sectors = (
        ((max(nearest, 0.0), farthest), (low, high)),
        ((max(-farthest, 0.0), -nearest), (low + math.pi, high + math.pi)),
    )
    u = 2.0 * radius / links.ACROSS
    half = radius + 4.0 * u
    return (-half, -half, half, half), [
        *(svg.path("outline body", _ring(*sector)) for sector in sectors if sector[0][1] > 0.0),
        svg.line("line centre", -half, 0.0, half, 0.0),
        svg.line("line centre", 0.0, -half, 0.0, half),
        f"<g {tag('base')}>",
        *links.bar(radius / 3.0, 2.0 * u),
        "</g>",
    ]


def _ring(radii: Span, angles: Span) -> str:
    """An annular sector, or the whole ring, as a path."""
    low, high = angles
    if high - low < FULL_TURN:
        out, back = _arc(radii[1], low, high), _arc(radii[0], high, low)
        return f"M{out[0]}{out[1]}L{back[0]}{back[1]}Z"
    return "".join(f"M{start}{steps}Z" for start, steps in
                   (_arc(radius, 0.0, FULL_TURN) for radius in radii if radius > 0.0))  # fmt: skip


def _arc(radius: float, start: float, end: float) -> tuple[str, str]:
    """Start of an arc about axis 1, and three SVG arcs, each less than a half turn."""

    def point(angle: float) -> str:
        return f"{svg.num(radius * math.cos(angle))} {svg.num(radius * math.sin(angle))}"

    r, sweep = svg.num(radius), int(end > start)
    stops = [start + (end - start) * k / 3.0 for k in (1, 2, 3)]
    return point(start), "".join(f"A{r} {r} 0 0 {sweep} {point(stop)}" for stop in stops)


def _table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> bytes:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([header, *rows])
    return text.getvalue().encode()


def _border(found: PalletisingArm, options: Options) -> bytes:
    return _table(
        BORDER,
        (
            (number, region.elbow, arc.keeps, *arc.centre_mm, arc.radius_mm, arc.start_deg,
             arc.sweep_deg, *arc.from_mm, *arc.to_mm)
            for number, region in enumerate(found.regions)
            for arc in region.border
        ),
    )  # fmt: skip


def _poses(found: PalletisingArm, options: Options) -> bytes:
    return _table(
        POSES,
        (
            (number, pose.name, pose.x_mm, pose.y_mm, pose.z_mm, pose.yaw_deg, one.base, one.elbow,
             one.base_deg, one.upper_arm_deg, one.forearm_deg, one.tool_deg, int(not one.beyond),
             one.in_line, one.torque_upper_nm, one.torque_forearm_nm)
            for number, pose in enumerate(found.poses)
            for one in pose.solutions
        ),
    )  # fmt: skip


def _about(found: PalletisingArm) -> str:
    area = sum(region.area_mm2 for region in found.regions) * 1e-6
    reached = sum(pose.reachable for pose in found.poses)
    poses = f" · {reached} of {len(found.poses)} poses" if found.poses else ""
    reach = svg.figure(found.reach_mm, 6)
    return f"reach {reach} mm · area {svg.figure(area)} m²{poses} · {found.id[:8]}"


def _reachable_angles(found: PalletisingArm) -> list[Corner]:
    """Arm angles of every reachable pose [rad]."""
    best = [pose.solutions[0] for pose in found.poses if pose.reachable]
    return [(one.upper_arm_deg * DEGREE, one.forearm_deg * DEGREE) for one in best]


def _workspace(found: PalletisingArm, options: PictureOptions) -> bytes:
    stage, name = Stage.of(found), found.name.strip() or TITLE
    size = (SHEET[0] - 2.0 * EDGE, SHEET[1] - TOP - BOTTOM)
    arms = [
        shape
        for upper, fore in _reachable_angles(found)
        for shape in stage.parts(lambda _: "", stage.moving(np.array([upper]), np.array([fore])))
    ]
    body = [
        *two_lines(name, _about(found), EDGE, SHEET[0] - EDGE, 1.0),
        f'<g transform="translate({svg.num(EDGE)} {svg.num(TOP)})">',
        *place_in_panel([*stage.ground(), *arms], stage.extent, size),
        "</g>",
        svg.text("tick", EDGE, SHEET[1] - 4.0, "Seen from the side, in the plane through axis 1; "
                 "the tool's point reaches what is shaded."),
    ]  # fmt: skip
    title, text = f"Workspace of {name}", "The arm in its poses, and where its tool gets to."
    rules = line_rules(stage.extent, size)
    return svg.document(*SHEET, 1.0, title, text, body, theme=options.theme, rules=rules)


def _pose_path(found: PalletisingArm, share: Array) -> tuple[Array, Array]:
    """Arm angles at shares of a closed path through the poses [rad], as long from each to the next.

    Along the limits where there are fewer than two poses. Joints move by the cycloidal law.
    """
    stops = _reachable_angles(found)
    if len(stops) < 2:
        stops = list(regions(found.spec.arm, found.spec.limits)[0].corners)
    at = np.array([*stops, stops[0]])
    place = share * (len(at) - 1)
    k = np.minimum(place.astype(int), len(at) - 2)
    x = place - k
    progress = (x - np.sin(2.0 * math.pi * x) / (2.0 * math.pi))[:, None]
    upper, fore = (at[k] + progress * (at[k + 1] - at[k])).T
    return upper, fore


def _scene(found: PalletisingArm, count: int) -> Scene:
    stage, arm, share = Stage.of(found), found.spec.arm, np.linspace(0.0, 1.0, count + 1)
    upper, fore = _pose_path(found, share)
    torques = holding_torques(found.spec.static_moments, upper, fore)
    moving = stage.moving(upper, fore)
    return linkage_scene(
        found, TITLE, _about(found),
        (stage.extent, moving, lambda tag: [*stage.ground(), *stage.parts(tag, moving)]),
        [curve_plot(f"Torque at axis {axis}", "N·m", 360.0 * share, values)
         for axis, values in zip((2, 3), torques, strict=True)],
        (
            ("r", "Radius r", "mm", arm.radius(upper, fore)),
            ("z", "Level z", "mm", arm.level(upper, fore)),
            ("t2", "Upper arm", "deg", upper / DEGREE),
            ("t3", "Forearm", "deg", fore / DEGREE),
            ("m2", "Torque at axis 2", "N·m", torques[0]),
            ("m3", "Torque at axis 3", "N·m", torques[1]),
        ),
        shaft="Path through the poses",
        titles=("The arm from the side", "Torques that hold it"),
        described="The arm goes through its poses, and points run on the diagrams of its torques.",
        footer=f"The path is shown in {TURN_S:g} s. Torques are static.",
    )  # fmt: skip


def _data(found: PalletisingArm, options: Options) -> bytes:
    stage = Stage.of(found)
    plan_extent, plan = plan_view(found, stage.by)
    return scene_json(
        found, FRAME, stage.by, stage.extent, shapes="\n".join(stage.ground()),
        arm="\n".join(stage.parts(tag, stage.moving(np.zeros(1), np.zeros(1)))),
        poses=[_pose_data(stage, pose) for pose in found.poses],
        plan={"extent": plan_extent, "shapes": "\n".join(plan)},
    )  # fmt: skip


def _pose_data(stage: Stage, pose: ArmPose) -> dict[str, Any]:
    """Positions of the parts for each solution of a pose."""
    angles = [(one.upper_arm_deg, one.forearm_deg) for one in pose.solutions]
    parts = stage.moving(*(DEGREE * np.array(angles).T)) if angles else []
    x, y, z = (stage.by * each for each in (pose.x_mm, pose.y_mm, pose.z_mm))
    return {
        "target": _rounded([math.hypot(x, y), z]),
        "plan_target": _rounded([x, y]),
        "solutions": [
            {"mirror": -1 if one.base == "over" else 1, "base_deg": one.base_deg,
             "parts": [{"name": part.name, "kind": part.kind, "at": _rounded(part.values[k])}
                       for part in parts]}
            for k, one in enumerate(pose.solutions)
        ],
    }  # fmt: skip


def _rounded(values: Iterable[float]) -> list[float]:
    return [round(float(value), DECIMALS) + 0.0 for value in values]


FILES = (
    LinkageFile("workspace.csv", "Border of the workspace", CSV, ".csv", _border, Options,
                "A row for each arc, in order, in the plane of radius r and level z."),
    LinkageFile("poses.csv", "Table of the poses", CSV, ".csv", _poses, Options,
                "A row for each posture that reaches a pose."),
    LinkageFile("workspace.svg", "Workspace from the side", SVG, ".svg", _workspace,
                PictureOptions,
                "Borders are drawn as true arcs, with the arm in every reachable pose."),
    *animations.pictures(
        LinkageFile, _scene, "Animation",
        "Through the poses and back, or along the limits where there are fewer than two."
    ),
    animations.data(LinkageFile, _data, "Shapes and positions of its links in every solution"),
)  # fmt: skip
