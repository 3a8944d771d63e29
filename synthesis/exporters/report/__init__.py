"""A design as one page to print: the spec, the cam, what was proven, its files.

Made from the design alone, without any time or date: the same design gives the same bytes. Names
and other texts of the caller's are shown as they are and never taken for elements of the page.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import repeat
from typing import Any

from synthesis.design.analysis import Sensitivities
from synthesis.design.design import WITHOUT_CAM, Conflict, Design, Extreme, Proof, Report
from synthesis.design.warnings import DesignWarning, labelled_status
from synthesis.exporters.diagrams.sheet import CONTACT, MOTION
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing import html
from synthesis.exporters.drawing.canvas import TURNS
from synthesis.exporters.drawing.summary_table import VERDICTS, dimension_figures, summary_tables
from synthesis.exporters.exporter import Exporter, asset, design_format
from synthesis.exporters.figures.profile import PROFILE
from synthesis.exporters.options import PictureOptions, ProfileOptions
from synthesis.exporters.samples.cam import profiles

Formats = Mapping[str, Exporter[Any]]
CHECK = (
    "<p class=note>Anyone can check this without the program that made it: "
    "<a href=proof.json>proof.json</a> beside this page, or <code>camwright proof</code>.</p>"
)


def report_with(
    profile_formats: Formats, motion_formats: Formats, costs: Sensitivities | None = None
) -> Exporter[PictureOptions]:
    """The report, which lists the files of these formats, and says what each limit costs."""

    def write(design: Design, options: PictureOptions) -> bytes:
        name = design.name.strip() or "Cam"
        parts = [_head(design, name)]
        if design.warnings:
            parts.append(_warnings(design.warnings))
        if design.conflict:
            parts.append(_conflict(design.conflict, bool(design.motion)))
        if design.motion:
            parts += _cam(design, options)
        if costs is not None:
            parts.append(_sensitivities(costs))
        if design.report.stages:
            parts.append(_effort(design.report))
        parts.append(_spec(design))
        if design.motion:
            parts.append(_files(design, profile_formats, motion_formats))
        body = "\n".join(parts)
        return html.page(f"{name}: report", asset("report.css"), body, options.theme)

    return design_format("picture", "report.html", write, PictureOptions)


def _head(design: Design, name: str) -> str:
    """Name, verdict, and what the numbers belong to."""
    broken = [extreme.limit for extreme in design.extremes if not extreme.holds]
    verdict = VERDICTS[design.status]
    if design.motion and broken:
        verdict = f"this cam was given, and breaks {', '.join(map(_words, broken))}"
    rows = [
        ("Follower", _words(design.follower)),
        ("Cam turns", f"{TURNS[design.rotation]} at {svg.figure(design.speed_rpm, 6)} rpm"),
        ("Design", design.id),
        ("Made by", f"Camwright {design.engine_version}"),
    ]
    bad = design.status in WITHOUT_CAM or design.severity == "stop"
    kind, status = "broken" if bad else "holds", labelled_status(design.status, design.severity)
    if design.severity == "stop":
        verdict += "; but the cam cannot work, see below"
    assumed = "".join(map(_note, design.assumptions))
    return (
        f"<header><h1>{html.plain(name)}</h1>"
        f'<p class="{kind}"><strong>{status}</strong>: {html.plain(verdict)}.</p>'
        f"{assumed}{_pairs(rows)}</header>"
    )


def _cam(design: Design, options: PictureOptions) -> Iterator[str]:
    """All about a cam, whether it keeps its limits or not."""
    certificate = design.certificate

    def drawn(title: str, kind: str, drawing: Exporter[Any], text: str) -> str:
        """A drawing inside the page, by itself."""
        return _section(title, html.picture(drawing.write_like(design, options), text), kind)

    sizes = [(e.name, svg.with_unit(float(e.value), e.unit, 8)) for e in dimension_figures(design)]
    sizes += [(name, svg.figure(value, 8)) for name, value in design.free_parameters.items()]
    yield _section("Dimensions", _pairs(sizes))
    yield drawn("The cam", "drawing", PROFILE, "Drawing of the cam")
    for each in summary_tables(design):
        note = _note(each.note) if each.note else ""
        yield _section(each.title, _table(each.head, each.rows) + note)
    limits = _table(
        ("Limit", "Extreme", "at", "Allowed", "Margin", "Enclosed", ""),
        map(_limit, design.extremes),
        ("holds" if each.holds else "broken" for each in design.extremes),
    )
    note = "Extremes over all cam angles, enclosed by interval arithmetic."
    yield _section("Limits", limits + _note(note))
    proofs = _table(
        ("Objective", "Value", "No cam is better than", "Gap", "Over"),
        map(_proof, (certificate, *certificate.other_objectives)),
    )
    holds = "Every limit holds at every cam angle."
    note = holds if certificate.certified else "Not every limit holds: see above."
    check = CHECK if design.report.stages else ""  # nothing was solved: an analysis has no proof
    yield _section("Certificate", proofs + _note(note) + check)
    price = design.smoothness_cost
    if price is not None:
        costs = {"value": price.value, "with C2 laws": price.c2_value, "price": price.price,
                 "at most": price.at_most}  # fmt: skip
        known = [(name, svg.figure(v, 8)) for name, v in costs.items() if v is not None]
        pairs = _pairs([("objective", _words(price.objective)), *known])
        yield _section("What smoothness costs", pairs + (_note(price.note) if price.note else ""))
    yield _section("Program", _program(design))
    yield drawn("Motion", "", MOTION, "Diagrams of the motion")
    text = "Diagrams of pressure angle and profile radius"
    yield drawn("Pressure angle and profile radius", "", CONTACT, text)


def _warnings(warnings: Sequence[DesignWarning]) -> str:
    """What an engineer would say of the cam, the most severe first."""
    entries = []
    for one in warnings:
        kind = "broken" if one.severity == "stop" else "warning"
        where = _note(f"{_words(one.code)}; {one.field}. {one.source}")
        entries.append(
            f'<p class="{kind}"><strong>{one.severity}</strong>: {html.plain(one.sentence)} '
            f"<em>{html.plain(one.remedy)}</em></p>{where}"
        )
    return _section("Warnings", "\n".join(entries))


def _limit(extreme: Extreme) -> list[str]:
    at, unit = f"{svg.figure(extreme.angle_deg, 6)}°", extreme.unit
    return [
        _words(extreme.limit), _value(extreme.value, unit), at, _value(extreme.bound, unit),
        _value(extreme.margin, unit, 4), f"±{svg.figure(extreme.width, 1)}",
        "holds" if extreme.holds else "broken",
    ]  # fmt: skip


def _value(value: float | None, unit: str = "", digits: int = 6) -> str:
    """A value with its unit, or a dash."""
    return "–" if value is None else svg.with_unit(value, unit, digits).rstrip()


def _proof(proof: Proof) -> list[str]:
    value, bound = (_value(each, digits=8) for each in (proof.value, proof.lower_bound))
    gap = _value(proof.gap and 100.0 * proof.gap, "%", 3)
    return [_words(proof.objective), value, bound, gap, proof.bound_valid_for or "–"]


def _program(design: Design) -> str:
    unit = design.spec.follower.travel.unit
    rows = [
        [
            each.kind, f"{svg.figure(each.start_deg, 8)}°", f"{svg.figure(each.angle_deg, 8)}°",
            *(svg.with_unit(round(level, 9), unit) for level in each.levels),
            "–" if each.kind == "dwell" else _words(each.law),
        ]
        for each in design.motion
    ]  # fmt: skip
    return _table(("Segment", "from", "over", "starts at", "ends at", "Law"), rows)


def _conflict(conflict: Conflict, given: bool) -> str:
    """Why nothing fits, and the values that would do."""
    names = ", ".join(_words(limit) for limit in conflict.limits)
    rows = [
        [_words(each.limit), svg.with_unit(each.requested, each.unit),
         _value(each.needed, each.unit), _value(each.at_least, each.unit), each.field, each.note]
        for each in (*conflict.relaxations, *conflict.program_changes)
    ]  # fmt: skip
    text = f"<p>These cannot hold together: <strong>{html.plain(names)}</strong>.</p>"
    if rows:
        text += "<p>What each alone would have to be, the others kept:</p>"
        text += _table(("Limit", "requested", "needed", "at least", "Field", ""), rows)
    title = "What would mend it" if given else "Why nothing fits"
    return _section(title, text + _note(conflict.evidence))


def _sensitivities(costs: Sensitivities) -> str:
    rows = [[one.field, svg.figure(one.requested, 8), one.sentence] for one in costs.sensitivities]
    table = _table(("Field", "requested", "One unit more there"), rows) if rows else ""
    return _section("What each limit costs", table + _note(costs.evidence))


def _effort(report: Report) -> str:
    """What was bought with what time."""
    rows = [
        [
            each.stage, each.model, f"{svg.figure(each.seconds, 3)} s",
            str(each.nodes or "–"), _value(each.gap and 100.0 * each.gap, "%", 3), each.exit,
        ]
        for each in report.stages
    ]  # fmt: skip
    table = _table(("Stage", "Model", "Time", "Nodes", "Gap after it", "Ended by"), rows)
    note = f"{svg.figure(report.seconds, 3)} s in all, what was measured of the cam included."
    return _section("What it took", table + _note(note))


def _spec(design: Design) -> str:
    """The whole spec, as it can be sent again: a line for each field and each of a list."""

    def text(value: Any) -> str:
        if isinstance(value, list) and len(value) > 1:
            return "[\n  " + ",\n  ".join(json.dumps(v, ensure_ascii=False) for v in value) + "]"
        return json.dumps(value, ensure_ascii=False)

    spec = design.spec.model_dump(mode="json", exclude_none=True)
    lines = [f" {json.dumps(key)}: {text(value)}" for key, value in spec.items()]
    body = html.plain_text("{\n" + ",\n".join(lines) + "\n}")
    return _section("What was asked", f"<pre>{body}</pre>")


def default_files(
    design: Design, profile_formats: Formats, motion_formats: Formats
) -> Iterator[tuple[str, bytes]]:
    """Names and bytes of the files that a cam has where no formats and no options are named."""
    for stem, curve in profiles(design).items():
        for name, profile in profile_formats.items():
            # a drawing shows every flank
            if profile.by_default and (profile.placeable or stem == "profile"):
                yield f"{stem}.{name}", profile.write_like(design, ProfileOptions(curve=curve))
    for name, motion in motion_formats.items():
        if motion.by_default:
            yield f"motion.{name}", motion.write(design, motion.options())


def _files(design: Design, profile_formats: Formats, motion_formats: Formats) -> str:
    """Names, sizes and SHA-256 of the files as they are without any parameters."""
    rows = [
        [name, f"{len(data):,}".replace(",", "\u202f"), hashlib.sha256(data).hexdigest()]
        for name, data in default_files(design, profile_formats, motion_formats)
    ]
    table = _table(("File", "bytes", "SHA-256"), rows)
    return _section("Files", table + _note("As they are where no parameter is given."), "hashes")


def _section(title: str, content: str, kind: str = "") -> str:
    return f'<section class="{kind}"><h2>{title}</h2>\n{content}</section>'


def _table(
    head: Sequence[str], rows: Iterable[Sequence[str]], kinds: Iterable[str] = repeat("")
) -> str:
    """A table that scrolls where it is wider than the page; ``kinds``: of each row the class."""
    return f'<div class="wide">{html.table(head, rows, kinds)}</div>'


def _note(text: str) -> str:
    return f"<p class=note>{html.plain(text)}</p>"


def _pairs(rows: Sequence[tuple[str, str]]) -> str:
    pairs = (f"<div><dt>{html.plain(a)}</dt><dd>{html.plain(b)}</dd></div>" for a, b in rows)
    return f"<dl>{''.join(pairs)}</dl>"


def _words(name: str) -> str:
    """A name of the wire for people: base radius mm."""
    return name.replace("_", " ")
