"""Columns as CSV, as JSON with units and metadata, and as plain rows of numbers.

In: columns (``samples.columns``). Out: bytes; numbers are the shortest decimal text that reads back
to the same double, as Python's ``repr`` writes it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from pydantic_core import to_json

from synthesis.design.design import Design
from synthesis.exporters.exporter import compact_json, design_format
from synthesis.exporters.fidelity.report import MAX_ROWS, as_points, fidelity_block, fidelity_header
from synthesis.exporters.options import CurveOptions, MotionOptions, ProfileOptions, Sampled
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.columns import Column, force_columns, motion_table, profile_columns
from synthesis.exporters.samples.cutting import checked_cam
from synthesis.exporters.samples.sampling import in_degrees, written_points
from synthesis.numerics.piecewise import Array

LEAST, MOST = 1e-4, 1e16  # between these ``repr`` writes no exponent
FRAME = (
    "Cam-fixed, right-handed, lengths in mm: origin on the cam's axis, which is z; at cam angle 0 "
    "the machine's frame, y along the follower of an upward slide. Seen with z towards the viewer "
    "the cam turns {turns}; the rows run round it {runs}.{placed}"
)
TURNED = " The points are turned from there by {turn:.12g}° about z, counter-clockwise positive."


def csv_table(columns: Sequence[Column]) -> bytes:
    """A header row with units in the names, then numbers; UTF-8, LF, dot decimals."""
    header = ",".join(column.name for column in columns).encode()
    rows = zip(*(number_texts(column.values) for column in columns), strict=True)
    return b"\n".join([header, *map(b",".join, rows), b""])


def json_table(body: dict[str, Any], columns: Sequence[Column]) -> bytes:
    """A document with the columns at its end."""
    inside = b",".join(_json_column(column) for column in columns)
    return compact_json(body)[:-1] + b',"columns":[' + inside + b"]}\n"


def _json_column(column: Column) -> bytes:
    head = {
        "name": column.name,
        "unit": column.unit,
        "type": "integer" if column.values.dtype.kind == "i" else "number",
        "meaning": column.meaning,
    }
    # JSON has no infinity: null where the value is infinite
    values = b",".join(number_texts(column.values, infinite="null"))
    return compact_json(head)[:-1] + b',"values":[' + values + b"]}"


def number_texts(values: Array | NDArray[np.int64], infinite: str = "inf") -> list[bytes]:
    """Texts of at least one number (n,) in ASCII, those of ``repr`` but for −0, which is 0.

    pydantic's encoder is several times as fast, and differs from ``repr`` only where that writes
    exponents. ``infinite``: what to write for +∞ (−∞ is not expected).
    """
    numbers: list[float] = (values + 0).tolist()
    texts = to_json(numbers)[1:-1].split(b",")
    if values.dtype.kind == "f":
        magnitude = np.abs(values)
        plain = (magnitude >= LEAST) & (magnitude < MOST) | (magnitude == 0.0)
        for k in np.flatnonzero(~plain).tolist():
            texts[k] = repr(numbers[k]).replace("inf", infinite).encode()
    return texts


@dataclass(frozen=True)
class JsonOptions(CurveOptions):
    """As ``ProfileOptions``, and what else stands in the file."""

    fidelity: Annotated[
        bool,
        Field(
            description="Say what straight lines and splines through the curve's points, taken "
            "once round as for point files and not rounded, do to the form and to the follower's "
            f"acceleration. Left out of more than {MAX_ROWS} points."
        ),
    ] = True


def origin(design: Design) -> dict[str, Any]:
    """Which design a file is of, and whether it is certified."""
    names = ("id", "name", "engine_version", "status")
    about = {name: getattr(design, name) for name in names}
    return about | {"certified": design.certificate.certified}


def _json_profile(design: Design, options: JsonOptions) -> bytes:
    cam = checked_cam(design, options)
    turns = ("counter-clockwise", "clockwise")
    turns = turns if design.rotation == "ccw" else turns[::-1]
    placed = TURNED.format(turn=options.turn_deg) if options.turn_deg else ""
    head = {
        "kind": "profile",
        "curve": options.curve,
        "frame": FRAME.format(turns=turns[0], runs=turns[1], placed=placed),
        "seam_deg": float(in_degrees(np.array(cam.seam))),
    }
    if options.fidelity:
        unrounded = as_points(options)
        points = written_points(cam, unrounded)
        if len(points.theta) <= MAX_ROWS:
            head["fidelity"] = fidelity_block(cam, points, unrounded)
    return _json_file(design, head, options, profile_columns(cam, options))


def _json_motion(design: Design, options: MotionOptions) -> bytes:
    segments = [segment.model_dump(mode="json", exclude_none=True) for segment in design.motion]
    head = {"kind": "motion", "segments": segments}
    return _json_file(design, head, options, _motion_and_forces(design, options))


def _json_file(
    design: Design, head: dict[str, Any], options: Sampled, columns: Sequence[Column]
) -> bytes:
    names = ("rotation", "speed_rpm", "follower", "dimensions")
    body = {
        **head,
        "design": origin(design),
        **{name: getattr(design, name) for name in names},
        "sampling": asdict(options),
        "rows": len(columns[0].values),
    }
    return json_table(body, columns)


def _motion_and_forces(design: Design, options: MotionOptions) -> list[Column]:
    cam = Cam.of(design)
    return motion_table(cam, options, force_columns(design, cam, options))


def _csv_motion(design: Design, options: MotionOptions) -> bytes:
    return csv_table(_motion_and_forces(design, options))


def _txt_motion(design: Design, options: MotionOptions) -> bytes:
    """For programs that read bare numbers: `numpy.loadtxt`, a spreadsheet's text import."""
    columns = [column.values.tolist() for column in motion_table(Cam.of(design), options)]
    rows = zip(*columns, strict=True)
    return "".join(" ".join(map(repr, row)) + "\n" for row in rows).encode("ascii")


CSV_PROFILE = design_format(
    "profile",
    "csv",
    lambda design, options: csv_table(profile_columns(checked_cam(design, options), options)),
    ProfileOptions,
    lambda design, options: fidelity_header(design, as_points(options)),
)
CSV_MOTION = design_format("motion", "csv", _csv_motion, MotionOptions)
JSON_PROFILE = design_format("profile", "json", _json_profile, JsonOptions)
JSON_MOTION = design_format("motion", "json", _json_motion, MotionOptions)
TXT_MOTION = design_format("motion", "txt", _txt_motion, MotionOptions)
