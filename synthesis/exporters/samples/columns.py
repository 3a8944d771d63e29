"""The columns of tables, for every tabular format: curve, motion, forces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from synthesis.catalogue.followers.kinematics import labelled
from synthesis.catalogue.forces.reduced import ForceHistory, history
from synthesis.design.design import Design
from synthesis.exporters.options import CurveOptions, MotionOptions, is_cutter, is_pitch
from synthesis.exporters.samples.cam import Cam, Turn
from synthesis.exporters.samples.sampling import (
    Rows,
    in_degrees,
    motion_rows,
    place_on_shaft,
    table_rows,
)
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

POWERS = str.maketrans("²³", "23")
PER_RADIAN = (("ds", "first"), ("d2s", "second"), ("d3s", "third"))
# Forces by their names in ``ForceHistory``: name of the column, its unit, what it means.
FORCES = {
    "drive": ("drive", "N", "force that the cam gives along the motion"),
    "torque": ("torque", "N m", "torque on the camshaft"),
    "contact": (
        "contact_force", "N", "force along the common normal; negative where the flank does not "
        "touch",
    ),
    "pressure": ("hertz_pressure", "MPa", "Hertz pressure"),
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Column:
    """One column: its name with the unit in it, the unit, what it means, and (n,) values."""

    name: str
    unit: str
    meaning: str
    values: Array | NDArray[np.int64]


def concatenate(parts: Sequence[Sequence[Column]]) -> list[Column]:
    """One table of several with the same columns, each after the one before."""
    return [
        replace(same[0], values=np.concatenate([column.values for column in same]))
        for same in zip(*parts, strict=True)
    ]


def profile_columns(cam: Cam, options: CurveOptions) -> list[Column]:
    """The curve's points with the motion and the geometry there."""
    rows = table_rows(cam, options)
    at = cam.at(rows.theta, rows.left)
    x, y = place_on_shaft(cam, options, at)
    if is_cutter(options.curve):
        curve = f"path of the centre of a cutter of {options.cutter_diameter_mm:.12g} mm diameter"
    else:
        curve = "pitch curve" if is_pitch(options.curve) else "profile"
    place = f"turned by {options.turn_deg:.12g}° from" if options.turn_deg else "in"
    frame = f"{curve}, {place} the cam's frame"
    columns = [
        *_derivatives(at.s, cam), Column("x_mm", "mm", frame, x), Column("y_mm", "mm", frame, y)
    ]  # fmt: skip
    if options.z_mm is not None:
        z = np.full(len(rows.theta), options.z_mm)
        columns.append(Column("z_mm", "mm", "position along the axis", z))
    columns += [
        Column(
            "pressure_angle_deg", "deg",
            "signed; positive where the cam pushes against a rise", at.pressure_angle / DEGREE,
        ),
        Column(
            "pitch_curvature_per_mm", "1/mm",
            "signed curvature of the pitch curve; convex positive", at.curvature,
        ),
        Column(
            "profile_radius_mm", "mm",
            "signed radius of curvature of the profile; infinite where it is straight", at.radius,
        ),
    ]  # fmt: skip
    return _at_rows(rows, columns)


def motion_columns(turn: Turn, options: MotionOptions) -> list[Column]:
    """The follower's motion at the given speed, and per radian of cam angle."""
    rows = motion_rows(turn, options.count)
    s = turn.derivatives(rows.theta, rows.left)
    columns = _derivatives(s, turn)
    for order, (name, count) in enumerate(PER_RADIAN, start=1):
        unit = turn.travel.derivative_unit(order).replace("/s", "/rad")
        meaning = f"{count} derivative of s by the cam angle"
        values = s[order] / turn.travel.per_unit
        columns.append(Column(column_name(name, unit), unit, meaning, values))
    return _at_rows(rows, columns)


def motion_table(turn: Turn, options: MotionOptions, more: Sequence[Column] = ()) -> list[Column]:
    """The motion's columns and ``more`` of the same rows, over all turns asked for, and the time.

    A turn's first row is the last one of the turn before, and is left out, unless something jumps
    there: then both are kept, as the limits from the left and from the right.
    """
    columns = [*motion_columns(turn, options), *more]
    side = columns[-1 - len(more)].values
    again = np.arange(len(side))[int(side[0] == 0) :]
    rows = np.concatenate([np.arange(len(side)), *(again,) * (options.turns - 1)])
    number = np.repeat(
        np.arange(options.turns), [len(side)] + [len(again)] * (options.turns - 1)
    )  # of the turn
    steps = {0: 360.0, 1: turn.advance / turn.travel.per_unit}  # of the cam angle and of s
    columns = [
        replace(each, values=each.values[rows] + (number * steps[k] if steps.get(k) else 0))
        for k, each in enumerate(columns)
    ]
    speed = float(in_degrees(np.array(turn.omega)))  # deg/s
    meaning = "time since cam angle 0"
    return [*columns, Column("time_s", "s", meaning, columns[0].values / speed)]


def _at_rows(rows: Rows, columns: list[Column]) -> list[Column]:
    """The columns between those of the cam angle and of the side of a jump."""
    meaning = "-1 and 1: limits from the left and from the right of a jump; otherwise 0"
    angle = Column("theta_deg", "deg", "cam angle", rows.degrees)
    return [angle, *columns, Column("side", "1", meaning, rows.side)]


def _derivatives(s: Array, turn: Turn) -> list[Column]:
    """s and its derivatives by time, from (4, n) of them per radian."""
    meanings = ("displacement from the lowest position", "velocity", "acceleration", "jerk")
    units = map(turn.travel.derivative_unit, range(4))
    return [
        Column(column_name(letter, unit), unit, meaning, s[order] * turn.rate(order))
        for order, (letter, unit, meaning) in enumerate(zip("svaj", units, meanings, strict=True))
    ]


def column_name(letter: str, unit: str) -> str:
    """A column's name: ``a_mm_per_s2`` for a in mm/s²."""
    return f"{letter}_{unit}".replace("/", "_per_").translate(POWERS)


def force_samples(design: Design, cam: Cam, rows: Rows) -> dict[tuple[str, str], Array]:
    """Forces at every row, from the side the row is of; none where the spec has no load.

    By name in ``ForceHistory`` and flank, "" where it is the whole cam's.
    """
    machine = design.completed_spec.machine()
    if machine.load is None:
        return {}
    given = machine.follower, machine.load, machine.omega, cam.motion, cam.size, rows.theta
    left, right = (history(*given, side) for side in ("left", "right"))

    def by_flank(of: ForceHistory, name: str) -> dict[str, Array]:
        force = getattr(of, name)
        return force if isinstance(force, dict) else {"": force}

    return {
        (name, flank): np.where(rows.left, before, by_flank(right, name)[flank])
        for name in FORCES
        for flank, before in by_flank(left, name).items()
    }


def force_columns(design: Design, cam: Cam, options: MotionOptions) -> list[Column]:
    """Columns of forces for tables of the motion; none where the spec has no load."""
    columns = []
    samples = force_samples(design, cam, motion_rows(cam, options.count))
    for (force, flank), values in samples.items():
        name, unit, meaning = FORCES[force]
        name = f"{labelled(name, flank)}_{unit.lower().replace(' ', '_')}"
        columns.append(Column(name, unit, meaning, values))
    return columns
