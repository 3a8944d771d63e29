"""The columns of tables: one list for every tabular format."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from synthesis.exporters.options import CurveOptions, MotionOptions, is_cutter, is_pitch
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.placement import placed
from synthesis.exporters.samples.sampling import Rows, motion_rows, table_rows
from synthesis.exporters.samples.turn import Turn
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

POWERS = str.maketrans("²³", "23")


@dataclass(frozen=True, eq=False)
class Column:
    """One column: its name with the unit in it, the unit, what it means, and (n,) values."""

    name: str
    unit: str
    meaning: str
    values: Array | NDArray[np.int64]


def joined(parts: Sequence[Sequence[Column]]) -> list[Column]:
    """One table of several with the same columns, each after the one before."""
    return [
        replace(same[0], values=np.concatenate([column.values for column in same]))
        for same in zip(*parts, strict=True)
    ]


def profile_columns(cam: Cam, options: CurveOptions) -> list[Column]:
    """The curve's points with the motion and the geometry there."""
    rows = table_rows(cam, options)
    at = cam.at(rows.theta, rows.left)
    x, y = placed(cam, options, at)
    which = _which(options)
    if options.turn_deg == 0.0:
        frame = f"{which}, in the cam's frame"
    else:
        frame = f"{which}, turned by {options.turn_deg:.12g}° from the cam's frame"
    return [
        _angle(rows),
        *_physical(at.s, cam),
        Column("x_mm", "mm", frame, x),
        Column("y_mm", "mm", frame, y),
        *_axial(rows, options.z_mm),
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
        _side(rows),
    ]  # fmt: skip


def _which(options: CurveOptions) -> str:
    if is_cutter(options.curve):
        return f"path of the centre of a cutter of {options.cutter_diameter_mm:.12g} mm diameter"
    return "pitch curve" if is_pitch(options.curve) else "profile"


def motion_columns(turn: Turn, options: MotionOptions) -> list[Column]:
    """The follower's motion at the given speed, and per radian of cam angle."""
    rows = motion_rows(turn, options.count)
    s = turn.derivatives(rows.theta, rows.left)
    return [_angle(rows), *_physical(s, turn), *_per_radian(s, turn), _side(rows)]


def _axial(rows: Rows, z_mm: float | None) -> list[Column]:
    """z, where it is asked for."""
    if z_mm is None:
        return []
    return [Column("z_mm", "mm", "position along the axis", np.full(len(rows.theta), z_mm))]


def _angle(rows: Rows) -> Column:
    return Column("theta_deg", "deg", "cam angle", rows.degrees)


def _side(rows: Rows) -> Column:
    meaning = "-1 and 1: limits from the left and from the right of a jump; otherwise 0"
    return Column("side", "1", meaning, rows.side)


def _physical(s: Array, turn: Turn) -> list[Column]:
    told = ("displacement from the lowest position", "velocity", "acceleration", "jerk")
    return [
        Column(named(letter, unit), unit, told[order], s[order] * turn.rate(order))
        for order, letter in enumerate("svaj")
        for unit in [turn.travel.derivative_unit(order)]
    ]


def _per_radian(s: Array, turn: Turn) -> list[Column]:
    told = ("first", "second", "third")
    return [
        Column(
            named(letter, unit), unit, f"{told[order - 1]} derivative of s by the cam angle",
            s[order] / turn.travel.per_unit,
        )
        for order, letter in enumerate(("ds", "d2s", "d3s"), start=1)
        for unit in [turn.travel.derivative_unit(order).replace("/s", "/rad")]
    ]  # fmt: skip


def named(letter: str, unit: str) -> str:
    """A column's name: ``a_mm_per_s2`` for a in mm/s²."""
    return f"{letter}_{unit}".replace("/", "_per_").translate(POWERS)
