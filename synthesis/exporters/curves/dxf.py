"""DXF R2010: the cam's curves on layers, in mm.

Splines have control points and clamped knots, never points to be fitted again. Arcs are polylines
with bulges. The same design and options give the same bytes: no clock, no random identifiers.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from synthesis.design.design import Design
from synthesis.errors import ExtraMissing
from synthesis.exporters.curves.exact import MIN_ERROR_UM, Contour
from synthesis.exporters.exporter import FileContent, design_format
from synthesis.exporters.options import BoreDiameter, CurveName, PlacedCurve, is_cutter, is_pitch
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.cutting import checked_cam
from synthesis.exporters.samples.sampling import rotate
from synthesis.numerics.geometry.biarcs import fit_biarcs
from synthesis.numerics.geometry.closed_spline import fit_closed_spline

# Colours by the AutoCAD index: 7 is black on white and white on black.
LAYERS = {"CAM_PROFILE": 7, "PITCH_CURVE": 3, "CUTTER_PATH": 1, "BASE_CIRCLE": 4, "BORE": 7}
MILLIMETRES = 4
PLANE = 8  # a spline's flag
ARCS_UM = 1.0  # tolerance of arcs where none is given


@dataclass(frozen=True, kw_only=True)
class DrawingOptions(PlacedCurve):
    """What a drawing for CAD and CAM shows."""

    form: Literal["spline", "arcs"] = "spline"
    """One SPLINE of degree 5 a curve, for CAD; or a polyline of arcs that meet without a corner,
    for controls and saws that know no spline."""
    tolerance_um: Annotated[float | None, Field(ge=MIN_ERROR_UM, le=1e3)] = None
    """Largest distance from the true curve, along its normal [µm]. Left out: 0.001 for splines, 1
    for arcs. What is reached is reported in the header Camwright-Curve-Error-Mm."""
    companions: bool = True
    """Draw all of the cam, each kind on its own layer: every flank, rollers' paths, base circle,
    bore. Otherwise the one curve alone."""
    bore_mm: BoreDiameter = None

    @property
    def tolerance_mm(self) -> float:
        """The tolerance [mm]."""
        default = ARCS_UM if self.form == "arcs" else 1e-3
        return 1e-3 * (default if self.tolerance_um is None else self.tolerance_um)


def _profile(design: Design, options: DrawingOptions) -> FileContent:
    page = _page(design)
    space, errors = page.modelspace(), []
    for curve, cam in _curves(design, options):
        errors.append(_draw(space, curve, cam, options))
    circles = {"BASE_CIRCLE": design.dimensions["base_radius_mm"]} if options.companions else {}
    bore = options.bore_mm
    if bore is None and options.companions:
        bore = design.spec.shaft_diameter_mm
    if bore is not None:
        circles["BORE"] = 0.5 * bore
    for layer, radius in circles.items():
        space.add_circle((0.0, 0.0, options.z_mm or 0.0), radius, dxfattribs={"layer": layer})
    error = f"{max(errors):.3g}"
    page.header.custom_vars.append("Largest distance from the true curves in mm", error)
    # ezdxf takes the classes of what is drawn from a set, whose order differs between processes
    for kind in sorted(page.entitydb.dxf_types_in_use()):
        page.classes.add_class(kind)
    sheet = io.StringIO()
    page.write(sheet)
    return FileContent(sheet.getvalue().encode("utf-8"), {"Curve-Error-Mm": error})


def _page(design: Design) -> Any:
    """An empty drawing with the layers; ExtraMissing without ezdxf."""
    try:
        from ezdxf._options import options as writing  # loading it takes a third of a second
        from ezdxf.filemanagement import new
    except ImportError as error:
        raise ExtraMissing("DXF", "dxf") from error

    writing.write_fixed_meta_data_for_testing = True
    page = new("R2010", units=MILLIMETRES)
    page.header["$MEASUREMENT"] = 1
    for name, colour in LAYERS.items():
        page.layers.add(name, color=colour)
    page.header.custom_vars.append("Made by", f"Camwright {design.engine_version}")
    page.header.custom_vars.append("Design", design.id)
    return page


def _curves(design: Design, options: DrawingOptions) -> Iterator[tuple[CurveName, Cam]]:
    """The curve that the options name, and what is drawn beside it."""
    wanted = checked_cam(design, options)
    yield options.curve, wanted
    if not options.companions:
        return
    shown = {(wanted.flank.path, wanted.gap)}
    for flank in wanted.flanks():
        for curve, cam in (("profile", flank), ("pitch", replace(flank, gap=0.0))):
            place = cam.flank.path, cam.gap
            if place not in shown:
                shown.add(place)
                yield curve, cam  # type: ignore[misc]


def _draw(space: Any, curve: CurveName, cam: Cam, options: DrawingOptions) -> float:
    """One curve on its layer; how far it is from the true one [mm]."""
    layer = "CUTTER_PATH" if is_cutter(curve) else "CAM_PROFILE"
    attributes: dict[str, Any] = {"layer": "PITCH_CURVE" if is_pitch(curve) else layer}
    z = options.z_mm or 0.0
    if options.form == "arcs":
        arcs = fit_biarcs(Contour.of(cam, every=False), options.tolerance_mm)
        x, y = rotate(options.turn_deg, *arcs.points.T)
        rows = np.column_stack([x, y, arcs.bulges]).tolist()
        attributes["elevation"] = z
        space.add_lwpolyline(rows, format="xyb", close=True, dxfattribs=attributes)
        return arcs.error
    spline = fit_closed_spline(Contour.of(cam), options.tolerance_mm)
    x, y = rotate(options.turn_deg, *spline.points.T)
    drawn = space.add_spline(degree=spline.degree, dxfattribs={**attributes, "flags": PLANE})
    drawn.control_points = np.column_stack([x, y, np.full(len(x), z)])
    drawn.knots = spline.knots.tolist()
    return spline.error


PROFILE = design_format("profile", "dxf", _profile, DrawingOptions)
