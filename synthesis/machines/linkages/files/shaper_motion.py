"""The motion of a shaper over a turn of its crank: as tables, and as the spec of a cam."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, Final

import numpy as np
from pydantic import Field

from synthesis.errors import InputError
from synthesis.exporters.options import MotionOptions, Options
from synthesis.exporters.samples.columns import Column
from synthesis.exporters.tables.formats import csv_table
from synthesis.machines.linkages.shaper import SixBarShaper
from synthesis.machines.linkages.shaper.mechanism import Drive, Motion, Shaper, angle
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE, FULL_TURN

MIN_ROWS: Final = 36  # of a table: one in 10°
TOLERANCE: Final = 1e-4  # of the stroke: default tolerance of the cam's table
ROLLER: Final = 0.1  # of the stroke: default roller radius


@dataclass(frozen=True, eq=False)
class SampledTurn:
    """A shaper at evenly spaced angles of a turn.

    Attributes:
        turned: (n,) angle turned by the crank since its start [rad]. motion: (n,) arrays.
    """

    shaper: Shaper
    drive: Drive
    turned: Array
    motion: Motion

    @classmethod
    def of(cls, found: SixBarShaper, count: int, closed: bool = True) -> SampledTurn:
        """``count`` angles of a turn, and its end too where it is to be closed."""
        shaper, drive = found.spec.shaper(found.dimensions), found.spec.drive
        turned = FULL_TURN * np.arange(count + closed) / count
        return cls(shaper, drive, turned, shaper.motion(drive.phi(turned)))

    @cached_property
    def columns(self) -> dict[str, Column]:
        """All quantities by name, as columns of a table."""
        motion, drive, turned = self.motion, self.drive, self.turned

        def column(name: str, unit: str, meaning: str, values: Any) -> Column:
            in_unit = values / DEGREE if unit.startswith("deg") else values
            return Column(name, unit, meaning, np.asarray(in_unit))

        def with_rates(
            name: str, unit: str, meaning: str, value: Any, first: Any, second: Any
        ) -> list[Column]:
            """A quantity and its time derivatives, from those by the crank angle."""
            velocity, acceleration = drive.first(first, turned), drive.second(first, second, turned)
            return [
                column(f"{name}_{unit}", unit, meaning, value),
                column(f"{name}_{unit}_per_s", f"{unit}/s", "its velocity", velocity),
                column(f"{name}_{unit}_per_s2", f"{unit}/s²", "its acceleration", acceleration),
            ]

        upright = 0.5 * np.pi - np.abs(np.arcsin(motion.coupler[1]))
        columns = (
            column("crank_travel_deg", "deg", "angle turned by the crank", turned),
            column("crank_deg", "deg", "crank angle", drive.phi(turned)),
            column("time_s", "s", "time since the start of the turn", drive.time(turned)),
            *with_rates("ram", "mm", "position of the ram's pin", *motion.ram),
            *with_rates("guide", "deg", "angle of the guide", angle(motion.guide),
                        *motion.guide_turn),
            *with_rates("coupler", "deg", "angle of the coupler", angle(motion.coupler),
                        *motion.coupler_turn),
            column("slide_mm", "mm", "crank's pin to the guide's pivot", motion.slide[0]),
            column("slide_mm_per_s", "mm/s", "velocity of the block along the guide, not the ram's",
                   drive.first(motion.slide[1], turned)),
            column("transmission_deg", "deg", "transmission angle at the ram", upright),
        )  # fmt: skip
        return {each.name: each for each in columns}

    def values(self, name: str) -> Array:
        """The values of one quantity, (n,), in its unit."""
        return np.asarray(self.columns[name].values, dtype=float)


def motion_table(found: SixBarShaper, options: MotionOptions) -> list[Column]:
    """The motion as the options sample it."""
    return [*SampledTurn.of(found, max(MIN_ROWS, round(options.count))).columns.values()]


def motion_csv(found: SixBarShaper, options: MotionOptions) -> bytes:
    """The motion, comma separated."""
    return csv_table(motion_table(found, options))


def motion_json(found: SixBarShaper, options: MotionOptions) -> bytes:
    """The motion with units and meanings."""
    columns = motion_table(found, options)
    return _json(
        {
            "kind": "shaper motion",
            "shaper": {"id": found.id, "name": found.name, "status": found.status},
            "dimensions": found.dimensions,
            "rotation": found.spec.rotation,
            "rows": len(columns[0].values),
            "columns": [vars(each) | {"values": each.values.tolist()} for each in columns],
        }
    )


@dataclass(frozen=True)
class CamOptions(Options):
    """The cam's follower and limits.

    Attributes:
        points: rows of the table. tolerance_mm: how far the follower may pass a row; None: a ten
            thousandth of the stroke. roller_radius_mm: None: a tenth of the stroke.
        pressure_angle_deg: the limit, on all of the turn.
    """

    points: Annotated[int, Field(ge=36, le=3600, description="Rows of the table.")] = 360
    tolerance_mm: Annotated[
        float | None,
        Field(
            ge=1e-7, le=1e3,
            description="How far the follower may pass a row; left out: 1e-4 of the stroke.",
        ),
    ] = None  # fmt: skip
    roller_radius_mm: Annotated[
        float | None,
        Field(gt=0.0, le=1e6, description="Of the follower; left out: a tenth of the stroke."),
    ] = None
    pressure_angle_deg: Annotated[
        float, Field(gt=0.0, lt=90.0, description="Largest pressure angle.")
    ] = 35.0


def cam_spec(found: SixBarShaper, options: CamOptions) -> bytes:
    """The ram's motion as a table of a DesignSpec, with a translating roller.

    Raises:
        InputError: the crank accelerates, so that the motion does not repeat.
    """
    if found.spec.acceleration_rad_per_s2:
        raise InputError(
            "/acceleration_rad_per_s2", found.spec.acceleration_rad_per_s2,
            "A cam turns at constant speed and repeats its motion; this crank changes its speed.",
            "Request the linkage at constant speed, without the acceleration.",
        )  # fmt: skip
    turn = SampledTurn.of(found, options.points, closed=False)
    stroke, ram = float(found.stroke_mm or 0.0), turn.motion.ram[0]
    motion = {
        "kind": "table",
        "angle_deg": 360.0,
        "angles_deg": np.degrees(turn.turned).tolist(),
        "displacements_mm": (ram - ram.min()).tolist(),
        "tolerance_mm": options.tolerance_mm or TOLERANCE * stroke,
    }
    roller, angle_deg = options.roller_radius_mm or ROLLER * stroke, options.pressure_angle_deg
    return _json(
        {
            "name": f"{found.name.strip() or 'shaper'}: motion of the ram",
            "speed_rpm": found.spec.speed_rpm,
            "rotation": found.spec.rotation,
            "program": [motion],
            "follower": {"kind": "translating_roller", "roller_radius_mm": roller},
            "limits": [{"kind": "pressure_angle", "rise_deg": angle_deg, "return_deg": angle_deg}],
        }
    )


def _json(body: dict[str, Any]) -> bytes:
    return json.dumps(body, ensure_ascii=False, allow_nan=False).encode() + b"\n"
