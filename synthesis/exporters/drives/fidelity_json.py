"""What drives make of a table's rows, as JSON, with the options of these files."""

from __future__ import annotations

from synthesis.design.design import Design
from synthesis.exporters.drives.fidelity import drive_fidelity
from synthesis.exporters.drives.table import DriveOptions, drive_table
from synthesis.exporters.exporter import Exporter
from synthesis.exporters.fidelity.fidelity_json import fidelity_file


def _motion(design: Design, options: DriveOptions) -> bytes:
    found = drive_fidelity(design, drive_table(design, options), options)
    return fidelity_file(design, options, found)


MOTION = Exporter(
    "fidelity.json", "What drives make of a table's rows", "application/json", ".fidelity.json",
    _motion, DriveOptions,
    "Before a table goes to a drive: what linear, cubic and quintic interpolation of its rounded "
    "rows do to displacement, velocity and acceleration.",
    by_default=False,
)  # fmt: skip
