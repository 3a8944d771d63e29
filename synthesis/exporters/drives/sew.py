"""SEW MOVI-C: a curve point table. The number of pairs, then the pairs, parted by semicolons."""

from __future__ import annotations

from synthesis.design.design import Design
from synthesis.exporters.drives.fidelity import drive_told
from synthesis.exporters.drives.table import DriveOptions, drive_rows, drive_table
from synthesis.exporters.exporter import Exporter


def _motion(design: Design, options: DriveOptions) -> bytes:
    table = drive_table(design, options)
    rows = drive_rows(table, options, "{master};{slave}\n")
    return f"{len(table.master)}\n".encode() + rows


MOTION = Exporter(
    "sew.txt", "Electronic cam: SEW curve point table", "text/plain; charset=us-ascii", ".sew.txt",
    _motion, DriveOptions, "SEW MOVI-C controllers, curve point table.", by_default=False,
    measure=drive_told,
)  # fmt: skip
