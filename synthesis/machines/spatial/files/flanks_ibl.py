"""IBL: datum curves for Creo, one for each flank and depth.

A section for every flank, in it a curve for every depth, from the roller's inner end outwards, all
with increasing cam angle. The format allows no comments and no names.
"""

from __future__ import annotations

import numpy as np

from synthesis.exporters.exporter import FileFormat, Made
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.files.flanks import Patch, patches, spline_error
from synthesis.machines.spatial.files.options import WrittenFlankOptions

HEAD = "Open Arclength\n"


def _flanks(design: SpatialDesign, options: WrittenFlankOptions) -> Made:
    found = patches(design, options)
    sections = [_section(k, each, options.decimals) for k, each in enumerate(found, 1)]
    told = {
        "Sections": " ".join(each.name for each in found),
        "Spline-Error-Mm": f"{spline_error(design, found):.3g}",
    }
    return Made((HEAD + "".join(sections)).encode("ascii"), told)


def _section(number: int, each: Patch, decimals: int) -> str:
    curves = [_curve(k, each.points[:, :, k - 1], decimals) for k in range(1, len(each.rho) + 1)]
    return f"begin section ! {number}\n" + "".join(curves)


def _curve(number: int, points: np.ndarray, decimals: int) -> str:
    row = " ".join(["%d", *[f"%.{decimals}f"] * 3]) + "\n"
    rounded = np.round(points.T, decimals) + 0.0
    values = [v for n, point in enumerate(rounded.tolist(), 1) for v in (n, *point)]
    return f"begin curve ! {number}\n" + row * len(rounded) % tuple(values)


FLANKS = FileFormat(
    "flanks.ibl", "Datum curves for Creo", "text/plain; charset=us-ascii", ".ibl",
    _flanks, WrittenFlankOptions,
    "Creo and Pro/ENGINEER: a section for every flank and in it a curve for every depth, of which "
    "the first and the last are the flank's edges; make a boundary blend of them. The header "
    "Camwright-Sections names the sections, Camwright-Spline-Error-Mm gives the deviation of cubic "
    "splines through the points from the flanks.",
)  # fmt: skip
