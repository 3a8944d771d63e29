"""Tables of the follower's motion for servo drives that take its place: electronic cams.

In: a design, how many rows, the drive's units. Out: master and slave positions over one turn, the
turn's end included, in the layout of a controller's import: an entry of ``assets/drives.toml``
makes a format. ``motion.fidelity.json`` tells what a drive makes of the rounded rows, by how it
interpolates.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import Field
from scipy.interpolate import BPoly

from synthesis.design.design import Design
from synthesis.exporters.exporter import Exporter, asset, design_format, format_rows
from synthesis.exporters.fidelity.measure import Deviation, interpolate
from synthesis.exporters.fidelity.report import (
    DERIVATIVES,
    MAX_ROWS,
    deviation_fields,
    fidelity_file,
    percentage,
)
from synthesis.exporters.options import RowOptions, StartAngle
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.sampling import whole_count
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE, FULL_TURN

ORDERS = np.arange(3)[:, None]  # of derivatives
ZERO = 1e-14  # of a peak: rounding where the value is 0
BETWEEN = np.linspace(0.0, 1.0, 33)  # fractions of each interval where interpolation is measured
METHOD = (
    "What interpolation between the rows as written gives, against the true motion: greatest error "
    "of displacement, velocity and acceleration, and where. linear, cubic: from positions alone; "
    "quintic: with velocity and acceleration, as TwinCAT and CODESYS do. part: of the true peak; "
    "null: infinite, as the velocity jumps."
)


@dataclass(frozen=True)
class DriveOptions(RowOptions):
    """How a drive's table is written; ``start_deg``: cam angle at master position 0, None: 0."""

    start_deg: StartAngle = None
    master_per_turn: Annotated[float, Field(gt=0.0, le=1e9)] = 360.0
    """Master units in a turn of the cam: 360 for degrees."""
    slave_per_unit: Annotated[float, Field(gt=0.0, le=1e9)] = 1.0
    """Slave units in a mm of the follower's displacement (of an arm: in a deg)."""
    decimals: Annotated[int, Field(ge=0, le=12)] = 6
    """Decimals of a position."""


@dataclass(frozen=True, eq=False)
class DriveTable:
    """One turn in the drive's units.

    Attributes:
        theta: (n + 1,) cam angles, rising over one turn [rad].
        master: (n + 1,) positions as they are written.
        slave: (3, n + 1) the same, the last one the first, and two derivatives by the master's.
        decimals: of a position. headline: what the table is of, for formats that have comments.
    """

    theta: Array
    master: Array
    slave: Array
    decimals: int
    headline: str

    @classmethod
    def of(cls, design: Design, options: DriveOptions) -> DriveTable:
        """The follower's motion; the slave's position is that at the master's rounded one.

        InputError: there is no cam, or so many rows that rounding makes some the same.
        """
        cam = Cam.of(design)
        count = whole_count(options.count)
        turn, start_deg = options.master_per_turn, options.start_deg or 0.0
        master: Array = np.round(turn * np.arange(count + 1) / count, options.decimals)
        if not np.all(np.diff(master) > 0.0):
            rule = (
                f"So rounded, {count} master positions in {turn:.12g} units are not all different."
            )
            raise options.refusal("decimals", rule, "Keep more decimals, or ask for fewer rows.")
        theta = start_deg * DEGREE + FULL_TURN * master / turn
        s = cam.motion.derivatives(theta[:-1] % FULL_TURN, 2)
        s = np.column_stack([s, s[:, 0]]) * (options.slave_per_unit / cam.travel.per_unit)
        s[np.abs(s) < ZERO * np.max(np.abs(s), axis=1, keepdims=True)] = 0.0
        s *= (FULL_TURN / turn) ** ORDERS
        s[0] = np.round(s[0], options.decimals)
        headline = (
            f"Camwright {design.engine_version}, design {design.id}: displacement of the follower. "
            f"Master {turn:.12g} units a turn, 0 at cam angle {start_deg:.12g} deg; "
            f"slave {options.slave_per_unit:.12g} units a {cam.travel.unit}."
        )
        return cls(theta, master, s, options.decimals, headline)

    def text(self, layout: Layout) -> str:
        """The table as a controller's import takes it."""
        count, fixed = len(self.master), f"%.{self.decimals}f"
        columns = {
            "n": ("%d", np.arange(1.0 * count)), "number": ("%d", np.arange(1.0, count + 1.0)),
            "master": (fixed, self.master), "slave": (fixed, self.slave[0]),
            "x": ("%r", self.master), **{k: ("%r", self.slave[i]) for i, k in enumerate("yva")},
        }  # fmt: skip
        head = layout.head.format(
            headline=self.headline, count=count, last=count - 1, end=float(self.master[-1])
        )
        return (head + format_rows(layout.row, columns)).removesuffix(",\n") + layout.tail


class Layout(NamedTuple):
    """Of a controller's table: a row, what stands before and after; see ``assets/drives.toml``."""

    row: str
    head: str = ""
    tail: str = ""


def drive_fidelity(design: Design, options: DriveOptions) -> dict[str, Any]:
    """What each way of interpolation makes of the rounded rows, in the units of the wire."""
    cam, table = Cam.of(design), DriveTable.of(design, options)
    scale = cam.travel.per_unit / options.slave_per_unit  # slave units to the core's mm
    s, v, a = table.slave * scale / (FULL_TURN / options.master_per_turn) ** ORDERS
    theta = (table.theta[:-1, None] + BETWEEN * np.diff(table.theta)[:, None]).ravel()
    curves = {
        "linear": interpolate(table.theta, s, "polyline"),
        "periodic cubic": interpolate(table.theta, s, "periodic"),
        "natural cubic": interpolate(table.theta, s, "natural"),
        "quintic": BPoly.from_derivatives(table.theta, np.column_stack([s, v, a])),
    }
    true = cam.motion.derivatives(theta % FULL_TURN, 2)
    peaks = np.max(np.abs(true), axis=1).tolist()
    readers = []
    for reader, curve in curves.items():
        worst = [Deviation.of(curve(theta, k) - true[k], theta) for k in range(len(DERIVATIVES))]
        if reader == "linear" or len(cam.joints.breaking(1)) > 0:
            worst[2] = Deviation(math.inf, Deviation.of(true[2], theta).angle_deg)
        body: dict[str, Any] = {"reader": reader}
        for k, deviation in enumerate(worst):
            body |= deviation_fields(cam, k, deviation, peaks[k])
        readers.append(body)
    return {"rows": len(table.master), "method": METHOD, "readers": readers}


def drive_header(design: Design, options: DriveOptions) -> Mapping[str, str]:
    """The same in a line; of very many rows where to ask for it."""
    if len(DriveTable.of(design, options).master) > MAX_ROWS:
        return {"Fidelity": f"more than {MAX_ROWS} rows: ask for motion.fidelity.json"}
    lines = [
        f"{each['reader']}: displacement {100.0 * each['displacement_part']:.3g} %, "
        f"acceleration {percentage(each['acceleration_part'])}"
        for each in drive_fidelity(design, options)["readers"]
    ]
    return {"Fidelity": "; ".join(lines)}


def _exporter(name: str, title: str, purpose: str, **fields: str) -> Exporter[DriveOptions]:
    media_type, layout = fields.pop("media_type"), Layout(**fields)

    def write(design: Design, options: DriveOptions) -> bytes:
        return DriveTable.of(design, options).text(layout).encode("ascii")

    return Exporter(
        name, f"Electronic cam: {title}", media_type, f".{name}", write, DriveOptions, purpose,
        by_default=False, measure=drive_header,
    )  # fmt: skip


MOTIONS = (
    *(_exporter(**each) for each in tomllib.loads(asset("drives.toml"))["layouts"]),
    design_format(
        "motion",
        "fidelity.json",
        lambda design, options: fidelity_file(design, options, drive_fidelity(design, options)),
        DriveOptions,
    ),
)
