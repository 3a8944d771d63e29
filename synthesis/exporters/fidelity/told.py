"""Fidelity of point files, told beside them: these formats have no room for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields

from synthesis.design.design import Design
from synthesis.exporters.fidelity.block import fidelity_block, fidelity_line
from synthesis.exporters.options import CurveOptions, PointOptions
from synthesis.exporters.samples.cutting import chosen
from synthesis.exporters.samples.sampling import written_points

EXACT = 15  # decimals of a coordinate in mm: all that a double has
MOST = 7200  # points for which it is worked out unasked


def fidelity_told(design: Design, options: PointOptions) -> Mapping[str, str]:
    """What readers make of a file's points, in a line; of very many points where to ask."""
    cam = chosen(design, options)
    written = written_points(cam, options)
    if len(written.points) > MOST:
        return {"Fidelity": f"more than {MOST} points: ask for profile.fidelity.json"}
    return {"Fidelity": fidelity_line(fidelity_block(cam, written, options))}


def table_fidelity_told(design: Design, options: CurveOptions) -> Mapping[str, str]:
    """The same of a table, whose numbers have all their digits."""
    return fidelity_told(design, unrounded(options))


def unrounded(options: CurveOptions) -> PointOptions:
    """The points of a table as those of a point file, taken once round."""
    shared = {each.name: getattr(options, each.name) for each in fields(CurveOptions)}
    return PointOptions(decimals=EXACT, **shared)
