"""The motion of a shaper, sampled over a turn of its crank, and its tables: CSV and JSON."""

from __future__ import annotations

import json
from dataclasses import dataclass

import numpy as np

from synthesis.exporters.exporter import untold
from synthesis.exporters.options import MotionOptions
from synthesis.exporters.samples.columns import Column
from synthesis.exporters.tables.csv_table import table
from synthesis.machines.linkages.files.linkage_file import LinkageFile
from synthesis.machines.linkages.shaper import SixBarShaper
from synthesis.machines.linkages.shaper.drive import Drive
from synthesis.machines.linkages.shaper.mechanism import Motion, Shaper, angle
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE, FULL_TURN


@dataclass(frozen=True, eq=False)
class Rows:
    """A shaper at evenly spaced angles of a turn.

    Attributes:
        turned: (n,) angle turned by the crank since its start [rad].
    """

    shaper: Shaper
    drive: Drive
    turned: Array
    motion: Motion

    @classmethod
    def of(cls, found: SixBarShaper, count: int, closed: bool = True) -> Rows:
        """``count`` rows of a turn, and its end too where it is to be closed."""
        shaper, drive = found.spec.shaper(found.dimensions), found.spec.drive
        turned = FULL_TURN * np.arange(count + closed) / count
        return cls(shaper, drive, turned, shaper.motion(drive.phi(turned)))

    @property
    def guide(self) -> Array:
        """ψ [rad]."""
        return angle(self.motion.guide)

    @property
    def coupler(self) -> Array:
        """γ [rad]."""
        return angle(self.motion.coupler)

    @property
    def coupler_slope(self) -> Array:
        """Angle between coupler and the ram's line, signed, within ±90° [rad]."""
        return np.asarray(np.arcsin(self.motion.coupler[1]))

    @property
    def velocity(self) -> Array:
        """Of the ram [mm/s]."""
        return np.asarray(self.drive.first(self.motion.ram[1], self.turned))

    @property
    def acceleration(self) -> Array:
        """Of the ram [mm/s²]."""
        return np.asarray(self.drive.second(*self.motion.ram[1:], self.turned))

    def columns(self) -> list[Column]:
        """All quantities as columns of a table."""
        motion, drive, turned = self.motion, self.drive, self.turned
        transmission = 90.0 - np.abs(self.coupler_slope) / DEGREE

        def first(rate: Array) -> Array:
            return np.asarray(drive.first(rate, turned)) / DEGREE

        def second(rates: tuple[Array, Array]) -> Array:
            return np.asarray(drive.second(*rates, turned)) / DEGREE

        rows = (
            ("crank_travel_deg", "deg", "angle turned by the crank", turned / DEGREE),
            ("crank_deg", "deg", "crank angle", drive.phi(turned) / DEGREE),
            ("time_s", "s", "time since the start of the turn", drive.time(turned)),
            ("ram_mm", "mm", "position of the ram's pin", motion.ram[0]),
            ("ram_mm_per_s", "mm/s", "its velocity", self.velocity),
            ("ram_mm_per_s2", "mm/s²", "its acceleration", self.acceleration),
            ("guide_deg", "deg", "angle of the guide", self.guide / DEGREE),
            ("guide_deg_per_s", "deg/s", "its velocity", first(motion.guide_turn[0])),
            ("guide_deg_per_s2", "deg/s²", "its acceleration", second(motion.guide_turn)),
            ("coupler_deg", "deg", "angle of the coupler", self.coupler / DEGREE),
            ("coupler_deg_per_s", "deg/s", "its velocity", first(motion.coupler_turn[0])),
            ("coupler_deg_per_s2", "deg/s²", "its acceleration", second(motion.coupler_turn)),
            ("slide_mm", "mm", "crank's pin to the guide's pivot", motion.slide[0]),
            ("slide_mm_per_s", "mm/s", "velocity of the block along the guide, not the ram's",
             drive.first(motion.slide[1], turned)),
            ("transmission_deg", "deg", "transmission angle at the ram", transmission),
        )  # fmt: skip
        return [Column(name, unit, told, np.asarray(values)) for name, unit, told, values in rows]


def _rows(found: SixBarShaper, options: MotionOptions) -> Rows:
    return Rows.of(found, max(36, round(options.count)))


def _csv(found: SixBarShaper, options: MotionOptions) -> bytes:
    return table(_rows(found, options).columns())


def _json(found: SixBarShaper, options: MotionOptions) -> bytes:
    columns = _rows(found, options).columns()
    body = {
        "kind": "shaper motion",
        "shaper": {"id": found.id, "name": found.name, "status": found.status},
        "dimensions": found.dimensions,
        "rotation": found.spec.rotation,
        "rows": len(columns[0].values),
        "columns": [
            {"name": c.name, "unit": c.unit, "meaning": c.meaning, "values": c.values.tolist()}
            for c in columns
        ],
    }
    return json.dumps(body, ensure_ascii=False, allow_nan=False).encode() + b"\n"


CSV = LinkageFile(
    "motion.csv",
    "Table of the motion",
    "text/csv; charset=utf-8; header=present",
    ".csv",
    untold(_csv),
    MotionOptions,
)
JSON = LinkageFile(
    "motion.json",
    "Table of the motion, with units and meanings",
    "application/json",
    ".json",
    untold(_json),
    MotionOptions,
)
