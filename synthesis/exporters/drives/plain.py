"""Pairs of master and slave position, parted by a semicolon; no header.

What most drives' tools import, and what spreadsheets open.
"""

from __future__ import annotations

from synthesis.design.design import Design
from synthesis.exporters.drives.fidelity import drive_told
from synthesis.exporters.drives.table import DriveOptions, drive_rows, drive_table
from synthesis.exporters.exporter import Exporter


def _motion(design: Design, options: DriveOptions) -> bytes:
    return drive_rows(drive_table(design, options), options, "{master};{slave}\n")


MOTION = Exporter(
    "cam.csv", "Electronic cam: master;slave", "text/csv; charset=us-ascii; header=absent",
    ".cam.csv", _motion, DriveOptions,
    "Any drive whose tool imports pairs of positions.", by_default=False,
    measure=drive_told,
)  # fmt: skip
