"""What a notebook shows of a design: verdict, warnings, the cam with its motion, the summary."""

from __future__ import annotations

from collections.abc import Iterator

from synthesis.design.design import Design
from synthesis.design.warnings import labelled_status
from synthesis.exporters.diagrams.sheet import MOTION
from synthesis.exporters.drawing.html import picture, plain, table
from synthesis.exporters.drawing.summary_table import (
    VERDICTS,
    dimension_figures,
    figures_table,
    summary_tables,
)
from synthesis.exporters.figures.profile import PROFILE
from synthesis.exporters.options import CamDrawingOptions, DiagramOptions

MARKS = {"stop": "#b00020", "caution": "#9a6700", "note": "#57606a"}  # colours of severities


def notebook_display(design: Design) -> dict[str, str]:
    """By media type, as Jupyter asks for it: a page's part in HTML, and a line of text."""
    return {"text/html": "\n".join(_parts(design)), "text/plain": _line(design)}


def _line(design: Design) -> str:
    sizes = ", ".join(f"{name} {value:.6g}" for name, value in design.dimensions.items())
    status = labelled_status(design.status, design.severity)
    return f"<Design {design.name or design.id}: {status}; {sizes or 'no cam'}>"


def _parts(design: Design) -> Iterator[str]:
    status = labelled_status(design.status, design.severity)
    gap = design.certificate.gap
    bound = "" if gap is None else f" No cam is better by more than {100.0 * gap:.3g} %."
    name = plain(design.name.strip() or "Cam")
    yield f"<p><b>{name}</b>: {status}, {VERDICTS[design.status]}.{bound}</p>"
    for each in design.warnings:
        mark = f'<b style="color:{MARKS[each.severity]}">{each.severity}</b>'
        where = f"<code>{plain(each.field)}</code>"
        yield f"<p>{mark} {where}: {plain(each.sentence)} {plain(each.remedy)}</p>"
    if design.conflict is not None:
        limits = ", ".join(design.conflict.limits)
        yield f"<p>These limits cannot hold together: {plain(limits)}</p>"
    if design.motion:
        for drawing, name, width in (
            (PROFILE.write(design, CamDrawingOptions()), "profile", 320),
            (MOTION.write(design, DiagramOptions()), "motion", 480),
        ):
            yield picture(drawing, name, width)
    sizes = figures_table(dimension_figures(design), "Dimensions")
    for shown in (sizes, *summary_tables(design)):
        if shown.rows:
            inside = table(shown.head, shown.rows) + (shown.note and f"<p>{plain(shown.note)}</p>")
            yield f"<details><summary>{plain(shown.title)}</summary>{inside}</details>"
