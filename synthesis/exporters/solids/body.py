"""Slabs as one solid, and its STEP text, by OpenCASCADE. Loading this takes a second or two.

A flank's surface is cut into some faces: kernels integrate a face of many knots badly, and show a
wrong volume.
"""

from __future__ import annotations

import re
import tempfile
from functools import reduce
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse
from OCP.BRepBuilderAPI import (
    BRepBuilderAPI_MakeEdge,
    BRepBuilderAPI_MakeFace,
    BRepBuilderAPI_MakeWire,
)
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism
from OCP.collections import Array1_double, Array1_gp_Pnt, Array1_int
from OCP.GC import GC_MakeArcOfCircle
from OCP.Geom import Geom_BSplineCurve
from OCP.gp import gp_Ax2, gp_Circ, gp_Dir, gp_Pln, gp_Pnt, gp_Vec
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.Interface import Interface_Static
from OCP.Message import Message, Message_Printer
from OCP.ShapeFix import ShapeFix_Face
from OCP.ShapeUpgrade import ShapeUpgrade_UnifySameDomain
from OCP.STEPControl import STEPControl_Controller, STEPControl_StepModelType, STEPControl_Writer
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp_Explorer

from synthesis.errors import SolverFailed
from synthesis.exporters.curves.exact import ExactCurve
from synthesis.exporters.solids.blank import Blank, Outline, Slab

Place = tuple[float, float]
FACES = 24  # that a flank is cut into
UP = gp_Dir(0.0, 0.0, 1.0)
MARK = "the-cam"
KERNEL = "OpenCASCADE"


def solid(blank: Blank) -> Any:
    """The body; SolverFailed where the kernel makes none that is sound."""
    slabs = [_prism(slab) for slab in blank.slabs]
    shape = reduce(lambda one, other: BRepAlgoAPI_Fuse(one, other).Shape(), slabs)
    if len(slabs) > 1:
        merging = ShapeUpgrade_UnifySameDomain(shape, True, True, False)
        merging.Build()
        shape = merging.Shape()
    each = TopExp_Explorer(shape, TopAbs_ShapeEnum.TopAbs_SOLID)
    body = each.Current() if each.More() else None
    if body is None or not BRepCheck_Analyzer(body).IsValid():
        raise SolverFailed(KERNEL, "no sound solid", "Take the curve as STEP and extrude it.")
    return body


def data_lines(body: Any, name: str) -> list[str]:
    """The data section of a STEP file (AP242) that holds the body under a name, quoted."""
    Message.DefaultMessenger_s().RemovePrinters(Message_Printer.get_type_descriptor_s())
    STEPControl_Controller.Init_s()  # what is set before that is forgotten
    for key, value in (
        ("write.step.schema", "AP242DIS"),
        ("write.step.unit", "MM"),
        ("write.step.product.name", MARK),
    ):
        Interface_Static.SetCVal_s(key, value)
    writer = STEPControl_Writer()
    done = writer.Transfer(body, STEPControl_StepModelType.STEPControl_AsIs)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "body.step"
        written = writer.Write(str(path))
        text = path.read_text(encoding="ascii")
    if {done, written} != {IFSelect_ReturnStatus.IFSelect_RetDone}:
        raise SolverFailed(KERNEL, str(done), "Take the curve as STEP and extrude it.")
    data = text.partition("DATA;\n")[2].partition("ENDSEC;")[0]
    # the kernel numbers the products of a process
    return re.sub(rf"'{MARK}[ \d]*'", lambda _: name, data).splitlines()


def _prism(slab: Slab) -> Any:
    floor = gp_Pln(gp_Pnt(0.0, 0.0, slab.low), UP)
    made = BRepBuilderAPI_MakeFace(floor, _wire(slab.outside, slab.low), True)
    for hole in slab.holes:
        made.Add(_wire(hole, slab.low))
    turned = ShapeFix_Face(made.Face())
    turned.FixOrientation()
    return BRepPrimAPI_MakePrism(turned.Face(), gp_Vec(0.0, 0.0, slab.high - slab.low)).Shape()


def _wire(outline: Outline, z: float) -> Any:
    edges = Edges(z)
    for stroke in outline.strokes:
        getattr(edges, stroke.method)(*stroke.arguments)
    made = BRepBuilderAPI_MakeWire()
    for edge in edges.made:
        made.Add(edge)
    return made.Wire()


class Edges:
    """Strokes of an outline as edges at a height; places are (x, y) [mm]."""

    def __init__(self, z: float) -> None:
        self.z, self.made = z, list[Any]()

    def circle(self, radius: float) -> None:
        """About the axis."""
        self._add(self._circle(radius))

    def arc(self, radius: float, start: Place, end: Place) -> None:
        """About the axis, counter-clockwise."""
        ends = self._point(start), self._point(end)
        self._add(GC_MakeArcOfCircle(self._circle(radius), *ends, True).Value())

    def line(self, start: Place, end: Place) -> None:
        """Straight."""
        self._add(self._point(start), self._point(end))

    def spline(self, curve: ExactCurve) -> None:
        """Closed; cut at its corners, and evenly over its knots."""
        knots, times = curve.knots
        points = curve.points + np.array([0.0, 0.0, self.z])
        degree = curve.spline.degree
        whole = Geom_BSplineCurve(
            _filled(Array1_gp_Pnt, [gp_Pnt(*point) for point in points.tolist()]),
            _filled(Array1_double, knots.tolist()),
            _filled(Array1_int, times.tolist()),
            degree,
        )
        even = np.linspace(0, len(knots) - 1, FACES + 1).round().astype(int)
        cuts = np.union1d(even, np.flatnonzero(times >= degree))
        for start, end in pairwise(knots[cuts].tolist()):
            part = whole.Copy()
            part.Segment(start, end)
            self._add(part)

    def _add(self, *geometry: Any) -> None:
        self.made.append(BRepBuilderAPI_MakeEdge(*geometry).Edge())

    def _point(self, place: Place) -> Any:
        return gp_Pnt(*place, self.z)

    def _circle(self, radius: float) -> Any:
        return gp_Circ(gp_Ax2(gp_Pnt(0.0, 0.0, self.z), UP), radius)


def _filled(kind: Any, values: list[Any]) -> Any:
    array = kind(1, len(values))
    for i, value in enumerate(values, start=1):
        array.SetValue(i, value)
    return array
