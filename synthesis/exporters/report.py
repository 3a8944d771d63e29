"""A design as one page to print: what was asked, what came out, what was proven, its files.

Made from the design alone, without any time or date: the same design gives the same bytes. Names
and other texts of the caller's are shown as they are and never taken for elements of the page.
"""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from synthesis.design.analysis import Sensitivities
from synthesis.design.design import Conflict, Design, Extreme, Proof, SmoothnessCost
from synthesis.exporters.diagrams.contact import CONTACT
from synthesis.exporters.diagrams.motion import MOTION
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing import html
from synthesis.exporters.drawing.heading import TURNS
from synthesis.exporters.drawing.picture_options import (
    CamDrawingOptions,
    DiagramOptions,
    PictureOptions,
)
from synthesis.exporters.exporter import Exporter
from synthesis.exporters.figures.profile import PROFILE
from synthesis.exporters.options import Options, ProfileOptions
from synthesis.exporters.samples.cam import profiles

Formats = Mapping[str, Exporter[Any]]
VERDICTS = {
    "optimal": "certified, and proven to be within the tolerance of the best possible",
    "feasible": "certified: every limit holds at every cam angle",
    "infeasible": "no certified cam",
}


def report_with(
    profile_formats: Formats, motion_formats: Formats, costs: Sensitivities | None = None
) -> Exporter[PictureOptions]:
    """The report, which lists the files of these formats, and tells what each limit costs."""

    def write(design: Design, options: PictureOptions) -> bytes:
        name = design.name.strip() or "Cam"
        parts = [
            _head(design, name),
            *([_conflict(design.conflict, bool(design.motion))] if design.conflict else []),
            *(_cam(design, options) if design.motion else []),
            *([_sensitivities(costs)] if costs is not None else []),
            _asked(design),
            *([_files(design, profile_formats, motion_formats)] if design.motion else []),
        ]
        body = "\n".join(parts)
        return html.page(f"{name}: report", html.asset("report.css"), body, options.theme)

    return Exporter(
        "report.html", "Report to print", "text/html; charset=utf-8", ".html", write,
        PictureOptions, "What was asked, found and proven, with drawings and hashes of the files.",
        without_cam=True,
    )  # fmt: skip


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
    kind = "broken" if design.status == "infeasible" else "holds"
    return (
        f"<header><h1>{html.plain(name)}</h1>"
        f'<p class="{kind}"><strong>{design.status}</strong>: {html.plain(verdict)}.</p>'
        f"{_pairs(rows)}</header>"
    )


def _cam(design: Design, options: PictureOptions) -> Iterator[str]:
    """Everything that is told of a cam, whether it keeps its limits or not."""
    theme = options.theme
    drawing = PROFILE.write(design, CamDrawingOptions(theme=theme))
    sizes = [_dimension(name, value) for name, value in design.dimensions.items()]
    chosen = [(name, svg.figure(value, 8)) for name, value in design.free_parameters.items()]
    yield _section("Dimensions", _pairs([*sizes, *chosen]))
    yield _section("The cam", _image(drawing, "Drawing of the cam"), "drawing")
    yield _section("Limits", _limits(design.extremes))
    yield _section("Certificate", _certificate(design))
    if design.smoothness_cost is not None:
        yield _section("What smoothness costs", _smoothness(design.smoothness_cost))
    yield _section("Program", _program(design))
    motion, contact = (
        MOTION.write(design, DiagramOptions(theme=theme)),
        CONTACT.write(design, options),
    )
    yield _section("Motion", _image(motion, "Diagrams of the motion"))
    contacts = _image(contact, "Diagrams of pressure angle and profile radius")
    yield _section("Pressure angle and profile radius", contacts)


def _limits(extremes: Sequence[Extreme]) -> str:
    head = ("Limit", "Extreme", "at", "Allowed", "Margin", "Enclosed", "")
    note = "<p class=note>Extremes over all cam angles, enclosed by interval arithmetic.</p>"
    return _table(head, [("holds" if e.holds else "broken", _limit(e)) for e in extremes]) + note


def _limit(extreme: Extreme) -> list[str]:
    def told(value: float | None, digits: int = 6) -> str:
        return "–" if value is None else svg.measured(value, extreme.unit, digits)

    at = f"{svg.figure(extreme.angle_deg, 6)}°"
    return [
        _words(extreme.limit), told(extreme.value), at, told(extreme.bound),
        told(extreme.margin, 4), f"±{svg.figure(extreme.width, 1)}",
        "holds" if extreme.holds else "broken",
    ]  # fmt: skip


def _certificate(design: Design) -> str:
    proofs = [design.certificate, *design.certificate.other_objectives]
    head = ("Objective", "Value", "No cam is better than", "Gap", "Over")
    rows = [("", _proof(proof)) for proof in proofs]
    certified = "Every limit holds at every cam angle." if design.certificate.certified else (
        "Not every limit holds: see above.")  # fmt: skip
    return _table(head, rows) + f"<p class=note>{certified}</p>"


def _proof(proof: Proof) -> list[str]:
    value = "–" if proof.value is None else svg.figure(proof.value, 8)
    bound = "–" if proof.lower_bound is None else svg.figure(proof.lower_bound, 8)
    gap = "–" if proof.gap is None else f"{svg.figure(100.0 * proof.gap, 3)} %"
    return [_words(proof.objective), value, bound, gap, proof.bound_valid_for or "–"]


def _smoothness(price: SmoothnessCost) -> str:
    named = [("value", price.value), ("with C2 laws", price.c2_value), ("price", price.price),
             ("at most", price.at_most)]  # fmt: skip
    rows = [(name, svg.figure(value, 8)) for name, value in named if value is not None]
    return _pairs([("objective", _words(price.objective)), *rows]) + (
        f"<p class=note>{html.plain(price.note)}</p>" if price.note else ""
    )


def _program(design: Design) -> str:
    unit = design.spec.follower.travel.unit
    rows = []
    for each in design.motion:
        start, end = each.levels
        law = "–" if each.kind == "dwell" else _words(each.law)
        rows.append(("", [
            each.kind, f"{svg.figure(each.start_deg, 8)}°", f"{svg.figure(each.angle_deg, 8)}°",
            svg.measured(round(start, 9), unit), svg.measured(round(end, 9), unit), law,
        ]))  # fmt: skip
    return _table(("Segment", "from", "over", "starts at", "ends at", "Law"), rows)


def _conflict(conflict: Conflict, given: bool) -> str:
    """Why nothing fits, and the least changes that would help."""
    named = ", ".join(_words(limit) for limit in conflict.limits)
    rows = [
        ("", [_words(each.limit), svg.measured(each.requested, each.unit),
              "–" if each.needed is None else svg.measured(each.needed, each.unit),
              each.field, each.note])
        for each in conflict.relaxations
    ]  # fmt: skip
    head = ("Limit", "requested", "needed", "Field", "")
    told = f"<p>These cannot hold together: <strong>{html.plain(named)}</strong>.</p>"
    changes = "<p>The least change of each alone, the others kept:</p>" + _table(head, rows)
    evidence = f"<p class=note>{html.plain(conflict.evidence)}</p>"
    title = "What would mend it" if given else "Why nothing fits"
    return _section(title, told + (changes if rows else "") + evidence)


def _sensitivities(found: Sensitivities) -> str:
    rows = [("", [each.field, svg.figure(each.requested, 8), each.sentence])
            for each in found.sensitivities]  # fmt: skip
    table = _table(("Field", "requested", "One unit more there"), rows) if rows else ""
    return _section("What each limit costs",
                    f"{table}<p class=note>{html.plain(found.evidence)}</p>")  # fmt: skip


def _asked(design: Design) -> str:
    """The whole question, as it can be sent again: a line for each field and each of a list."""
    spec = design.spec.model_dump(mode="json", exclude_none=True)
    lines = [f" {json.dumps(key)}: {_dense(value)}" for key, value in spec.items()]
    text = html.plain_text("{\n" + ",\n".join(lines) + "\n}")
    return _section("What was asked", f"<pre>{text}</pre>")


def _dense(value: Any) -> str:
    def told(each: Any) -> str:
        return json.dumps(each, ensure_ascii=False)

    many = isinstance(value, list) and len(value) > 1
    return "[\n  " + ",\n  ".join(map(told, value)) + "]" if many else told(value)


def _files(design: Design, profile_formats: Formats, motion_formats: Formats) -> str:
    """Names, sizes and SHA-256 of the files as they are without any parameters."""
    rows = [
        (
            "",
            [name, f"{len(content):,}".replace(",", "\u202f"), hashlib.sha256(content).hexdigest()],
        )
        for name, content in _written(design, profile_formats, motion_formats)
    ]
    note = "<p class=note>As they are where no parameter is given.</p>"
    return _section("Files", _table(("File", "bytes", "SHA-256"), rows) + note, "hashes")


def _written(
    design: Design, profile_formats: Formats, motion_formats: Formats
) -> Iterator[tuple[str, bytes]]:
    for stem, curve in profiles(design).items():
        for name, profile in profile_formats.items():
            if profile.by_default and (profile.placeable or stem == "profile"):
                yield f"{stem}.{name}", _file(profile, design, ProfileOptions(curve=curve))
    for name, motion in motion_formats.items():
        if motion.by_default:
            yield f"motion.{name}", _file(motion, design, motion.options())


def _file(exporter: Exporter[Any], design: Design, options: Options) -> bytes:
    return exporter.write(design, exporter.options_like(options))


def _section(title: str, content: str, kind: str = "") -> str:
    return f'<section class="{kind}"><h2>{title}</h2>\n{content}</section>'


def _table(head: Sequence[str], rows: Sequence[tuple[str, Sequence[str]]]) -> str:
    """A table; of each row the class and the cells."""
    titles = "".join(f"<th>{html.plain(cell)}</th>" for cell in head)
    lines = [
        f'<tr class="{kind}">' + "".join(f"<td>{html.plain(cell)}</td>" for cell in row) + "</tr>"
        for kind, row in rows
    ]
    return (
        f'<div class="wide"><table><thead><tr>{titles}</tr></thead><tbody>\n'
        + "\n".join(lines)
        + "</tbody></table></div>"
    )


def _pairs(rows: Sequence[tuple[str, str]]) -> str:
    told = (f"<div><dt>{html.plain(a)}</dt><dd>{html.plain(b)}</dd></div>" for a, b in rows)
    return f"<dl>{''.join(told)}</dl>"


def _image(drawing: bytes, told: str) -> str:
    """A drawing inside the page, by itself: its style is its own."""
    data = base64.b64encode(drawing).decode()
    return f'<img alt="{told}" src="data:image/svg+xml;base64,{data}">'


def _words(name: str) -> str:
    """A name of the wire for people: base radius mm."""
    return name.replace("_", " ")


def _dimension(name: str, value: float) -> tuple[str, str]:
    """A dimension, and its value with the unit that its name on the wire ends with."""
    stem, _, unit = name.rpartition("_")
    if stem and unit in ("mm", "deg"):
        return _words(stem), svg.measured(value, unit, 8)
    return _words(name), svg.figure(value, 8)
