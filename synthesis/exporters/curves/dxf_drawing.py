"""DXF R2010: the cam's curves on layers, in mm.

Splines have control points and clamped knots, never points to be fitted again. Arcs are polylines
with bulges. The same design and options give the same bytes: no clock, no random identifiers.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from synthesis.design.design import Design
from synthesis.exporters.curves.contour import Contour
from synthesis.exporters.curves.exact_options import DrawingOptions
from synthesis.exporters.exporter import Exporter, FileContent
from synthesis.exporters.options import CurveName, is_cutter, is_pitch
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.cutting import chosen
from synthesis.exporters.samples.sampling import turned
from synthesis.numerics.geometry.biarcs import fit_biarcs
from synthesis.numerics.geometry.closed_spline import fit_closed_spline

# Colours by the AutoCAD index: 7 is black on white and white on black.
LAYERS = {
    "CAM_PROFILE": 7,
    "PITCH_CURVE": 3,
    "CUTTER_PATH": 1,
    "BASE_CIRCLE": 4,
    "BORE": 7,
}
MILLIMETRES = 4
PLANE = 8  # a spline's flag


def _profile(design: Design, options: DrawingOptions) -> FileContent:
    page = _page(design)
    space, errors = page.modelspace(), []
    for curve, cam in _curves(design, options):
        errors.append(_drawn(space, curve, cam, options))
    if options.companions:
        radius = design.dimensions["base_radius_mm"]
        _circle(space, "BASE_CIRCLE", radius, options)
    if options.bore_mm is not None:
        _circle(space, "BORE", 0.5 * options.bore_mm, options)
    error = f"{max(errors):.3g}"
    page.header.custom_vars.append("Largest distance from the true curves in mm", error)
    # ezdxf takes the classes of what is drawn from a set, whose order differs between processes
    for kind in sorted(page.entitydb.dxf_types_in_use()):
        page.classes.add_class(kind)
    sheet = io.StringIO()
    page.write(sheet)
    return FileContent(sheet.getvalue().encode("utf-8"), {"Curve-Error-Mm": error})


def _page(design: Design) -> Any:
    """An empty drawing with the layers."""
    from ezdxf._options import options as writing  # loading it takes a third of a second
    from ezdxf.filemanagement import new

    writing.write_fixed_meta_data_for_testing = True
    page = new("R2010", units=MILLIMETRES)
    page.header["$MEASUREMENT"] = 1
    for name, colour in LAYERS.items():
        page.layers.add(name, color=colour)
    page.header.custom_vars.append("Made by", f"Camwright {design.engine_version}")
    page.header.custom_vars.append("Design", design.id)
    return page


def _curves(design: Design, options: DrawingOptions) -> Iterator[tuple[CurveName, Cam]]:
    """The curve that is asked for, and what is drawn beside it."""
    asked = chosen(design, options)
    yield options.curve, asked
    if not options.companions:
        return
    shown = {(asked.flank.path, asked.gap)}
    for flank in asked.flanks():
        for curve, cam in (("profile", flank), ("pitch", replace(flank, gap=0.0))):
            place = cam.flank.path, cam.gap
            if place not in shown:
                shown.add(place)
                yield curve, cam  # type: ignore[misc]


def _drawn(space: Any, curve: CurveName, cam: Cam, options: DrawingOptions) -> float:
    """One curve on its layer; how far it is from the true one [mm]."""
    attributes: dict[str, Any] = {"layer": _layer(curve)}
    z = options.z_mm or 0.0
    if options.form == "arcs":
        arcs = fit_biarcs(Contour.of(cam, every=False), options.tolerance_mm)
        x, y = turned(options.turn_deg, *arcs.points.T)
        rows = np.column_stack([x, y, arcs.bulges]).tolist()
        attributes["elevation"] = z
        space.add_lwpolyline(rows, format="xyb", close=True, dxfattribs=attributes)
        return arcs.error
    spline = fit_closed_spline(Contour.of(cam), options.tolerance_mm)
    x, y = turned(options.turn_deg, *spline.points.T)
    drawn = space.add_spline(degree=spline.degree, dxfattribs={**attributes, "flags": PLANE})
    drawn.control_points = np.column_stack([x, y, np.full(len(x), z)])
    drawn.knots = spline.knots.tolist()
    return spline.error


def _layer(curve: CurveName) -> str:
    if is_pitch(curve):
        return "PITCH_CURVE"
    return "CUTTER_PATH" if is_cutter(curve) else "CAM_PROFILE"


def _circle(space: Any, layer: str, radius: float, options: DrawingOptions) -> None:
    space.add_circle((0.0, 0.0, options.z_mm or 0.0), radius, dxfattribs={"layer": layer})


PROFILE = Exporter(
    "dxf",
    "DXF, exact curves on layers",
    "image/vnd.dxf",
    ".dxf",
    _profile,
    DrawingOptions,
    purpose="Drawing for CAD and CAM: the cam's curves as splines, or as arcs without corners, "
    "on layers CAM_PROFILE, PITCH_CURVE, CUTTER_PATH, BASE_CIRCLE and BORE, in mm.",
    by_default=False,
)
