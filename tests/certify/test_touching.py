"""Limits that touch: margin 0 is not certified, a margin of 1e-7 is."""

import pytest
from hypothesis import given

from synthesis.certify import certify
from synthesis.limits import (
    Acceleration,
    CutterRadius,
    Jerk,
    OuterRadius,
    PressureAngle,
    ProfileRadius,
    Velocity,
)
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
