"""Lines of the certificate about what has no finite enclosure."""

import math

import pytest

from synthesis.catalogue.limits.base import Claim
from synthesis.certify import certificate, measure_objective, objectives
from synthesis.numerics.enclosure import Enclosure, Extremum
from tests.certify.test_spikes import QUIET


def test_a_pressure_angle_that_may_reach_a_right_angle_has_an_endless_slope(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    cam = QUIET
    for upper, endless in ((1.5707, False), (1.5709, True), (1.58, True)):
        found = Enclosure(1.57, 1.56, upper, 2.0)
        monkeypatch.setattr(objectives, "_peak_on", lambda *_, found=found, **__: found)
        slope = measure_objective("pressure_slope", cam.motion, cam.machine, cam.size)
        assert slope.lower < slope.value < slope.upper
        assert math.isinf(slope.upper) == endless


def test_of_two_curves_the_one_that_may_slope_most_is_the_slope(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    cam = QUIET
    each = {"narrow": Enclosure(0.5, 0.49, 0.51, 1.0), "wide": Enclosure(0.48, 0.2, 0.9, 2.0)}
    monkeypatch.setattr(objectives, "paths", lambda _: each)
    monkeypatch.setattr(objectives, "_peak_on", lambda _, __, ___, path: each[path])
    slope = measure_objective("pressure_slope", cam.motion, cam.machine, cam.size)
    assert (slope.value, slope.upper) == (math.tan(0.48), math.tan(0.9))


def test_an_extreme_whose_enclosure_is_endless_is_not_proven():
    claim = Claim("jerk", "jerk", (0,), -3.0, 7.0, "mm/s³", lambda v: v, "jerk/max_mm_per_s3")
    for side in (1, -1):
        for ends in ((1.0, 1.0, math.inf), (1.0, -math.inf, 1.0), (math.nan, math.nan, math.nan)):
            extreme = certificate._line(claim, Extremum(Enclosure(*ends, 2.0), side, 7))
            assert (extreme.value, extreme.margin, extreme.holds) == (None, None, False)
            assert "no enclosure" in extreme.evidence
    for ends, bound in (((-3.0, 7.0), 7.0), ((None, 7.0), 7.0), ((-3.0, None), -3.0)):
        claim = Claim("jerk", "jerk", (0,), *ends, "mm/s³", lambda v: v, "jerk/max_mm_per_s3")
        assert certificate._unproven(claim, 0.0, "").bound == bound
