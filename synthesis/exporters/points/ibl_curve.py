"""IBL: a datum curve for Creo and Pro/ENGINEER.

`closed` or `open`, `arclength`, then for each curve a section with numbered rows x y z in mm.
`closed` joins the last point to the first by itself, so none is repeated; with points past the end
the curve is `open`. Nothing but the layout may stand in it: no comments.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated

from pydantic import Field

from synthesis.design.design import Design
from synthesis.exporters.exporter import Exporter
from synthesis.exporters.fidelity.told import fidelity_told
from synthesis.exporters.options import PointOptions
from synthesis.exporters.points.rows import point_rows
from synthesis.exporters.samples.cutting import chosen
from synthesis.exporters.samples.sampling import written_points


@dataclass(frozen=True)
class IblOptions(PointOptions):
    """As ``PointOptions``, and the cam's second face.

    Attributes:
        width_mm: if given, a second section lies so far above the first along the axis.
    """

    width_mm: Annotated[
        float | None,
        Field(
            gt=0.0,
            le=1e6,
            description="Width of the cam: its curve once more, so far above the first, as a "
            "second section for a blend.",
        ),
    ] = None


def _profile(design: Design, options: IblOptions) -> bytes:
    cam = chosen(design, options)
    points = written_points(cam, options).ended(options, closed=False)
    ended = options.overlap_points > 0 or options.closed is not None
    head = f"{'open' if ended else 'closed'}\narclength\n".encode()
    levels = [options]
    if options.width_mm is not None:
        levels.append(replace(options, z_mm=(options.z_mm or 0.0) + options.width_mm))
    sections = [
        f"begin section ! {k}\nbegin curve ! {k}\n".encode()
        + point_rows(points, level, "{n} {x} {y} {z}\n", numbered=True)
        for k, level in enumerate(levels, start=1)
    ]
    return head + b"".join(sections)


PROFILE = Exporter(
    "ibl", "Datum curve for Creo", "text/plain; charset=us-ascii", ".ibl",
    _profile, IblOptions,
    "Creo and Pro/ENGINEER: Get Data, Import, or a datum curve from a file.", by_default=False,
    measure=fidelity_told,
)  # fmt: skip
