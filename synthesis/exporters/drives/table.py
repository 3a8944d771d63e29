"""Master and slave positions over one turn, evenly spaced, the turn's end included."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field

from synthesis.design.design import Design
from synthesis.errors import InputError
from synthesis.exporters.options import EvenOptions, StartAngle
from synthesis.exporters.samples.cam import Cam
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE, FULL_TURN

LEAST = 36.0  # rows in a turn, as of all files
NOTHING = 1e-14  # of a peak: rounding where the value is 0


@dataclass(frozen=True)
class DriveOptions(EvenOptions):
    """How a drive's table is written.

    Attributes:
        start_deg: cam angle at master position 0; None: 0.
        master_per_turn: master units in a turn. slave_per_unit: slave units in a mm (of an arm:
            in a degree). decimals: of a position. the rest as of ``EvenOptions``.
    """

    start_deg: StartAngle = None
    master_per_turn: Annotated[
        float,
        Field(gt=0.0, le=1e9, description="Master units in a turn of the cam: 360 for degrees."),
    ] = 360.0
    slave_per_unit: Annotated[
        float,
        Field(
            gt=0.0,
            le=1e9,
            description="Slave units in a mm of the follower's displacement (of an arm: in a deg).",
        ),
    ] = 1.0
    decimals: Annotated[int, Field(ge=0, le=12, description="Decimals of a position.")] = 6


@dataclass(frozen=True, eq=False)
class DriveTable:
    """One turn in the drive's units.

    Attributes:
        theta: (n + 1,) cam angles, rising over one turn [rad].
        master, slave: (n + 1,) positions as they are written, the slave's last one its first.
        rate, change: (n + 1,) first and second derivative of the slave's position by the master's.
        unit: of a displacement before it is scaled.
    """

    theta: Array
    master: Array
    slave: Array
    rate: Array
    change: Array
    unit: str


def drive_table(design: Design, options: DriveOptions) -> DriveTable:
    """The follower's motion as a drive's table.

    The slave's position is that at the master's as it is written, rounded.

    Raises:
        InputError: there is no cam, or so many rows that rounding makes some the same.
    """
    cam = Cam.of(design)
    count = math.ceil(max(options.count - 1e-9, LEAST))
    turn = options.master_per_turn
    master: Array = np.round(turn * np.arange(count + 1) / count, options.decimals)
    if not np.all(np.diff(master) > 0.0):
        raise InputError(
            "/decimals", options.decimals,
            f"So rounded, {count} master positions in {turn:.12g} units are not all different.",
            "Keep more decimals, or ask for fewer rows.",
        )  # fmt: skip
    theta = (options.start_deg or 0.0) * DEGREE + FULL_TURN * master / turn
    s = cam.motion.derivatives(theta[:-1] % FULL_TURN, 2)
    s = np.column_stack([s, s[:, 0]]) * (options.slave_per_unit / cam.travel.per_unit)
    s[np.abs(s) < NOTHING * np.max(np.abs(s), axis=1, keepdims=True)] = 0.0
    per_master = FULL_TURN / turn
    slave = np.round(s[0], options.decimals)
    return DriveTable(
        theta, master, slave, s[1] * per_master, s[2] * per_master**2, cam.travel.unit
    )


def drive_rows(table: DriveTable, options: DriveOptions, row: str) -> bytes:
    """One row for each pair, with {master} and {slave} where these stand."""
    number = f"%.{options.decimals}f"
    pattern = row.format(master=number, slave=number)
    pairs = np.column_stack([table.master, table.slave])
    return (pattern * len(pairs) % tuple(pairs.ravel().tolist())).encode("ascii")


def headline(design: Design, table: DriveTable, options: DriveOptions) -> str:
    """What a table is of, for formats that have comments."""
    return (
        f"Camwright {design.engine_version}, design {design.id}: displacement of the follower. "
        f"Master {options.master_per_turn:.12g} units a turn, 0 at cam angle "
        f"{options.start_deg or 0.0:.12g} deg; slave {options.slave_per_unit:.12g} units a "
        f"{table.unit}."
    )


def each_point(table: DriveTable, write: Callable[[int, float, float, float, float], str]) -> str:
    """Points with derivatives, by number from 0, parted by commas and line ends."""
    columns = (table.master, table.slave, table.rate, table.change)
    values = zip(*(column.tolist() for column in columns), strict=True)
    return ",\n".join(write(k, *each) for k, each in enumerate(values))
