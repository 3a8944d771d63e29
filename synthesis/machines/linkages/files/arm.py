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

from synthesis.exporters.animations import scene as animations
from synthesis.exporters.animations.scene import EDGE, TURN_S, Scene, tag
from synthesis.exporters.diagrams.plot import curve_plot
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.canvas import two_lines
from synthesis.exporters.figures import parts
from synthesis.exporters.figures.machine import Moving, Tag, moving_group
from synthesis.exporters.figures.parts import Box, place
from synthesis.exporters.options import Options, PictureOptions
from synthesis.machines.linkages.arm import PalletisingArm, geometry
from synthesis.machines.linkages.arm.geometry import RIGHT_ANGLE, Arc, Arm, Corner, Span
from synthesis.machines.linkages.arm.report import ArmPose
from synthesis.machines.linkages.files import linkage_file as links
from synthesis.machines.linkages.files.linkage_file import CSV, SVG, LinkageFile, shifted
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
    """The arm as drawn from the side."""

    arm: Arm  # scaled
    by: float  # so many times
    u: float  # unit of shapes
    extent: Box
    ground: list[str]  # floor, axis 1, column, workspace, arcs on which the arms are in line

    @classmethod
    def of(cls, answer: PalletisingArm) -> Stage:
        """The stage for an answer."""
        given, limits = answer.spec.arm, answer.spec.limits
        by = parts.display_scale(given.upper + given.fore)
        arm = Arm(*(by * each for each in vars(given).values()))
        reached = geometry.regions(arm, limits)
        points = [arc.point(share) for region in reached for arc in region.border
                  for share in np.linspace(0.0, 1.0, 33).tolist()]  # fmt: skip
        points += [complex(-0.1 * arm.upper, 0.0), complex(arm.shoulder, arm.height)]
        u, extent = links.unit_and_extent(np.array(points), 6.0)
        (left, bottom, right, top), half = extent, 3.0 * u
        column = np.array([
            [-half, 0.0], [-half, 0.85 * arm.height], [arm.shoulder - half, arm.height],
            [arm.shoulder + half, arm.height], [half, 0.0],
        ])  # fmt: skip
        singular = (geometry.tool_arc(arm, *ends) for ends in limits.singular_segments())
        ground = [
            *(svg.path("outline body", f"{_arc_path(one.border)}Z") for one in reached),
            *(svg.path("line limit", _arc_path([arc])) for arc in singular),
            *links.hatched(left + 2.0 * u, right - 2.0 * u, 0.0, u),
            svg.line("line centre", 0.0, bottom, 0.0, top),
            svg.path("outline rest", svg.steps(column[:, 0], column[:, 1], closed=True)),
        ]
        return cls(arm, by, u, extent, ground)

    def moving(self, upper: Array, fore: Array) -> list[Moving]:
        """The parts that move, along arm angles (n,) [rad]."""
        arm, first, second = self.arm, RIGHT_ANGLE - upper, -fore
        elbow = complex(arm.shoulder, arm.height) + arm.upper * np.exp(1j * first)
        wrist = elbow + arm.fore * np.exp(1j * second)
        return links.moving_parts(
            {"upper": first, "rod": first, "elbow": elbow, "fore": second, "fore-rod": second,
             "wrist": wrist}
        )  # fmt: skip

    def parts(self, tag: Tag, moving: Sequence[Moving]) -> list[str]:
        """The arm's parts in their first positions."""
        arm, u = self.arm, self.u
        beside = ROD * arm.upper

        def group(name: str, body: Sequence[str]) -> list[str]:
            return moving_group(name, tag, moving, body)

        rod, fore_rod = (
            group(name, [svg.line("line axis", 0.0, 0.0, length, 0.0)])
            for name, length in (("rod", arm.upper), ("fore-rod", arm.fore))
        )
        plate = svg.path("outline rest", f"M0 0L{svg.num(-beside)} 0L0 {svg.num(beside)}Z")
        hand = svg.path("line outline", f"M0 {svg.num(beside)}L0 0H{svg.num(arm.wrist)}")
        tool = svg.line("outline", arm.wrist, 0.0, arm.wrist, -arm.tool)
        mark = svg.circle("mark", arm.wrist, -arm.tool, 0.9 * u)
        return [
            *shifted(arm.shoulder - beside, arm.height, rod),
            *shifted(arm.shoulder, arm.height, group("upper", links.bar(arm.upper, 2.0 * u))),
            *group("elbow", [plate, *group("fore", links.bar(arm.fore, 1.6 * u)),
                             *shifted(0.0, beside, fore_rod)]),
            *group("wrist", [hand, tool, svg.circle(links.PIN, 0.0, 0.0, u), mark]),
        ]  # fmt: skip


def _arc_path(arcs: Sequence[Arc]) -> str:
    """A chain of arcs as a path."""
    steps = f"M{place(arcs[0].point(0.0))}"
    for arc in arcs:
        radius = svg.num(arc.radius)
        flags = f"{int(abs(arc.sweep) > math.pi)} {int(arc.sweep > 0.0)}"
        steps += f"A{radius} {radius} 0 {flags} {place(arc.point(1.0))}"
    return steps


def plan_view(answer: PalletisingArm, by: float) -> tuple[Box, list[str]]:
    """The workspace from above with the base as a moving part: bounding box and elements.

    The tool reaches an annular sector in front of the base, and one over it, turned by 180°.
    """
    radius, base = by * answer.reach_mm, answer.spec.limits.base
    nearest = by * min(region.r_min.value_mm for region in answer.regions)
    farthest = by * max(region.r_max.value_mm for region in answer.regions)
    back = (base[0] + math.pi, base[1] + math.pi)
    sectors = [_ring((max(nearest, 0.0), farthest), base)] if farthest > 0.0 else []
    sectors += [_ring((max(-farthest, 0.0), -nearest), back)] if nearest < 0.0 else []
    u = 2.0 * radius / links.ACROSS
    half = radius + 4.0 * u
    return (-half, -half, half, half), [
        *(svg.path("outline body", sector) for sector in sectors),
        svg.line("line centre", -half, 0.0, half, 0.0),
        svg.line("line centre", 0.0, -half, 0.0, half),
        f"<g {tag('base')}>",
        *links.bar(radius / 3.0, 2.0 * u),
        "</g>",
    ]


def _ring(radii: Span, angles: Span) -> str:
    """An annular sector, or the whole ring, as a path of arcs of at most a third of a turn."""
    turn = np.linspace(angles[0], min(angles[1], angles[0] + FULL_TURN), 4)
    sides = []
    for radius, stops, sweep in ((radii[1], turn, 1), (radii[0], turn[::-1], 0)):
        r, places = svg.num(radius), map(place, (radius * np.exp(1j * stops)).tolist())
        sides.append(f"A{r} {r} 0 0 {sweep} ".join(places))
    whole = angles[1] - angles[0] >= FULL_TURN
    return f"M{'ZM'.join(sides) if whole else 'L'.join(sides)}Z"


def _table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> bytes:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([header, *rows])
    return text.getvalue().encode()


def _border(answer: PalletisingArm, options: Options) -> bytes:
    return _table(
        BORDER,
        (
            (number, region.elbow, arc.keeps, *arc.centre_mm, arc.radius_mm, arc.start_deg,
             arc.sweep_deg, *arc.from_mm, *arc.to_mm)
            for number, region in enumerate(answer.regions)
            for arc in region.border
        ),
    )  # fmt: skip


def _poses(answer: PalletisingArm, options: Options) -> bytes:
    rows = (
        {"pose": number, "within_limits": int(not one.beyond), **vars(pose), **vars(one)}
        for number, pose in enumerate(answer.poses)
        for one in pose.solutions
    )
    return _table(POSES, ([row[name] for name in POSES] for row in rows))


def _about(answer: PalletisingArm) -> str:
    area = sum(region.area_mm2 for region in answer.regions) * 1e-6
    reached = sum(pose.reachable for pose in answer.poses)
    poses = f" · {reached} of {len(answer.poses)} poses" if answer.poses else ""
    reach = svg.figure(answer.reach_mm, 6)
    return f"reach {reach} mm · area {svg.figure(area)} m²{poses} · {answer.id[:8]}"


def _reachable_angles(answer: PalletisingArm) -> list[Corner]:
    """Arm angles of every reachable pose [rad]."""
    best = [pose.solutions[0] for pose in answer.poses if pose.reachable]
    return [(one.upper_arm_deg * DEGREE, one.forearm_deg * DEGREE) for one in best]


def _workspace(answer: PalletisingArm, options: PictureOptions) -> bytes:
    stage, name = Stage.of(answer), answer.name.strip() or TITLE
    size = (SHEET[0] - 2.0 * EDGE, SHEET[1] - TOP - BOTTOM)
    arms = [
        shape
        for upper, fore in _reachable_angles(answer)
        for shape in stage.parts(lambda _: "", stage.moving(np.array([upper]), np.array([fore])))
    ]
    body = [
        *two_lines(name, _about(answer), EDGE, SHEET[0] - EDGE, 1.0),
        *shifted(EDGE, TOP, parts.place_in_panel([*stage.ground, *arms], stage.extent, size)),
        svg.text("tick", EDGE, SHEET[1] - 4.0, "Seen from the side, in the plane through axis 1; "
                 "the tool's point reaches what is shaded."),
    ]  # fmt: skip
    title, text = f"Workspace of {name}", "The arm in its poses, and where its tool gets to."
    rules = parts.line_style(stage.extent, size)
    return svg.document(*SHEET, 1.0, title, text, body, theme=options.theme, rules=rules)


def _pose_path(answer: PalletisingArm, share: Array) -> tuple[Array, Array]:
    """Arm angles at shares of a closed path through the poses [rad], as long from each to the next.

    Along the limits where there are fewer than two poses. Joints move by the cycloidal law.
    """
    stops = _reachable_angles(answer)
    if len(stops) < 2:
        stops = [
            arc.first for arc in geometry.regions(answer.spec.arm, answer.spec.limits)[0].border
        ]
    at = np.array([*stops, stops[0]])
    place = share * (len(at) - 1)
    k = np.minimum(place.astype(int), len(at) - 2)
    x = place - k
    progress = (x - np.sin(2.0 * math.pi * x) / (2.0 * math.pi))[:, None]
    upper, fore = (at[k] + progress * (at[k + 1] - at[k])).T
    return upper, fore


def _scene(answer: PalletisingArm, count: int) -> Scene:
    stage, share = Stage.of(answer), np.linspace(0.0, 1.0, count + 1)
    upper, fore = _pose_path(answer, share)
    tool = answer.spec.arm.tool_point(upper, fore)
    torques = geometry.holding_torques(answer.spec.static_moments, upper, fore)
    moving = stage.moving(upper, fore)
    drawing = links.Drawing(
        stage.by, stage.extent, moving, lambda tag: [*stage.ground, *stage.parts(tag, moving)]
    )
    return links.linkage_scene(
        answer, TITLE, _about(answer), drawing,
        [curve_plot(f"Torque at axis {axis}", "N·m", 360.0 * share, values)
         for axis, values in zip((2, 3), torques, strict=True)],
        (
            ("r", "Radius r", "mm", tool.real),
            ("z", "Level z", "mm", tool.imag),
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


def _data(answer: PalletisingArm, options: Options) -> bytes:
    stage = Stage.of(answer)
    plan_extent, plan = plan_view(answer, stage.by)
    return links.scene_json(
        answer, FRAME, stage.by, stage.extent, shapes="\n".join(stage.ground),
        arm="\n".join(stage.parts(tag, stage.moving(np.zeros(1), np.zeros(1)))),
        poses=[_pose_data(stage, pose) for pose in answer.poses],
        plan={"extent": plan_extent, "shapes": "\n".join(plan)},
    )  # fmt: skip


def _pose_data(stage: Stage, pose: ArmPose) -> dict[str, Any]:
    """Positions of the parts for each solution of a pose."""
    angles = np.array([(one.upper_arm_deg, one.forearm_deg) for one in pose.solutions])
    parts = stage.moving(*(DEGREE * angles.reshape(-1, 2).T))
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
    return [round(float(value), links.DECIMALS) + 0.0 for value in values]


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
