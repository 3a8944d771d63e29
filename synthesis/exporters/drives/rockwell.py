"""Rockwell Logix: the elements of a CAM array as structured text, cubic segments, for MCCP.

Its REAL holds about seven digits: that is the instruction's limit, not the file's.
"""

from __future__ import annotations

from synthesis.design.design import Design
from synthesis.exporters.drives.fidelity import drive_told
from synthesis.exporters.drives.table import DriveOptions, drive_rows, drive_table, headline
from synthesis.exporters.exporter import Exporter

CUBIC = 1


def _motion(design: Design, options: DriveOptions) -> bytes:
    table = drive_table(design, options)
    rows = drive_rows(table, options, "{master} {slave}\n").decode().split()
    text = [
        f"// {headline(design, table, options)}",
        f"// Declare Cam : CAM[{len(table.master)}]; then MCCP makes the profile of it.",
    ]
    text += [
        f"Cam[{k}].Master := {master}; Cam[{k}].Slave := {slave}; Cam[{k}].SegmentType := {CUBIC};"
        for k, (master, slave) in enumerate(zip(rows[::2], rows[1::2], strict=True))
    ]
    return ("\n".join(text) + "\n").encode("ascii")


MOTION = Exporter(
    "rockwell.st", "Electronic cam: Rockwell Logix CAM array", "text/plain; charset=us-ascii",
    ".rockwell.st", _motion, DriveOptions,
    "Rockwell Logix: a routine in structured text that fills a CAM array for MCCP.",
    by_default=False,
    measure=drive_told,
)  # fmt: skip
