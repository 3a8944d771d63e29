"""What a notebook shows of a design: verdict, warnings, the cam with its motion, the summary."""

from __future__ import annotations

import base64
from collections.abc import Iterator

from synthesis.design.design import Design
from synthesis.design.warnings import labelled_status
from synthesis.exporters.diagrams.sheet import MOTION
from synthesis.exporters.drawing.html import plain
from synthesis.exporters.drawing.summary_table import VERDICTS, TextTable, summary_tables
from synthesis.exporters.figures.profile import PROFILE
from synthesis.exporters.options import CamDrawingOptions, DiagramOptions

WIDTHS = {"profile": 320, "motion": 480}  # [px] of the pictures
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
        yield _picture("profile", PROFILE.write(design, CamDrawingOptions()))
        yield _picture("motion", MOTION.write(design, DiagramOptions()))
    rows = [[name, f"{value:.6g}"] for name, value in design.dimensions.items()]
    for table in (TextTable("Dimensions", ("", "value"), rows), *summary_tables(design)):
        if table.rows:
            yield f"<details><summary>{plain(table.title)}</summary>{_table(table)}</details>"


def _picture(name: str, drawing: bytes) -> str:
    """A drawing as an image: its style touches nothing else on the page."""
    data = base64.b64encode(drawing).decode()
    return f'<img alt="{name}" width="{WIDTHS[name]}" src="data:image/svg+xml;base64,{data}">'


def _table(table: TextTable) -> str:
    head = "".join(f"<th>{plain(cell)}</th>" for cell in table.head)
    rows = "".join(
        f"<tr>{''.join(f'<td>{plain(cell)}</td>' for cell in row)}</tr>" for row in table.rows
    )
    return f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"
