"""Plain table of the motion: the CSV's columns in its order, separated by spaces, no header.

For programs that read bare numbers (`numpy.loadtxt`, a spreadsheet's text import): cam angle [deg],
s, v, a, j at the given speed [mm or deg, s], s', s'', s''' [mm or deg, rad], side of a jump.
"""

from __future__ import annotations

from synthesis.design.design import Design
from synthesis.exporters.exporter import Exporter
from synthesis.exporters.options import MotionOptions
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.columns import motion_columns


def _motion(design: Design, options: MotionOptions) -> bytes:
    columns = [column.values.tolist() for column in motion_columns(Cam.of(design), options)]
    rows = zip(*columns, strict=True)
    return "".join(" ".join(map(repr, row)) + "\n" for row in rows).encode("ascii")


_TITLE = "Table, space separated, no header: the columns of csv in their order"
MOTION = Exporter("txt", _TITLE, "text/plain; charset=us-ascii", ".txt", _motion, MotionOptions)
