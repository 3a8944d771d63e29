"""Points of a curve for CAD systems: plain text, IBL (Creo), SLDCRV (SOLIDWORKS), XLSX (Inventor).

In: a design and ``PointOptions``: which curve, how dense, where it begins, how it ends. Out: rows
of x, y and z in mm with fixed decimals; z is the cam's position along its shaft, or 0. The points
are a ring: whether its first point is repeated at the end is what readers of each format expect,
unless it is said. The seam lies in the middle of the longest dwell, where the natural end of a CAD
spline does least harm. What splines through the points do to form and acceleration is metadata.
"""

from __future__ import annotations

import datetime
import io
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from pydantic import Field

from synthesis.design.design import Design
from synthesis.exporters.exporter import design_format, format_rows
from synthesis.exporters.fidelity.report import fidelity_header
from synthesis.exporters.options import PointOptions
from synthesis.exporters.samples.cutting import checked_cam
from synthesis.exporters.samples.sampling import in_degrees, written_points
from synthesis.numerics.piecewise import Array

NO_CLOCK = datetime.datetime(1980, 1, 1, tzinfo=datetime.UTC)  # the same bytes at any time
MIN_DISTANCE_MM = 0.01  # of two points; SOLIDWORKS refuses nearer ones


@dataclass(frozen=True)
class IblOptions(PointOptions):
    """As ``PointOptions``, and the cam's second face."""

    width_mm: Annotated[float | None, Field(gt=0.0, le=1e6)] = None
    """Width of the cam: its curve once more, so far above the first, as a second section for a
    blend."""


def _points(design: Design, options: PointOptions, closed: bool) -> Array:
    """The points (n, 2), the first one repeated at the end if ``closed``, unless it is said."""
    return written_points(checked_cam(design, options), options).ended(options, closed)


def _rows(points: Array, options: PointOptions, row: str) -> bytes:
    """A row for each point, with {x}, {y}, {z} where these stand, and {n}, from 1 on."""
    number, (x, y) = f"%.{options.decimals}f", points.T
    z = np.full(len(points), round(options.z_mm or 0.0, options.decimals) + 0.0)
    columns = {"n": ("%d", np.arange(1.0, len(points) + 1.0))}
    columns |= {name: (number, values) for name, values in (("x", x), ("y", y), ("z", z))}
    return format_rows(row, columns).encode("ascii")


def _txt(design: Design, options: PointOptions) -> bytes:
    """No header; the last point joins the first."""
    return _rows(_points(design, options, closed=False), options, "{x} {y} {z}\n")


def _ibl(design: Design, options: IblOptions) -> bytes:
    """Sections of numbered rows; nothing but the layout may stand in it: no comments.

    ``closed`` joins the last point to the first by itself; with points past the end the curve is
    ``open``.
    """
    points = _points(design, options, closed=False)
    ended = options.overlap_points > 0 or options.closed is not None
    levels = [options]
    if options.width_mm is not None:
        levels.append(replace(options, z_mm=(options.z_mm or 0.0) + options.width_mm))
    sections = [
        f"begin section ! {k}\nbegin curve ! {k}\n".encode()
        + _rows(points, level, "{n} {x} {y} {z}\n")
        for k, level in enumerate(levels, start=1)
    ]
    return f"{'open' if ended else 'closed'}\narclength\n".encode() + b"".join(sections)


def _sldcrv(design: Design, options: PointOptions) -> bytes:
    """Units after each number, tabs between, CRLF; closed by the first point at the end."""
    written = written_points(checked_cam(design, options), options)
    steps = np.hypot(*(np.roll(written.points, -1, axis=0) - written.points).T)
    if steps.min() < MIN_DISTANCE_MM:
        at = in_degrees(written.theta[int(np.argmin(steps))])
        density = "points" if options.tolerance_um is None else "tolerance_um"
        raise options.refusal(
            density,
            f"SOLIDWORKS takes no points nearer to each other than {MIN_DISTANCE_MM} mm; at cam "
            f"angle {at:.6g}° there would be {steps.min():.3g} mm between two.",
            "Ask for fewer points.",
        )
    return _rows(written.ended(options, closed=True), options, "{x}mm\t{y}mm\t{z}mm\r\n")


def _xlsx(design: Design, options: PointOptions) -> bytes:
    """A1 holds the unit; below it stand X, Y and Z in the columns A, B and C."""
    points = _points(design, options, closed=True)
    z = round(options.z_mm or 0.0, options.decimals) + 0.0
    packed = io.BytesIO()
    import xlsxwriter  # only here: whoever imports this module seldom writes a workbook

    book = xlsxwriter.Workbook(packed, {"in_memory": True})
    book.set_properties({"created": NO_CLOCK})
    sheet = book.add_worksheet("points")
    sheet.write_string(0, 0, "mm")
    for row, (x, y) in enumerate(points.tolist(), start=1):
        for column, value in enumerate((x, y, z)):
            sheet.write_number(row, column, value)
    book.close()
    return packed.getvalue()


TXT = design_format("profile", "txt", _txt, PointOptions, fidelity_header)
IBL = design_format("profile", "ibl", _ibl, IblOptions, fidelity_header)
SLDCRV = design_format("profile", "sldcrv", _sldcrv, PointOptions, fidelity_header)
XLSX = design_format("profile", "xlsx", _xlsx, PointOptions, fidelity_header)
