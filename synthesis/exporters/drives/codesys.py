"""CODESYS SoftMotion: an XYVA cam, an array of SMC_CAMXYVA as structured text.

dV and dA are the derivatives of dY by dX; between two points runs a polynomial of degree 5.
"""

from __future__ import annotations

from synthesis.design.design import Design
from synthesis.exporters.drives.fidelity import drive_told
from synthesis.exporters.drives.table import DriveOptions, drive_table, each_point, headline
from synthesis.exporters.exporter import Exporter

XYVA = 3  # byType of a cam by points with velocity and acceleration


def _motion(design: Design, options: DriveOptions) -> bytes:
    table = drive_table(design, options)
    count, end = len(table.master), float(table.master[-1])
    points = each_point(
        table, lambda k, x, y, v, a: f"        (dX := {x!r}, dY := {y!r}, dV := {v!r}, dA := {a!r})"
    )
    text = (
        f"(* {headline(design, table, options)}\n"
        "   Before it is used: Cam.pce := ADR(CamPoints); *)\n"
        "VAR_GLOBAL\n"
        f"    Cam : MC_CAM_REF := (byType := {XYVA}, nElements := {count}, xStart := 0.0, "
        f"xEnd := {end!r});\n"
        f"    CamPoints : ARRAY[0..{count - 1}] OF SMC_CAMXYVA := [\n"
        f"{points}\n    ];\nEND_VAR\n"
    )
    return text.encode("ascii")


MOTION = Exporter(
    "codesys.st", "Electronic cam: CODESYS XYVA", "text/plain; charset=us-ascii", ".codesys.st",
    _motion, DriveOptions,
    "CODESYS SoftMotion and what is built on it: paste into a global variable list.",
    by_default=False,
    measure=drive_told,
)  # fmt: skip
