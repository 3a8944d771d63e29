"""Tables of the follower's motion for servo drives that take its place: electronic cams.

In: a design, how many rows, the drive's units. Out: master and slave positions over one turn, the
turn's end included, in the layout of a controller's import, of which only what its maker documents
is written. One entry of ``LAYOUTS`` makes a format. ``motion.fidelity.json`` tells what a drive
makes of the rounded rows, by how it interpolates.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import Field
from scipy.interpolate import BPoly

from synthesis.design.design import Design
from synthesis.errors import InputError
from synthesis.exporters.exporter import Exporter
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
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE, FULL_TURN

MIN_ROWS = 36.0  # in a turn, as of all files
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
        count = math.ceil(max(options.count - 1e-9, MIN_ROWS))
        turn, start_deg = options.master_per_turn, options.start_deg or 0.0
        master: Array = np.round(turn * np.arange(count + 1) / count, options.decimals)
        if not np.all(np.diff(master) > 0.0):
            raise InputError(
                "/decimals", options.decimals,
                f"So rounded, {count} master positions in {turn:.12g} units are not all different.",
                "Keep more decimals, or ask for fewer rows.",
            )  # fmt: skip
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

    def pairs(self, row: str) -> str:
        """A row for each pair, with {master} and {slave} where these stand."""
        number = f"%.{self.decimals}f"
        pattern = row.format(master=number, slave=number)
        pairs = np.column_stack([self.master, self.slave])
        return pattern * len(pairs) % tuple(pairs.ravel().tolist())

    def points(self, row: str, first: int) -> str:
        """A row for each point with derivatives: {n} from ``first`` on, {x}, {y}, {v} and {a}."""
        columns = (self.master, self.slave, self.rate, self.change)
        values = zip(*(column.tolist() for column in columns), strict=True)
        return ",\n".join(
            row.format(n=n, x=x, y=y, v=v, a=a) for n, (x, y, v, a) in enumerate(values, first)
        )


def _kollmorgen(table: DriveTable) -> str:
    """Its import turns the CSV into splines.

    It divides master and slave by their largest values and multiplies them by the scales that are
    set in the profile: set those to the turn and to the stroke.
    """
    rows = table.pairs("{master};{slave};SPLINE\n")
    return f"CYCLIC;YES;\nTABLE_BEGIN;;\n{rows}TABLE_END;;\n"


def _twincat(table: DriveTable) -> str:
    """An array of MC_MotionFunctionPoint.

    Between two points runs a polynomial of degree 5 with the velocity and acceleration of both
    (POLYNOM5_MM, motion to motion), as derivatives by the master's position.
    """
    points = table.points(
        "        (PointIndex := {n}, FunctionType := MOTIONFUNCTYPE_POLYNOM5_MM, "
        "PointType := MOTIONPOINTTYPE_MOTION, RelIndexNextPoint := 1, "
        "MasterPos := {x!r}, SlavePos := {y!r}, SlaveVelo := {v!r}, SlaveAcc := {a!r}, "
        "SlaveJerk := 0.0)",
        first=1,
    )
    return (
        f"(* {table.headline} *)\n"
        "VAR_GLOBAL\n"
        f"    CamPoints : ARRAY[1..{len(table.master)}] OF MC_MotionFunctionPoint := [\n"
        f"{points}\n    ];\nEND_VAR\n"
    )


def _codesys(table: DriveTable) -> str:
    """An XYVA cam (byType 3), an array of SMC_CAMXYVA: dV and dA are derivatives of dY by dX."""
    points = table.points("        (dX := {x!r}, dY := {y!r}, dV := {v!r}, dA := {a!r})", first=0)
    count, end = len(table.master), float(table.master[-1])
    return (
        f"(* {table.headline}\n"
        "   Before it is used: Cam.pce := ADR(CamPoints); *)\n"
        "VAR_GLOBAL\n"
        f"    Cam : MC_CAM_REF := (byType := 3, nElements := {count}, xStart := 0.0, "
        f"xEnd := {end!r});\n"
        f"    CamPoints : ARRAY[0..{count - 1}] OF SMC_CAMXYVA := [\n"
        f"{points}\n    ];\nEND_VAR\n"
    )


def _rockwell(table: DriveTable) -> str:
    """The elements of a CAM array for MCCP, cubic segments (1).

    Its REAL holds about seven digits: that is the instruction's limit, not the file's.
    """
    pairs = [line.split() for line in table.pairs("{master} {slave}\n").splitlines()]
    lines = [
        f"// {table.headline}",
        f"// Declare Cam : CAM[{len(pairs)}]; then MCCP makes the profile of it.",
        *(
            f"Cam[{k}].Master := {master}; Cam[{k}].Slave := {slave}; Cam[{k}].SegmentType := 1;"
            for k, (master, slave) in enumerate(pairs)
        ),
    ]
    return "\n".join(lines) + "\n"


class Layout(NamedTuple):
    """A controller's table: name of the format, titles, media type, and the table as text."""

    name: str
    title: str
    media_type: str
    purpose: str
    text: Callable[[DriveTable], str]


CSV, TEXT = "text/csv; charset=us-ascii; header=absent", "text/plain; charset=us-ascii"
PAIRS = "{master};{slave}\n"
LAYOUTS = (
    Layout(
        "cam.csv", "master;slave", CSV, "Any drive whose tool imports pairs of positions.",
        lambda table: table.pairs(PAIRS),
    ),
    Layout(
        "twincat.st", "TwinCAT motion function", TEXT,
        "Beckhoff TwinCAT NC Camming: paste into a global variable list, then MC_CamTableSelect.",
        _twincat,
    ),
    Layout(
        "codesys.st", "CODESYS XYVA", TEXT,
        "CODESYS SoftMotion and what is built on it: paste into a global variable list.", _codesys,
    ),
    Layout(
        "rockwell.st", "Rockwell Logix CAM array", TEXT,
        "Rockwell Logix: a routine in structured text that fills a CAM array for MCCP.", _rockwell,
    ),
    Layout(
        "kollmorgen.csv", "Kollmorgen KAS", CSV,
        "Kollmorgen KAS IDE, Import Cam Profile: set its scales to the turn and to the stroke.",
        _kollmorgen,
    ),
    Layout(
        "sew.txt", "SEW curve point table", TEXT, "SEW MOVI-C controllers, curve point table.",
        lambda table: f"{len(table.master)}\n{table.pairs(PAIRS)}",
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
        return layout.text(DriveTable.of(design, options)).encode("ascii")

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
