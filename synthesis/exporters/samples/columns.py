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
from synthesis.exporters.samples.sampling import Rows, motion_rows, place_on_shaft, table_rows
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
    axial = []
    if options.z_mm is not None:
        z = np.full(len(rows.theta), options.z_mm)
        axial.append(Column("z_mm", "mm", "position along the axis", z))
    return [
        _angle(rows),
        *_physical(at.s, cam),
        Column("x_mm", "mm", frame, x),
        Column("y_mm", "mm", frame, y),
        *axial,
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


def motion_columns(turn: Turn, options: MotionOptions) -> list[Column]:
    """The follower's motion at the given speed, and per radian of cam angle."""
    rows = motion_rows(turn, options.count)
    s = turn.derivatives(rows.theta, rows.left)
    return [_angle(rows), *_physical(s, turn), *_per_radian(s, turn), _side(rows)]


def _angle(rows: Rows) -> Column:
    return Column("theta_deg", "deg", "cam angle", rows.degrees)


def _side(rows: Rows) -> Column:
    meaning = "-1 and 1: limits from the left and from the right of a jump; otherwise 0"
    return Column("side", "1", meaning, rows.side)


def _physical(s: Array, turn: Turn) -> list[Column]:
    meanings = ("displacement from the lowest position", "velocity", "acceleration", "jerk")
    return [
        Column(column_name(letter, unit), unit, meaning, s[order] * turn.rate(order))
        for order, (letter, meaning) in enumerate(zip("svaj", meanings, strict=True))
        for unit in [turn.travel.derivative_unit(order)]
    ]


def _per_radian(s: Array, turn: Turn) -> list[Column]:
    names = (("ds", "first"), ("d2s", "second"), ("d3s", "third"))
    return [
        Column(
            column_name(letter, unit), unit, f"{count} derivative of s by the cam angle",
            s[order] / turn.travel.per_unit,
        )
        for order, (letter, count) in enumerate(names, start=1)
        for unit in [turn.travel.derivative_unit(order).replace("/s", "/rad")]
    ]  # fmt: skip


def column_name(letter: str, unit: str) -> str:
    """A column's name: ``a_mm_per_s2`` for a in mm/s²."""
    return f"{letter}_{unit}".replace("/", "_per_").translate(POWERS)


@dataclass(frozen=True, eq=False)
class ForceSamples:
    """What the cam of a design bears, at rows.

    Attributes:
        right, left: forces as limits from the right and from the left.
    """

    rows: Rows
    right: ForceHistory
    left: ForceHistory

    @classmethod
    def of(cls, design: Design, cam: Cam, options: MotionOptions) -> ForceSamples | None:
        """The forces at the rows of a table; None where the spec has no load."""
        machine = design.completed_spec.machine()
        if machine.load is None:
            return None
        rows = table_rows(cam, options)
        right, left = (
            history(
                machine.follower, machine.load, machine.omega, cam.motion, cam.size, rows.theta,
                side,
            )
            for side in ("right", "left")
        )  # fmt: skip
        return cls(rows, right, left)

    def value(self, name: str, flank: str | None = None) -> Array:
        """A force, by its name in ``ForceHistory``, at every row, from the side the row is of."""
        left, right = getattr(self.left, name), getattr(self.right, name)
        if flank is not None:
            left, right = left[flank], right[flank]
        return np.asarray(np.where(self.rows.left, left, right))


def force_columns(design: Design, cam: Cam, options: MotionOptions) -> list[Column]:
    """Columns of forces for tables of the motion; none where the spec has no load."""
    forces = ForceSamples.of(design, cam, options)
    if forces is None:
        return []
    return [
        Column(
            "drive_n", "N", "force that the cam gives along the motion",
            forces.value("drive"),
        ),
        Column("torque_n_m", "N m", "torque on the camshaft", forces.value("torque")),
        *(
            Column(
                f"{labelled('contact_force', name)}_n", "N",
                "force along the common normal; negative where the flank does not touch",
                forces.value("contact", name),
            )
            for name in forces.right.contact
        ),
        *(
            Column(
                f"{labelled('hertz_pressure', name)}_mpa", "MPa", "Hertz pressure",
                forces.value("pressure", name),
            )
            for name in forces.right.pressure
        ),
    ]  # fmt: skip
