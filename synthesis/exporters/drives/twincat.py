"""Beckhoff TwinCAT: a motion function, an array of MC_MotionFunctionPoint as structured text.

Between two points runs a polynomial of degree 5 with the velocity and acceleration that both have
(POLYNOM5_MM, motion to motion), as derivatives by the master's position.
"""

from __future__ import annotations

from synthesis.design.design import Design
from synthesis.exporters.drives.fidelity import drive_told
from synthesis.exporters.drives.table import DriveOptions, drive_table, each_point, headline
from synthesis.exporters.exporter import Exporter

POINT = (
    "        (PointIndex := {n}, FunctionType := MOTIONFUNCTYPE_POLYNOM5_MM, "
    "PointType := MOTIONPOINTTYPE_MOTION, RelIndexNextPoint := 1, "
    "MasterPos := {x!r}, SlavePos := {y!r}, SlaveVelo := {v!r}, SlaveAcc := {a!r}, "
    "SlaveJerk := 0.0)"
)


def _motion(design: Design, options: DriveOptions) -> bytes:
    table = drive_table(design, options)
    points = each_point(table, lambda k, x, y, v, a: POINT.format(n=k + 1, x=x, y=y, v=v, a=a))
    text = (
        f"(* {headline(design, table, options)} *)\n"
        "VAR_GLOBAL\n"
        f"    CamPoints : ARRAY[1..{len(table.master)}] OF MC_MotionFunctionPoint := [\n"
        f"{points}\n    ];\nEND_VAR\n"
    )
    return text.encode("ascii")


MOTION = Exporter(
    "twincat.st", "Electronic cam: TwinCAT motion function", "text/plain; charset=us-ascii",
    ".twincat.st", _motion, DriveOptions,
    "Beckhoff TwinCAT NC Camming: paste into a global variable list, then MC_CamTableSelect.",
    by_default=False,
    measure=drive_told,
)  # fmt: skip
