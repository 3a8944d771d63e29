"""Tables that segments were asked to follow."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from synthesis.certify.course import Course
from synthesis.design import Extreme
from synthesis.units import DEGREE


def tables(course: Course) -> list[Extreme]:
    """How far the motion passes each table at its worst row."""
    return list(_deviations(course))


def _deviations(course: Course) -> Iterator[Extreme]:
    for stretch in course.motion.stretches:
        if stretch.readings is None:
            continue
        theta = stretch.start + stretch.angle * stretch.readings.x
        miss = course.curve(theta) - stretch.readings.s
        worst, bound = int(np.argmax(np.abs(miss))), stretch.readings.tolerance
        value = float(np.abs(miss[worst]))
        yield Extreme(
            limit="table_deviation", value=value, unit="mm", angle_deg=theta[worst] / DEGREE,
            bound=bound, margin=bound - value, width=0.0, holds=value <= bound,
            evidence=f"all {len(miss)} rows of the table; the worst is row {worst}",
            field=f"program/{stretch.index}/tolerance_mm",
        )  # fmt: skip
