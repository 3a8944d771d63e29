"""Files: how long each format takes to write, how large it is, and how true exact curves are."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from scipy.interpolate import BSpline

from benchmarks.density import cam, textbook
from benchmarks.effort import FULL, Effort
from benchmarks.section import Section, Table
from benchmarks.timing import Call, in_turns
from synthesis.design.design import Design
from synthesis.exporters import (
    MOTION_FORMATS,
    PICTURES,
    PROFILE_FORMATS,
    SOLID_FORMATS,
    Exporter,
    FileContent,
    form,
)
from synthesis.exporters.curves.exact import ExactOptions
from tests.exporters.nearest import away

POINTS = 7200
TOLERANCES_UM = (1.0, 1e-3, 1e-6)
PARTS = {
    "profile": PROFILE_FORMATS, "motion": MOTION_FORMATS, "solid": SOLID_FORMATS, "": PICTURES,
}  # fmt: skip
TEXT = f"""The cam of example 13-6, cycloidal laws, as every file there is: {POINTS} points where a
format has points, otherwise as it comes. *Told* is the distance from the true curve that a file
claims; the second table compares it with the textbook's profile in forty digits, whose distance
from the spline is found by Newton's method."""


def run(effort: Effort = FULL) -> Section:
    """Two tables."""
    design = cam()
    files = {
        f"{part}.{name}".strip("."): (exporter, _options(exporter, effort))
        for part, formats in PARTS.items()
        for name, exporter in formats.items()
    }
    made: dict[str, FileContent] = {}
    calls: dict[str, Call] = {
        name: (lambda n=name, e=exporter, o=options: made.update({n: e.content(design, o)}))
        for name, (exporter, options) in files.items()
    }
    times = in_turns(calls, effort.repeats(25), effort.warm_up(2))
    reported = {name: _describe(content) for name, content in made.items()}
    rows = [
        (f"`{name}`", str(times[name]), f"{len(made[name].data) / 1024:.0f} KiB", reported[name])
        for name in files
    ]
    table = Table(("file", ">time", ">size", ">stated"), rows)
    front = [
        (f"{POINTS} profile points as CSV", str(times["profile.csv"]), "–"),
        (
            "profile and pitch curve as DXF splines",
            str(times["profile.dxf"]),
            reported["profile.dxf"],
        ),
    ]
    return Section("Files", TEXT, [table, _exact(design, effort)], front)


def _describe(content: FileContent) -> str:
    error = content.metadata.get("Curve-Error-Mm")
    return f"{error} mm" if error else "–"


def _options(exporter: Exporter[Any], effort: Effort) -> Any:
    fields = form(exporter.options).model_fields
    sizes = {"points": POINTS // 20 if effort.trial else POINTS}
    sizes |= {"width_px": 200} if effort.trial else {}
    return exporter.options(**{name: size for name, size in sizes.items() if name in fields})


def _exact(design: Design, effort: Effort) -> Table:
    """Tolerances of the exact profile, and what they lead to."""
    truth = textbook(24 if effort.trial else 240)
    tolerances = effort.some(TOLERANCES_UM)
    calls: dict[str, Call] = {
        f"{tolerance:g} µm": (lambda t=tolerance: _curve(design, t)) for tolerance in tolerances
    }
    times = in_turns(calls, effort.repeats(25), effort.warm_up(2))
    rows = []
    for tolerance in tolerances:
        reported = _curve(design, tolerance)
        points = np.array(reported["control_points_mm"])[:, :2]
        spline = BSpline(np.array(reported["knots_mm"]), points, reported["degree"])
        found = float(np.max(away(truth.places, spline)))
        rows.append(
            (
                f"{tolerance:g} µm", str(times[f"{tolerance:g} µm"]), str(len(points)),
                f"{reported['error_mm']:.1e} mm", f"{found:.1e} mm",
            )
        )  # fmt: skip
    return Table(("tolerance", ">time", ">control points", ">stated", ">found"), rows)


def _curve(design: Design, tolerance_um: float) -> dict[str, Any]:
    options = ExactOptions(tolerance_um=tolerance_um)
    reported: dict[str, Any] = json.loads(PROFILE_FORMATS["nurbs.json"].write(design, options))
    return reported
