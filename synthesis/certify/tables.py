"""Tables that segments were asked to follow."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from synthesis.certify.course import Course
from synthesis.design import Extreme
from synthesis.limits.base import Machine
from synthesis.units import DEGREE


def tables(course: Course, machine: Machine) -> list[Extreme]:
    """How far the motion passes each table at its worst row."""
    return list(_deviations(course, machine))


def _deviations(course: Course, machine: Machine) -> Iterator[Extreme]:
    for stretch in course.motion.stretches:
        if stretch.readings is None:
            continue
        theta = stretch.start + stretch.angle * stretch.readings.x
        miss = course.curve(theta) - stretch.readings.s
        worst, to_wire = int(np.argmax(np.abs(miss))), machine.rate(0)
        value, bound = float(np.abs(miss[worst])) * to_wire, stretch.readings.tolerance * to_wire
        yield Extreme(
            limit="table_deviation", value=value, unit=machine.told(0),
            angle_deg=theta[worst] / DEGREE, bound=bound, margin=bound - value, width=0.0,
            holds=value <= bound,
            evidence=f"all {len(miss)} rows of the table; the worst is row {worst}",
            field=f"program/{stretch.index}/{stretch.readings.field}",
        )  # fmt: skip
