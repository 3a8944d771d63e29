"""A follower train's response as a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synthesis.exporters.samples.columns import Column
from synthesis.exporters.tables.csv_table import table
from synthesis.machines.dynamics.polydyne import polydyne
from synthesis.machines.dynamics.report import TrainResponse, output_acceleration
from synthesis.machines.dynamics.response import Response, Steps, from_rest, steady
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE, FULL_TURN, rad_per_s

MEDIA_TYPE = "text/csv; charset=utf-8; header=present"


@dataclass(frozen=True)
class TrainOptions:
    """What part of a response is written.

    Attributes:
        speed_rpm: None: the speed that the cam was designed for.
        turns: from rest; 0: the periodic response.
        points_per_degree: at least so many rows.
    """

    speed_rpm: float | None = None
    turns: int = 0
    points_per_degree: float = 2.0


def responses(found: TrainResponse, options: TrainOptions) -> list[Response]:
    """The turns that the options select."""
    chain, omega = (
        found.spec.train.chain(),
        rad_per_s(options.speed_rpm or found.spec.cam.speed_rpm),
    )
    steps = Steps.of(found.cam.curve, int(np.ceil(360.0 * options.points_per_degree)))
    if options.turns == 0:
        return [steady(chain, steps, omega)]
    return from_rest(chain, steps, omega, options.turns)


def response_csv(found: TrainResponse, options: TrainOptions) -> bytes:
    """Cam, masses and contact force; a cam angle with an impact has two rows."""
    turns = responses(found, options)
    count = found.spec.train.chain().count
    columns = [
        _column("turn", "", "from 0",
                [np.full(len(t.theta), float(k)) for k, t in enumerate(turns)]),
        _column("angle_deg", "deg", "cam angle", [t.theta / DEGREE for t in turns]),
        _column("time_s", "s", "time from the beginning",
                [(t.theta + k * FULL_TURN) / t.omega for k, t in enumerate(turns)]),
        _column("cam_mm", "mm", "motion of the cam", [t.steps.s[0] for t in turns]),
        *(
            _column(f"mass_{i + 1}_mm", "mm", "displacement of a mass",
                    [t.deflection[i] + t.steps.s[0] for t in turns])
            for i in range(count)
        ),
        _column("output_error_mm", "mm", "output minus cam", [t.deflection[-1] for t in turns]),
        _column("output_acceleration_mm_per_s2", "mm/s²", "of the last mass",
                [output_acceleration(t) for t in turns]),
        _column("contact_force_n", "N", "between cam and train; negative: the train pulls",
                [t.contact_force for t in turns]),
    ]  # fmt: skip
    return table(columns)


def polydyne_csv(found: TrainResponse, options: TrainOptions) -> bytes:
    """The polydyne cam motion: with it the output moves as the motion of the spec's cam.

    Raises:
        InputError: it would not be smooth, or has no closed form.
    """
    omega, motion = rad_per_s(options.speed_rpm or found.spec.cam.speed_rpm), found.cam.curve
    motion_of_cam = polydyne(found.spec.train.chain(), motion, omega)
    theta = Steps.of(motion, int(np.ceil(360.0 * options.points_per_degree))).theta
    s = motion_of_cam.derivatives(theta)
    return table(
        [
            Column("angle_deg", "deg", "cam angle", theta / DEGREE),
            Column("output_mm", "mm", "motion of the last mass", motion.derivatives(theta, 0)[0]),
            Column("cam_mm", "mm", "motion of the cam", s[0]),
            Column("cam_velocity_mm_per_s", "mm/s", "its velocity", s[1] * omega),
            Column("cam_acceleration_mm_per_s2", "mm/s²", "its acceleration", s[2] * omega**2),
        ]
    )


def _column(name: str, unit: str, meaning: str, parts: Sequence[Array]) -> Column:
    return Column(name, unit, meaning, np.concatenate(parts))
