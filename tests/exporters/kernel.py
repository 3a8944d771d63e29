"""What OpenCASCADE makes of a file: an independent reader of STEP and IGES."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tests.lazy import LazyModule

OCP: Any = LazyModule("OCP")


def shape(data: bytes, ending: str, folder: Path) -> Any:
    """All that a file holds, in mm."""
    path = folder / f"read{ending}"
    path.write_bytes(data)
    step = ending == ".step"
    reader = OCP.STEPControl.STEPControl_Reader() if step else OCP.IGESControl.IGESControl_Reader()
    OCP.Interface.Interface_Static.SetCVal_s("xstep.cascade.unit", "MM")
    assert reader.ReadFile(str(path)) == OCP.IFSelect.IFSelect_ReturnStatus.IFSelect_RetDone
    assert reader.TransferRoots() > 0
    return reader.OneShape()


def curves(data: bytes, ending: str, folder: Path) -> list[Any]:
    """The curves under all edges."""
    found, each = (
        [],
        OCP.TopExp.TopExp_Explorer(shape(data, ending, folder), OCP.TopAbs.TopAbs_EDGE),
    )
    while each.More():
        reported = OCP.BRep.BRep_Tool.Curve_s(OCP.TopoDS.TopoDS.Edge(each.Current()), 0.0, 0.0)
        found.append(reported[0] if isinstance(reported, tuple) else reported)
        each.Next()
    return found


def points(curve: Any, parameters: np.ndarray) -> np.ndarray:
    """(n, 3)."""
    found = [curve.Value(float(u)) for u in parameters]
    return np.array([[point.X(), point.Y(), point.Z()] for point in found])
