"""The datasheet: a design on one A4 page, what an engineer reads first.

Cam, figures, motion, coefficients beside those of the usual law, limits with margins, warnings, and
the certificate in words. One drawing of the page in mm; PDF and HTML are made of it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

from synthesis.design.design import WITHOUT_CAM, Design
from synthesis.design.warnings import labelled_status
from synthesis.exporters.diagrams.plot import Frame, diagram, linear
from synthesis.exporters.diagrams.sheet import angle_axis, grounds, motion_bounds, motion_plot
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing import html
from synthesis.exporters.drawing.canvas import LABEL, TICK, TITLE, about
from synthesis.exporters.drawing.raster import as_pdf
from synthesis.exporters.drawing.summary_table import (
    SPOKEN,
    VERDICTS,
    TextTable,
    certificate_words,
    coefficient_table,
    dimension_figures,
    figures_table,
    force_figures,
    geometry_figures,
    motion_table,
)
from synthesis.exporters.exporter import asset, design_format
from synthesis.exporters.figures.profile import cam_picture
from synthesis.exporters.options import CamDrawingOptions, Options, PictureOptions, Theme
from synthesis.exporters.samples.cam import Cam
from synthesis.spec.design_spec import RADII

WIDTH, HEIGHT, MARGIN = 210.0, 297.0, 12.0  # A4, ISO 216 [mm]
INNER = WIDTH - 2.0 * MARGIN
ROW, GAP = 3.6, 3.4  # [mm] of a line of a table, and between two blocks
TOP, PICTURE_HEIGHT, PICTURE_WIDTH = 33.0, 83.0, 86.0  # [mm]
PLOT_HEIGHT, PLOT_STEP, AXIS = 10.5, 17.0, 12.0  # [mm] of a diagram, from one to the next, below
LEFT = 21.0  # [mm]: numbers stand between the margin and a diagram
FOOT = HEIGHT - MARGIN
# where the columns of tables begin, as shares of their widths
FIGURES = (0.0, 0.53, 0.86)
PEAKS = (0.0, 0.155, 0.225, 0.35, 0.45, 0.57, 0.67, 0.8)
MOVES = (0.0, 0.3, 0.41, 0.53, 0.66, 0.77, 0.885)
LIMITS = (0.0, 0.28, 0.47, 0.56, 0.74, 0.915)
LAST = ("centre of gravity", "perimeter", "area", "centroid", "polar", SPOKEN["s0_mm"])  # figures
LEAST_LIMITS = 3  # lines that coefficients leave to limits
CERTIFICATE_LINES, ASSUMPTION_LINES, WARNING_LINES = 3, 2, 5  # at the foot, at most


def _sheet(design: Design, theme: Theme) -> bytes:
    """The page."""
    cam = Cam.of(design)
    body = [*_head(design)]
    # 1. the cam, and beside it its figures
    drawn = cam_picture(design, CamDrawingOptions(theme=theme))
    body.append(svg.picture(drawn, MARGIN, TOP, PICTURE_WIDTH, PICTURE_HEIGHT, "The cam"))
    beside = MARGIN + PICTURE_WIDTH + 6.0
    # dimensions, by which a machine is built, then what was measured of the cam
    geometry = list(dimension_figures(design))
    named = {each.name for each in geometry}
    if design.geometry is not None:
        geometry += [each for each in geometry_figures(design.geometry) if each.name not in named]
    # what is cut where there is no room comes last
    geometry.sort(key=lambda each: each.name.startswith(LAST))
    most = int(PICTURE_HEIGHT / ROW) - 1
    loads = [] if design.forces is None else list(force_figures(design.forces))
    rows = _most(figures_table(geometry, "").rows, most - len(loads))
    rows += figures_table(loads, "").rows
    figures = TextTable("", ("Figure", "value", "at"), rows)
    _, lines = _table(figures, beside, TOP, WIDTH - MARGIN - beside, FIGURES, most)
    body += lines
    # 2. the motion
    y = TOP + PICTURE_HEIGHT + GAP + 4.0
    for order in range(4):
        frame = Frame(LEFT, y + order * PLOT_STEP, WIDTH - MARGIN - LEFT, PLOT_HEIGHT)
        plot = motion_plot(cam, order, limits=motion_bounds(design, order))
        plot = replace(plot, labels=partial(linear, most=4))
        body += [*grounds(design.motion, frame), *diagram(plot, frame)]
    body += angle_axis(frame)
    y = frame.bottom + AXIS + GAP
    # 3. peaks of the turn, coefficients of the moves; at the foot warnings and certificate
    foot = _foot(design)
    end = FOOT - ROW * len(foot) - GAP
    if design.motion_summary is not None:
        peaks = motion_table(design, design.motion_summary)
        y, lines = _table(peaks._replace(rows=peaks.rows[:3]), MARGIN, y, INNER, PEAKS, 3)
        body += lines
        moves = coefficient_table(design, design.motion_summary)
        kept = _fitting(y + GAP, end - GAP - ROW * (LEAST_LIMITS + 1))
        y, lines = _table(moves, MARGIN, y + GAP, INNER, MOVES, kept)
        body += lines
    # 4. limits have what is left
    limits = TextTable("", ("Limit", "value", "at", "allowed", "margin", ""), [*_limits(design)])
    y, lines = _table(limits, MARGIN, y + GAP, INNER, LIMITS, _fitting(y + GAP, end))
    body += lines
    for k, (kind, text) in enumerate(foot):
        body.append(svg.text(kind, MARGIN, FOOT - ROW * (len(foot) - 1 - k), text))
    title = f"Datasheet of {design.name or design.id}"
    return svg.document(WIDTH, HEIGHT, 1.0, title, "A page to print.", body, theme=theme)


def _head(design: Design) -> Iterator[str]:
    follower = design.follower.replace("_", " ")
    article = "an" if follower[0] in "aeiou" else "a"
    name = design.name.strip() or f"Cam for {article} {follower} follower"
    # a name that is too long for a title is written in smaller letters before it is cut
    room, large = 0.8 * INNER, TITLE * svg.BOLD
    kind, size = ("title", large) if svg.width_of(name, large) <= room else ("label", LABEL)
    yield svg.text(kind, MARGIN, MARGIN + 4.0, svg.shorten(name, room, size))
    made = f"Camwright {design.engine_version}"
    yield svg.text("quiet", WIDTH - MARGIN, MARGIN + 4.0, made, "end")
    yield svg.text("quiet", MARGIN, MARGIN + 9.0, svg.shorten(about(design), INNER, LABEL))
    status = labelled_status(design.status, design.severity)
    verdict = f"{status}: {VERDICTS[design.status]}."
    broken = [extreme.limit for extreme in design.extremes if not extreme.holds]
    if broken:
        verdict = f"{status}: this cam breaks {', '.join(broken).replace('_', ' ')}."
    kind = "alarm" if design.status in WITHOUT_CAM or design.severity == "stop" else "label"
    yield svg.text(kind, MARGIN, MARGIN + 14.0, svg.shorten(verdict, INNER, LABEL))


def _limits(design: Design) -> Iterator[tuple[str, ...]]:
    """Limits with a bound: first what is broken, then what the spec asks for, then what follows."""
    spec = design.spec
    asked = {one.kind for one in spec.limits} | {r for r in RADII if getattr(spec, r) is not None}
    bounded = [each for each in design.extremes if each.bound is not None]
    for each in sorted(bounded, key=lambda one: (one.holds, one.field.split("/")[0] not in asked)):
        # a margin, which is a difference, has fewer digits that mean something
        value, bound, margin = (
            "–" if number is None else svg.with_unit(number, each.unit, digits).rstrip()
            for number, digits in ((each.value, 5), (each.bound, 5), (each.margin, 3))
        )
        yield (
            each.limit.replace("_", " "), value, f"{svg.figure(each.angle_deg, 5)}°", bound, margin,
            "holds" if each.holds else "BROKEN",
        )  # fmt: skip


def _foot(design: Design) -> list[tuple[str, str]]:
    """Warnings, assumptions, the certificate in words: kind of letters and text of every line."""
    lines: list[tuple[str, str]] = []
    for each in design.warnings:
        kind = "label" if each.severity == "note" else "alarm"
        lines += _lines(kind, f"{each.severity}: {each.sentence}", WARNING_LINES)
    if len(lines) > WARNING_LINES:
        lines = [*lines[: WARNING_LINES - 1], ("alarm", "More warnings are in the report.")]
    # of an assumption the first sentence says what was assumed, the others how to ask otherwise
    assumed = " ".join(f"{each.split('. ')[0].rstrip('.')}." for each in design.assumptions)
    lines += _lines("label", assumed, ASSUMPTION_LINES)
    return lines + _lines("quiet", certificate_words(design.certificate), CERTIFICATE_LINES)


def _lines(kind: str, text: str, most: int) -> list[tuple[str, str]]:
    """A text in lines, cut with an ellipsis where there are more."""
    found = svg.wrapped(text, INNER, LABEL)
    if len(found) > most:
        found = [*found[: most - 1], svg.shorten(f"{found[most - 1]} …", INNER, LABEL)]
    return [(kind, line) for line in found]


def _fitting(top: float, bottom: float) -> int:
    """Lines of a table, besides its head at ``top``, that fit above ``bottom``."""
    return int((bottom - top) / ROW - 1.0)


def _most(rows: Sequence[Sequence[str]], count: int) -> list[Sequence[str]]:
    """The first rows; where there are more, the last line says so."""
    if len(rows) <= count:
        return list(rows)
    left = len(rows) - count + 1
    return [*rows[: count - 1], (f"… {left} more in the report", *[""] * (len(rows[0]) - 1))]


def _table(
    table: TextTable, x: float, y: float, width: float, columns: Sequence[float], most: int
) -> tuple[float, list[str]]:
    """A table from y down, its columns beginning at shares of the width; y below it, and lines."""
    body = [svg.line("axis", x, y + 1.2, x + width, y + 1.2)]
    ends = [*columns[1:], 1.0]

    def cells(kind: str, row: Sequence[str], at: float) -> Iterator[str]:
        for text, start, end in zip(row, columns, ends, strict=True):
            fitting = svg.shorten(text, (end - start) * width - 1.0, TICK)
            if fitting:
                yield svg.text(kind, x + start * width, at, fitting)

    body += cells("label", table.head, y)
    for k, row in enumerate(_most(table.rows, max(most, 1))):
        y += ROW if k else ROW + 0.9
        body += cells("tick", row, y)
    return y + ROW, body


def _html(design: Design, options: PictureOptions) -> bytes:
    drawing = _sheet(design, options.theme).decode()
    body = drawing[drawing.index("<svg") :]
    title = f"{design.name.strip() or 'Cam'}: datasheet"
    return html.page(title, asset("datasheet.css"), body, options.theme)


def _pdf(design: Design, options: Options) -> bytes:
    return as_pdf(_sheet(design, "print"), f"Datasheet of {design.name or design.id}")


DATASHEET_HTML = design_format("picture", "datasheet.html", _html, PictureOptions)
DATASHEET_PDF = design_format("picture", "datasheet.pdf", _pdf, Options)
