"""Kollmorgen KAS: a cam profile as CSV, which its import turns into splines.

The import divides master and slave by their largest values and multiplies them by the scales that
are set in the profile: set those to the turn and to the stroke.
"""

from __future__ import annotations

from synthesis.design.design import Design
from synthesis.exporters.drives.fidelity import drive_told
from synthesis.exporters.drives.table import DriveOptions, drive_rows, drive_table
from synthesis.exporters.exporter import Exporter


def _motion(design: Design, options: DriveOptions) -> bytes:
    rows = drive_rows(drive_table(design, options), options, "{master};{slave};SPLINE\n")
    return b"CYCLIC;YES;\nTABLE_BEGIN;;\n" + rows + b"TABLE_END;;\n"


MOTION = Exporter(
    "kollmorgen.csv", "Electronic cam: Kollmorgen KAS", "text/csv; charset=us-ascii; header=absent",
    ".kollmorgen.csv", _motion, DriveOptions,
    "Kollmorgen KAS IDE, Import Cam Profile: set its scales to the turn and to the stroke.",
    by_default=False,
    measure=drive_told,
)  # fmt: skip
