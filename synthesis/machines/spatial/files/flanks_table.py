"""Contact lines as tables: contacts of each roller along its width at every cam angle."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import numpy as np

from synthesis.exporters.exporter import FileFormat, untold
from synthesis.exporters.samples.columns import Column, joined
from synthesis.exporters.tables.csv_table import table
from synthesis.machines.spatial.cam_frame import DESCRIPTION
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.files.flanks import Patch, patches
from synthesis.machines.spatial.files.identification import origin
from synthesis.machines.spatial.files.options import Depths, FlankOptions
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE


@dataclass(frozen=True, kw_only=True)
class TableOptions(FlankOptions):
    """As ``FlankOptions``, of more depths."""

    depths: Depths = 5


def _csv(design: SpatialDesign, options: TableOptions) -> bytes:
    return table(joined([_columns(each) for each in patches(design, options)]))


def _columns(each: Patch) -> list[Column]:
    """A row for every point: all places at one cam angle, then the next angle."""
    shape = each.points.shape[1:]
    theta = np.broadcast_to(each.theta[:, None], shape).ravel()
    rho = np.broadcast_to(each.rho, shape).ravel()
    x, y, z = each.points.reshape(3, -1)
    nx, ny, nz = each.normals.reshape(3, -1)
    return [
        Column("roller", "1", "number of the roller", np.full(len(rho), each.wall.seat.number)),
        Column("side", "1", "1: R, -1: L", np.full(len(rho), each.wall.side)),
        Column("theta_deg", "deg", "cam angle", theta / DEGREE),
        Column("rho_mm", "mm", "place on the roller's axis", rho),
        *(Column(f"{name}_mm", "mm", "point of the flank", values)
          for name, values in zip("xyz", (x, y, z), strict=True)),
        *(Column(f"normal_{name}", "1", "unit normal, out of the cam", values)
          for name, values in zip("xyz", (nx, ny, nz), strict=True)),
        Column(
            "pressure_angle_deg", "deg", "between the normal and the roller's velocity",
            each.contacts.pressure_angle.ravel() / DEGREE,
        ),
        Column(
            "regular", "1", "area of the flank to that of the surface which the roller's axis "
            "sweeps; 0 or less: undercut", each.contacts.regular.ravel(),
        ),
    ]  # fmt: skip


def _json(design: SpatialDesign, options: TableOptions) -> bytes:
    body = {
        "kind": "flanks",
        "frame": DESCRIPTION,
        "design": origin(design),
        "flanks": [_flank(each) for each in patches(design, options)],
    }
    return json.dumps(body, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode()


def _flank(each: Patch) -> dict[str, Any]:
    return {
        "name": each.name,
        "roller": each.wall.seat.number,
        "side": each.wall.letter,
        "theta_deg": (each.theta / DEGREE).tolist(),
        "rho_mm": each.rho.tolist(),
        "points_mm": _rows(each.points),
        "normals": _rows(each.normals),
        "pressure_angle_deg": (each.contacts.pressure_angle / DEGREE).tolist(),
        "regular": each.contacts.regular.tolist(),
    }


def _rows(points: Array) -> list[Any]:
    """Nested lists by cam angle, then by place: x, y, z."""
    return np.moveaxis(points, 0, -1).tolist()  # type: ignore[no-any-return]


CSV = FileFormat(
    "flanks.csv", "Contact lines, comma separated", "text/csv; charset=utf-8; header=present",
    ".csv", untold(_csv), TableOptions,
    "A row for every contact: cam angle, roller, side, place on the roller, point and normal of "
    "the flank in the cam's frame, pressure angle.",
)  # fmt: skip
JSON = FileFormat(
    "flanks.json", "Contact lines, as grids", "application/json",
    ".json", untold(_json), TableOptions,
    "Every flank as a grid over cam angle and place on the roller: points, normals, pressure "
    "angles.",
)  # fmt: skip
