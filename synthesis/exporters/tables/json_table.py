"""JSON: typed columns with units, what they belong to, and the frame they are given in."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from synthesis.design.design import Design
from synthesis.exporters.exporter import Exporter
from synthesis.exporters.fidelity.block import fidelity_block
from synthesis.exporters.fidelity.told import MOST, unrounded
from synthesis.exporters.options import CurveOptions, MotionOptions
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.carried import force_columns
from synthesis.exporters.samples.columns import Column, motion_columns, profile_columns
from synthesis.exporters.samples.cutting import chosen
from synthesis.exporters.samples.sampling import in_degrees, written_points
from synthesis.exporters.tables.shortest import WIDTH, joined, written

FRAME = (
    "Cam-fixed, right-handed, lengths in mm: origin on the cam's axis, which is z; at cam angle 0 "
    "the machine's frame, y along the follower of an upward slide. Seen with z towards the viewer "
    "the cam turns {turns}; the rows run round it {runs}.{placed}"
)
TURNED = " The points are turned from there by {turn:.12g}° about z, counter-clockwise positive."


@dataclass(frozen=True)
class JsonOptions(CurveOptions):
    """As ``ProfileOptions``, and what else stands in the file.

    Attributes:
        fidelity: whether it is said what readers make of the curve's points.
    """

    fidelity: Annotated[
        bool,
        Field(
            description="Say what straight lines and splines through the curve's points, taken "
            "once round as for point files and not rounded, do to the form and to the follower's "
            f"acceleration. Left out of more than {MOST} points."
        ),
    ] = True


def _profile(design: Design, options: JsonOptions) -> bytes:
    cam = chosen(design, options)
    turns = ("counter-clockwise", "clockwise")
    turns = turns if design.rotation == "ccw" else turns[::-1]
    head = {
        "kind": "profile",
        "curve": options.curve,
        "frame": FRAME.format(turns=turns[0], runs=turns[1], placed=_placed(options)),
        "seam_deg": float(in_degrees(np.array(cam.seam))),
        **_fidelity(cam, options),
    }
    return _written(design, head, asdict(options), profile_columns(cam, options))


def _fidelity(cam: Cam, options: JsonOptions) -> dict[str, Any]:
    if not options.fidelity:
        return {}
    whole = unrounded(options)
    points = written_points(cam, whole)
    if len(points.theta) > MOST:
        return {}
    return {"fidelity": fidelity_block(cam, points, whole)}


def _placed(options: CurveOptions) -> str:
    return TURNED.format(turn=options.turn_deg) if options.turn_deg else ""


def _motion(design: Design, options: MotionOptions) -> bytes:
    segments = [segment.model_dump(mode="json", exclude_none=True) for segment in design.motion]
    head = {"kind": "motion", "segments": segments}
    cam = Cam.of(design)
    columns = [*motion_columns(cam, options), *force_columns(design, cam, options)]
    return _written(design, head, asdict(options), columns)


def _written(
    design: Design, head: dict[str, Any], sampling: dict[str, Any], columns: Sequence[Column]
) -> bytes:
    body = {
        **head,
        "design": origin(design),
        "rotation": design.rotation,
        "speed_rpm": design.speed_rpm,
        "follower": design.follower,
        "dimensions": design.dimensions,
        "sampling": sampling,
        "rows": len(columns[0].values),
    }
    return columned(body, columns)


def columned(body: dict[str, Any], columns: Sequence[Column]) -> bytes:
    """A document with the columns at its end."""
    inside = b",".join(_column(column) for column in columns)
    return _text(body)[:-1] + b',"columns":[' + inside + b"]}\n"


def origin(design: Design) -> dict[str, Any]:
    """Which design a file is of, and what it is worth."""
    return {
        "id": design.id,
        "name": design.name,
        "engine_version": design.engine_version,
        "status": design.status,
        "certified": design.certificate.certified,
    }


def _column(column: Column) -> bytes:
    head = {
        "name": column.name,
        "unit": column.unit,
        "type": "integer" if column.values.dtype.kind == "i" else "number",
        "meaning": column.meaning,
    }
    cells = np.full((len(column.values), WIDTH + 1), ord(","), dtype=np.uint8)
    # JSON has no infinity: null where the value is infinite
    cells[:, :-1] = written(column.values, infinite="null")
    return _text(head)[:-1] + b',"values":[' + joined(cells)[:-1] + b"]}"


def _text(body: dict[str, Any]) -> bytes:
    return json.dumps(body, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode()


_TITLE, _MEDIA = "Columns with units and metadata", "application/json"
PROFILE = Exporter("json", _TITLE, _MEDIA, ".json", _profile, JsonOptions)
MOTION = Exporter("json", _TITLE, _MEDIA, ".json", _motion, MotionOptions)
