"""Fidelity of point files, told beside them: these formats have no room for it."""

from __future__ import annotations

from collections.abc import Mapping

from synthesis.design import Design
from synthesis.exporters.cutting import chosen
from synthesis.exporters.fidelity.block import fidelity_block, fidelity_line
from synthesis.exporters.options import PointOptions
from synthesis.exporters.sampling import written_points

MOST = 7200  # points for which it is worked out unasked


def fidelity_told(design: Design, options: PointOptions) -> Mapping[str, str]:
    """What readers make of a file's points, in a line; of very many points where to ask."""
    cam = chosen(design, options)
    written = written_points(cam, options)
    if len(written.points) > MOST:
        return {"Fidelity": f"more than {MOST} points: ask for profile.fidelity.json"}
    return {"Fidelity": fidelity_line(fidelity_block(cam, written, options))}
