"""Tables of a palletising arm: the border of its workspace, and its poses."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence

from synthesis.exporters.exporter import untold
from synthesis.exporters.options import Options
from synthesis.machines.linkages.arm import PalletisingArm
from synthesis.machines.linkages.files.linkage_file import LinkageFile

MEDIA = "text/csv; charset=utf-8; header=present"
BORDER = ("region", "elbow", "keeps", "centre_r_mm", "centre_z_mm", "radius_mm", "start_deg",
          "sweep_deg", "from_r_mm", "from_z_mm", "to_r_mm", "to_z_mm")  # fmt: skip
POSES = ("pose", "name", "x_mm", "y_mm", "z_mm", "yaw_deg", "base", "elbow", "base_deg",
         "upper_arm_deg", "forearm_deg", "tool_deg", "within_limits", "in_line",
         "torque_upper_nm", "torque_forearm_nm")  # fmt: skip


def _written(header: Sequence[str], rows: Iterable[Sequence[object]]) -> bytes:
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(header)
    table.writerows(rows)
    return text.getvalue().encode()


def _border(found: PalletisingArm, options: Options) -> bytes:
    return _written(
        BORDER,
        (
            (number, region.elbow, arc.keeps, *arc.centre_mm, arc.radius_mm, arc.start_deg,
             arc.sweep_deg, *arc.from_mm, *arc.to_mm)
            for number, region in enumerate(found.regions)
            for arc in region.border
        ),
    )  # fmt: skip


def _poses(found: PalletisingArm, options: Options) -> bytes:
    return _written(
        POSES,
        (
            (number, pose.name, pose.x_mm, pose.y_mm, pose.z_mm, pose.yaw_deg, one.base, one.elbow,
             one.base_deg, one.upper_arm_deg, one.forearm_deg, one.tool_deg, int(not one.beyond),
             one.in_line, one.torque_upper_nm, one.torque_forearm_nm)
            for number, pose in enumerate(found.poses)
            for one in pose.solutions
        ),
    )  # fmt: skip


WORKSPACE = LinkageFile(
    "workspace.csv",
    "Border of the workspace",
    MEDIA,
    ".csv",
    untold(_border),
    Options,
    "A row for each arc, in order, in the plane of radius r and level z.",
)
SOLUTIONS = LinkageFile(
    "poses.csv",
    "Table of the poses",
    MEDIA,
    ".csv",
    untold(_poses),
    Options,
    "A row for each posture that reaches a pose.",
)
