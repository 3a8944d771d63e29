"""Tables of the follower's motion for servo drives that take its place: electronic cams.

In: a design, how many rows, the drive's units. Out: master and slave positions over one turn, the
turn's end included, in the layout of a controller's import, of which only what its maker documents
is written. One entry of ``LAYOUTS`` makes a format. ``motion.fidelity.json`` tells what a drive
makes of the rounded rows, by how it interpolates.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import Field
from scipy.interpolate import BPoly

from synthesis.design.design import Design
from synthesis.exporters.exporter import Exporter, format_rows
from synthesis.exporters.fidelity.measure import Deviation, interpolate
from synthesis.exporters.fidelity.report import (
    DERIVATIVES,
    MAX_ROWS,
    deviation_fields,
    fidelity_file,
    percentage,
)
from synthesis.exporters.options import MotionOptions, StartAngle
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.sampling import whole_count
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE, FULL_TURN

ZERO = 1e-14  # of a peak: rounding where the value is 0
BETWEEN = np.linspace(0.0, 1.0, 33)  # fractions of each interval where interpolation is measured
METHOD = (
    "What interpolation between the rows as written gives, against the true motion: greatest error "
    "of displacement, velocity and acceleration, and where. linear, cubic: from positions alone; "
    "quintic: with velocity and acceleration, as TwinCAT and CODESYS do. part: of the true peak; "
    "null: infinite, as the velocity jumps."
)


@dataclass(frozen=True)
class DriveOptions(MotionOptions):
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
        master, slave: (n + 1,) positions as they are written, the slave's last one its first.
        rate, change: (n + 1,) first and second derivative of the slave's position by the master's.
        decimals: of a position. headline: what the table is of, for formats that have comments.
    """

    theta: Array
    master: Array
    slave: Array
    rate: Array
    change: Array
    decimals: int
    headline: str

    @classmethod
    def of(cls, design: Design, options: DriveOptions) -> DriveTable:
        """The follower's motion; the slave's position is that at the master's rounded one.

        Raises:
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
        per_master = FULL_TURN / turn
        headline = (
            f"Camwright {design.engine_version}, design {design.id}: displacement of the follower. "
            f"Master {turn:.12g} units a turn, 0 at cam angle {start_deg:.12g} deg; "
            f"slave {options.slave_per_unit:.12g} units a {cam.travel.unit}."
        )
        return cls(
            theta, master, np.round(s[0], options.decimals), s[1] * per_master,
            s[2] * per_master**2, options.decimals, headline,
        )  # fmt: skip

    def text(self, layout: Layout) -> str:
        """The table as a controller's import takes it."""
        count, fixed = len(self.master), f"%.{self.decimals}f"
        columns = {
            "n": ("%d", np.arange(1.0 * count)), "number": ("%d", np.arange(1.0, count + 1.0)),
            "master": (fixed, self.master), "slave": (fixed, self.slave),
            "x": ("%r", self.master), "y": ("%r", self.slave),
            "v": ("%r", self.rate), "a": ("%r", self.change),
        }  # fmt: skip
        head = layout.head.format(
            headline=self.headline, count=count, last=count - 1, end=float(self.master[-1])
        )
        return (head + format_rows(layout.row, columns)).removesuffix(",\n") + layout.tail


class Layout(NamedTuple):
    """A controller's table.

    Attributes:
        name: of the format. title, media_type, purpose: as of ``FileFormat``.
        row: of each point, its values in braces: {n} from 0 and {number} from 1 on, {master} and
            {slave} with the decimals asked for, {x}, {y}, {v} and {a} (position of the master and
            the slave, first and second derivative) with all digits; a last comma is left out.
        head, tail: text before and after; {headline}, {count}, {last} and {end}: how many points,
            the last one's number from 0 on, its master position.
    """

    name: str
    title: str
    media_type: str
    purpose: str
    row: str
    head: str = ""
    tail: str = ""


CSV, TEXT = "text/csv; charset=us-ascii; header=absent", "text/plain; charset=us-ascii"
LAYOUTS = (
    Layout(
        "cam.csv", "master;slave", CSV, "Any drive whose tool imports pairs of positions.",
        "{master};{slave}\n",
    ),
    # MC_MotionFunctionPoint: between two points runs a polynomial of degree 5 with the velocity and
    # acceleration of both (POLYNOM5_MM, motion to motion), derivatives by the master's position.
    Layout(
        "twincat.st", "TwinCAT motion function", TEXT,
        "Beckhoff TwinCAT NC Camming: paste into a global variable list, then MC_CamTableSelect.",
        "        (PointIndex := {number}, FunctionType := MOTIONFUNCTYPE_POLYNOM5_MM, "
        "PointType := MOTIONPOINTTYPE_MOTION, RelIndexNextPoint := 1, "
        "MasterPos := {x}, SlavePos := {y}, SlaveVelo := {v}, SlaveAcc := {a}, "
        "SlaveJerk := 0.0),\n",
        "(* {headline} *)\nVAR_GLOBAL\n"
        "    CamPoints : ARRAY[1..{count}] OF MC_MotionFunctionPoint := [\n",
        "\n    ];\nEND_VAR\n",
    ),
    # An XYVA cam (byType 3), an array of SMC_CAMXYVA: dV and dA are derivatives of dY by dX.
    Layout(
        "codesys.st", "CODESYS XYVA", TEXT,
        "CODESYS SoftMotion and what is built on it: paste into a global variable list.",
        "        (dX := {x}, dY := {y}, dV := {v}, dA := {a}),\n",
        "(* {headline}\n   Before it is used: Cam.pce := ADR(CamPoints); *)\nVAR_GLOBAL\n"
        "    Cam : MC_CAM_REF := (byType := 3, nElements := {count}, xStart := 0.0, "
        "xEnd := {end!r});\n"
        "    CamPoints : ARRAY[0..{last}] OF SMC_CAMXYVA := [\n",
        "\n    ];\nEND_VAR\n",
    ),
    # The elements of a CAM array for MCCP, cubic segments (1). Its REAL holds about seven digits:
    # that is the instruction's limit, not the file's.
    Layout(
        "rockwell.st", "Rockwell Logix CAM array", TEXT,
        "Rockwell Logix: a routine in structured text that fills a CAM array for MCCP.",
        "Cam[{n}].Master := {master}; Cam[{n}].Slave := {slave}; Cam[{n}].SegmentType := 1;\n",
        "// {headline}\n// Declare Cam : CAM[{count}]; then MCCP makes the profile of it.\n",
    ),
    # Its import turns the CSV into splines. It divides master and slave by their largest values and
    # multiplies them by the scales that are set in the profile.
    Layout(
        "kollmorgen.csv", "Kollmorgen KAS", CSV,
        "Kollmorgen KAS IDE, Import Cam Profile: set its scales to the turn and to the stroke.",
        "{master};{slave};SPLINE\n", "CYCLIC;YES;\nTABLE_BEGIN;;\n", "TABLE_END;;\n",
    ),
    Layout(
        "sew.txt", "SEW curve point table", TEXT, "SEW MOVI-C controllers, curve point table.",
        "{master};{slave}\n", "{count}\n",
    ),
)  # fmt: skip


def drive_fidelity(design: Design, options: DriveOptions) -> dict[str, Any]:
    """What each way of interpolation makes of the rounded rows, in the units of the wire."""
    cam, table = Cam.of(design), DriveTable.of(design, options)
    scale = cam.travel.per_unit / options.slave_per_unit  # slave units to the core's mm
    per_master = FULL_TURN / options.master_per_turn
    s, v = table.slave * scale, table.rate * scale / per_master
    a = table.change * scale / per_master**2
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
        body: dict[str, Any] = {"reader": reader}
        jumps = reader == "linear" or len(cam.joints.breaking(1)) > 0
        for order in range(len(DERIVATIVES)):
            if order == 2 and jumps:
                worst = Deviation(math.inf, Deviation.of(true[order], theta).angle_deg)
            else:
                worst = Deviation.of(curve(theta, order) - true[order], theta)
            body |= deviation_fields(cam, order, worst, peaks[order])
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


def _exporter(layout: Layout) -> Exporter[DriveOptions]:
    def write(design: Design, options: DriveOptions) -> bytes:
        return DriveTable.of(design, options).text(layout).encode("ascii")

    return Exporter(
        layout.name, f"Electronic cam: {layout.title}", layout.media_type, f".{layout.name}", write,
        DriveOptions, layout.purpose, by_default=False, measure=drive_header,
    )  # fmt: skip


MOTIONS = (
    *map(_exporter, LAYOUTS),
    Exporter(
        "fidelity.json", "What drives make of a table's rows", "application/json",
        ".fidelity.json",
        lambda design, options: fidelity_file(design, options, drive_fidelity(design, options)),
        DriveOptions,
        "Before a table goes to a drive: what linear, cubic and quintic interpolation of its "
        "rounded rows do to displacement, velocity and acceleration.",
        by_default=False,
    ),
)  # fmt: skip
