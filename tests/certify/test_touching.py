"""Limits that touch: margin 0 is not certified, a margin of 1e-7 is."""

import pytest
from hypothesis import given

from synthesis.catalogue.limits import (
    Acceleration,
    CutterRadius,
    Jerk,
    OuterRadius,
    PressureAngle,
    ProfileRadius,
    Velocity,
)
from synthesis.catalogue.limits.base import Claim
from synthesis.certify import certificate, certify
from synthesis.numerics.enclosure import Enclosure, Extremum
from tests.certify.cams import Cam, cams

# the limit at a value, and +1 where a larger bound is a looser one
LIMITS = {
    "pressure_angle": (lambda v: PressureAngle(rise_deg=v), 1),
    "velocity": (lambda v: Velocity(max_mm_per_s=v), 1),
    "acceleration": (lambda v: Acceleration(max_mm_per_s2=v), 1),
    "jerk": (lambda v: Jerk(max_mm_per_s3=v), 1),
    "outer_radius": (lambda v: OuterRadius(max_mm=v), 1),
    "profile_radius": (lambda v: ProfileRadius(min_mm=v), -1),
    "cutter_radius": (lambda v: CutterRadius(radius_mm=v), -1),
}


@pytest.mark.parametrize("name", sorted(LIMITS))
@given(cams())
def test_touched_and_not_quite_touched(name, cam: Cam):
    limit_at, looser = LIMITS[name]

    def judged(value: float):
        return certify(cam.motion, cam.machine, cam.size, [limit_at(value)])[0]

    found = judged(0.01 if name == "profile_radius" else cam.roller + 1.0)
    if found.value is None or not 1e-3 < abs(found.value) < 1e7:
        return
    value = abs(found.value)
    if name == "profile_radius" and found.value < 0.0:
        return
    assert not judged(value).holds
    assert not judged(value * (1.0 - looser * 1e-7)).holds
    # relative to the core's quantity, which is the pitch curve's for both radii
    slack = looser * 1e-7 * (value + cam.roller) / value
    assert judged(value * (1.0 + slack)).holds


@pytest.mark.parametrize(
    ("side", "bound", "holds"),
    [
        (1, 1.25, True),
        (1, 1.15, False),
        (1, 1.05, False),
        (1, 0.9, False),
        (-1, 0.7, True),
        (-1, 0.95, False),
    ],
)
def test_the_whole_enclosure_must_satisfy_the_bound(side, bound, holds):
    claim = Claim(
        "velocity", "velocity", (0,), bound if side < 0 else None, bound if side > 0 else None,
        "mm/s", lambda v: 3.0 * v, "velocity/max_mm_per_s",
    )  # fmt: skip
    extreme = certificate._line(claim, Extremum(Enclosure(1.0, 0.9, 1.1, 2.0), side, 7))
    assert extreme.holds == holds
    assert extreme.width == pytest.approx(0.6)
    assert extreme.margin == pytest.approx(3.0 * side * (bound - 1.0))
    assert extreme.bound == pytest.approx(3.0 * bound)


def test_an_extreme_without_a_value_on_the_wire_is_judged_in_the_core():
    claim = Claim(
        "cutter_radius", "pitch_curvature", (0,), -0.1, None, "mm",
        lambda k: 5.0 - 1.0 / k if k < 0.0 else None, "cutter_radius/radius_mm",
    )  # fmt: skip
    for ends in ((0.2, 0.1, 0.3), (1e-12, -1e-12, 1e-11)):
        extreme = certificate._line(claim, Extremum(Enclosure(*ends, 2.0), -1, 7))
        assert (extreme.value, extreme.margin, extreme.holds) == (None, None, True)
    extreme = certificate._line(claim, Extremum(Enclosure(0.01, -0.1 - 1e-9, 0.02, 2.0), -1, 7))
    assert not extreme.holds
