"""What OpenCASCADE makes of a file: an independent reader of STEP and IGES."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.IGESControl import IGESControl_Reader
from OCP.Interface import Interface_Static
from OCP.STEPControl import STEPControl_Reader
from OCP.TopAbs import TopAbs_EDGE
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS

READERS = {".step": STEPControl_Reader, ".igs": IGESControl_Reader}


def shape(data: bytes, ending: str, folder: Path) -> Any:
    """All that a file holds, in mm."""
    path = folder / f"read{ending}"
    path.write_bytes(data)
    reader = READERS[ending]()
    Interface_Static.SetCVal_s("xstep.cascade.unit", "MM")
    assert reader.ReadFile(str(path)) == IFSelect_ReturnStatus.IFSelect_RetDone
    assert reader.TransferRoots() > 0
    return reader.OneShape()


def curves(data: bytes, ending: str, folder: Path) -> list[Any]:
    """The curves under all edges."""
    found, each = [], TopExp_Explorer(shape(data, ending, folder), TopAbs_EDGE)
    while each.More():
        told = BRep_Tool.Curve_s(TopoDS.Edge(each.Current()), 0.0, 0.0)
        found.append(told[0] if isinstance(told, tuple) else told)
        each.Next()
    return found


def points(curve: Any, parameters: np.ndarray) -> np.ndarray:
    """(n, 3)."""
    found = [curve.Value(float(u)) for u in parameters]
    return np.array([[point.X(), point.Y(), point.Z()] for point in found])
