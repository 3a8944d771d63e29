"""Parts of segments: where they end at junctions, and what counts as a jump there."""

from __future__ import annotations

import numpy as np
import pytest

from synthesis.certify.piecewise_motion import PiecewiseMotion
from tests.certify.cams import motion_of, spline


@pytest.mark.parametrize("seed", range(12))
def test_a_part_that_ends_at_a_junction_has_it_whatever_rounding_does(seed: int) -> None:
    rng = np.random.default_rng(seed)
    breaks = np.concatenate([[0.0], np.sort(rng.uniform(0.05, 0.95, 7)), [1.0]])
    angles = rng.uniform(20.0, 100.0, 3)
    motion = PiecewiseMotion(
        motion_of([
            ("dwell", angles[0], 0.0, None), ("rise", angles[1], 7.0, spline(3, breaks)),
            ("return", angles[2], 7.0, spline(3, breaks)),
        ])
    )  # fmt: skip
    for segment in (1, 2):
        whole = motion.junctions_of([segment])
        assert motion.junctions_of([segment], (0.0, 1.0)).tolist() == whole.tolist()
        for i in range(len(breaks) - 1):
            for j in range(i + 1, len(breaks)):
                found = motion.junctions_of([segment], (float(breaks[i]), float(breaks[j])))
                assert found.tolist() == whole[i : j + 1].tolist()
        # the same for parts that begin or end beside a junction by a few roundings
        start, angle = motion.segments[segment].start, motion.segments[segment].angle
        for off in (-12.0, -3.0, 3.0, 12.0):
            part = motion.curve.breaks[whole[[2, 5]] + 1] + off * 2.0**-53 - start
            found = motion.junctions_of([segment], (part[0] / angle, part[1] / angle))
            assert found.tolist() == whole[2:6].tolist()


def test_a_jump_is_measured_by_the_lift_beside_it_and_between_dwells_by_the_stroke() -> None:
    smooth = spline(3, np.linspace(0.0, 1.0, 5))
    motion = PiecewiseMotion(
        motion_of([
            ("rise", 50.0, 5.0, smooth), ("dwell", 20.0, 0.0, None), ("dwell", 30.0, 0.0, None),
            ("rise", 60.0, 35.0, smooth), ("dwell", 25.0, 0.0, None),
            ("return", 175.0, 40.0, smooth),
        ])
    )  # fmt: skip
    assert motion.stroke == 40.0
    # pieces: 4 of the rise, 2 dwells, 4, 1, 4; junction i follows piece i
    for junction, scale in ((3, 5.0), (4, 40.0), (5, 35.0), (9, 35.0), (10, 40.0)):
        jump = motion.largest_jump(0, np.array([junction]))
        assert jump.allowed == pytest.approx(1e-9 * scale, rel=1e-3)
