"""XLSX: points on the first sheet, for Autodesk Inventor and for spreadsheets.

A1 holds the unit; below it stand X, Y and Z in the columns A, B and C, one point a row.
"""

from __future__ import annotations

import datetime
import io

import xlsxwriter

from synthesis.design.design import Design
from synthesis.exporters.exporter import Exporter
from synthesis.exporters.fidelity.told import fidelity_told
from synthesis.exporters.options import PointOptions
from synthesis.exporters.samples.cutting import chosen
from synthesis.exporters.samples.sampling import written_points

LONG_AGO = datetime.datetime(1980, 1, 1, tzinfo=datetime.UTC)  # no clock in the bytes


def _profile(design: Design, options: PointOptions) -> bytes:
    cam = chosen(design, options)
    points = written_points(cam, options).ended(options, closed=True)
    z = round(options.z_mm or 0.0, options.decimals) + 0.0
    packed = io.BytesIO()
    book = xlsxwriter.Workbook(packed, {"in_memory": True})
    book.set_properties({"created": LONG_AGO})
    sheet = book.add_worksheet("points")
    sheet.write_string(0, 0, "mm")
    for row, (x, y) in enumerate(points.tolist(), start=1):
        sheet.write_number(row, 0, x)
        sheet.write_number(row, 1, y)
        sheet.write_number(row, 2, z)
    book.close()
    return packed.getvalue()


PROFILE = Exporter(
    "xlsx", "Points for Inventor",
    "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet", ".xlsx", _profile,
    PointOptions, "Autodesk Inventor: Import Points in a sketch. Any spreadsheet.",
    by_default=False,
    measure=fidelity_told,
)  # fmt: skip
