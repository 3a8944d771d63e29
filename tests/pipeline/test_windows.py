"""Windows and points from the spec to the certificate, measured here from the motion itself."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from synthesis import DesignSpec, analyse, synthesise
from synthesis.catalogue.motion import Motion
from synthesis.certify import certify
from synthesis.design.design import Design, Extreme

pytestmark = pytest.mark.usefixtures("coarse_conflicts")

RPM = 83.7
OMEGA = RPM * pi / 30.0
UP, TOP, DOWN, LIFT = 63.7, 31.1, 71.9, 27.3
LIMITS = [
    {"kind": "pressure_angle", "rise_deg": 31.0, "return_deg": 39.0},
    {"kind": "jerk", "max_mm_per_s3": 1.1e6},
]


def cam(
    up: dict[str, Any] | None = None, down: dict[str, Any] | None = None, **more: Any
) -> DesignSpec:
    body = {
        "speed_rpm": RPM,
        "program": [
            {"kind": "rise", "angle_deg": UP, "lift_mm": LIFT, **(up or {})},
            {"kind": "dwell", "angle_deg": TOP},
            {"kind": "return", "angle_deg": DOWN, "lift_mm": LIFT, **(down or {})},
            {"kind": "dwell", "angle_deg": 360.0 - UP - TOP - DOWN},
        ],
        "follower": {"kind": "translating_roller", "roller_radius_mm": 9.1},
        "limits": LIMITS,
        "tolerance": 4e-3,
    }
    return DesignSpec.model_validate(body | more)


def extreme(design: Design, field: str) -> Extreme:
    (found,) = (e for e in design.extremes if e.field == field)
    return found


def motion_at(design: Design, degrees: Any, order: int) -> np.ndarray:
    """The order-th time derivative at cam angles [deg]."""
    theta = np.radians(np.atleast_1d(np.asarray(degrees, dtype=float)))
    return design.curve.derivatives(theta, 3)[order] * OMEGA**order


@pytest.mark.parametrize("smoothness", [2, 3, 4])
def test_a_point_is_passed_exactly(smoothness: int) -> None:
    law = {"kind": "spline", "smoothness": smoothness}
    up = {"law": law, "points": [{"angle_deg": 20.3, "travel_mm": 9.7}]}
    point = {"angle_deg": 33.7, "travel_mm": 12.9, "velocity_mm_per_s": -310.0}
    design = synthesise(cam(up, {"law": law, "points": [point]}, tolerance=0.05))
    assert design.status == "optimal"
    assert "all motion laws" in design.certificate.bound_valid_for
    assert motion_at(design, 20.3, 0) == pytest.approx(9.7, abs=1e-9 * LIFT)
    down = UP + TOP + 33.7
    assert motion_at(design, down, 0) == pytest.approx(LIFT - 12.9, abs=1e-9 * LIFT)
    assert motion_at(design, down, 1) == pytest.approx(-310.0, rel=1e-9)
    reported = extreme(design, "program/2/points/0/travel_mm")
    assert reported.value == pytest.approx(12.9, abs=1e-9 * LIFT)
    assert reported.angle_deg == pytest.approx(down)
    assert reported.holds
    assert reported.width <= reported.margin <= 1.001e-9 * LIFT


def test_a_tolerance_is_used_and_kept() -> None:
    point = {"angle_deg": 20.3, "travel_mm": 9.7, "tolerance_mm": 0.31}
    loose = synthesise(cam({"points": [point]}))
    exact = synthesise(cam({"points": [{**point, "tolerance_mm": 0.0}]}))
    reported = extreme(loose, "program/0/points/0/tolerance_mm")
    assert reported.holds
    assert 9.39 <= motion_at(loose, 20.3, 0)[0] <= 9.3901
    assert loose.certificate.value < 0.95 * exact.certificate.value


@pytest.mark.parametrize(("smoothness", "sense"), [(2, 1.0), (3, 1.0), (4, 1.0), (2, -1.0)])
def test_a_velocity_is_held(smoothness: int, sense: float) -> None:
    windows = [{"from_deg": 22.1, "to_deg": 35.3, "velocity_mm_per_s": sense * 260.0}]
    move = {"law": {"kind": "spline", "smoothness": smoothness}, "windows": windows}
    sides = (move, None) if sense > 0.0 else (None, move)
    design = synthesise(cam(*sides, tolerance=0.02))
    start = 0.0 if sense > 0.0 else UP + TOP
    assert design.status == "optimal"
    inside = start + np.linspace(22.1, 35.3, 777)
    assert motion_at(design, inside, 1) == pytest.approx(sense * 260.0, rel=1e-9)
    index = 0 if sense > 0.0 else 2
    assert extreme(design, f"program/{index}/windows/0/velocity_mm_per_s").holds
    outside = motion_at(design, start + np.array([21.0, 36.4]), 1)
    assert np.all(abs(outside - sense * 260.0) > 1e-3)


def test_every_window_holds_all_along_and_only_there() -> None:
    windows = [
        {"from_deg": 3.3, "to_deg": 15.7, "jerk_mm_per_s3": {"min": -1e5, "max": 4.1e5}},
        {"from_deg": 22.1, "to_deg": 35.3, "velocity_mm_per_s": {"min": 200.0, "max": 300.0},
         "acceleration_mm_per_s2": {"max": 1500.0}},
        {"from_deg": 40.1, "to_deg": 45.9, "travel_mm": {"max": 20.9}},
    ]  # fmt: skip
    design = synthesise(cam({"windows": windows}))
    assert design.status == "optimal"
    for j, (order, name, side) in enumerate(
        [(3, "jerk_mm_per_s3", "max"), (1, "velocity_mm_per_s", "max"), (0, "travel_mm", "max")]
    ):
        window = windows[j]
        low, high = window["from_deg"], window["to_deg"]
        inside = motion_at(design, np.linspace(low + 1e-9, high - 1e-9, 4001), order)
        reported = extreme(design, f"program/0/windows/{j}/{name}/{side}")
        assert reported.value == pytest.approx(inside.max(), rel=1e-5)
        assert low <= reported.angle_deg <= high
        assert inside.max() <= window[name][side]
        everywhere = motion_at(design, np.linspace(0.0, UP, 4001), order)
        assert everywhere.max() > 1.05 * window[name][side]


def test_on_a_return_travel_counts_down() -> None:
    windows = [{"from_deg": 0.0, "to_deg": 30.1, "travel_mm": {"max": 4.3}}]
    design = synthesise(cam(None, {"windows": windows}))
    reported = extreme(design, "program/2/windows/0/travel_mm/max")
    fallen = LIFT - motion_at(design, UP + TOP + 30.1, 0)[0]
    assert reported.value == pytest.approx(fallen, abs=1e-9)
    assert reported.holds
    assert reported.margin == pytest.approx(4.3 - fallen, abs=1e-9)
    assert 4.2 < fallen <= 4.3


def test_points_on_a_given_law_are_checked() -> None:
    law = {"kind": "cycloidal"}
    on = 0.5 * LIFT
    good = cam({"law": law, "points": [{"angle_deg": UP / 2.0, "travel_mm": on}]})
    assert synthesise(good).status == "optimal"
    bad = cam({"law": law, "points": [{"angle_deg": 20.3, "travel_mm": 9.7}]})
    design = synthesise(bad)
    assert design.status == "infeasible"
    x = 20.3 / UP
    there = LIFT * (x - np.sin(2.0 * pi * x) / (2.0 * pi))
    reported = extreme(design, "program/0/points/0/travel_mm")
    assert reported.value == pytest.approx(there, rel=1e-12)
    assert not reported.holds
    (change,) = (r for r in design.conflict.relaxations if "points" in r.field)
    assert change.needed == pytest.approx(9.7 - there, rel=2e-4)


@pytest.mark.usefixtures("unmended")
def test_an_analysis_tells_of_windows() -> None:
    window = {"from_deg": 20.0, "to_deg": 40.0, "acceleration_mm_per_s2": {"min": -1e3}}
    cycloidal = {"law": {"kind": "cycloidal"}}
    found = analyse(cam({**cycloidal, "windows": [window]}, cycloidal, base_radius_mm=90.0,
                        follower={"kind": "translating_roller", "roller_radius_mm": 9.1,
                                  "offset_mm": 3.1}))  # fmt: skip
    (reported,) = (e for e in found.extremes if "windows" in e.field)
    x = 40.0 / UP
    a = LIFT / np.radians(UP) ** 2 * 2.0 * pi * np.sin(2.0 * pi * x) * OMEGA**2
    assert reported.value == pytest.approx(a, rel=1e-9)
    assert reported.angle_deg == pytest.approx(40.0)
    assert "program_0_window_0_acceleration_min" in found.violated


def test_a_conflict_names_windows_and_points_and_what_would_do(
    request: pytest.FixtureRequest,
) -> None:
    point = {"angle_deg": 12.3, "travel_mm": 12.0}
    design = synthesise(cam({"points": [point]}))
    assert design.status == "infeasible"
    assert set(design.conflict.limits) == {
        "jerk ≤ 1.1e+06 mm/s³", "program 0 point 0 travel = 12 mm"
    }  # fmt: skip
    needed = {r.field: r.needed for r in design.conflict.relaxations}
    eased = needed["program/0/points/0/travel_mm"]
    request.getfixturevalue("unexplained")
    spare = {"tolerance_mm": eased * 1.002}
    assert synthesise(cam({"points": [point | spare]})).status != "infeasible"
    tight = {"tolerance_mm": eased * 0.99}
    assert synthesise(cam({"points": [point | tight]})).status == "infeasible"


# -- the judge alone ------------------------------------------------------------------------------


def judged(spec: DesignSpec, motion: Motion, size: tuple[float, ...]) -> dict[str, Extreme]:
    return {e.field: e for e in certify(motion, spec.machine(), size, spec.all_limits())}


def test_the_judge_sees_a_breach_that_is_small_or_short() -> None:
    """A cam that keeps its window is held to windows a little tighter, longer, or moved."""
    window = {"from_deg": 22.1, "to_deg": 35.3, "velocity_mm_per_s": 260.0}
    design = synthesise(cam({"windows": [window]}, tolerance=0.05))
    field = "program/0/windows/0/velocity_mm_per_s"
    size = tuple(design.size)
    for change in ({"velocity_mm_per_s": 260.0 * (1.0 + 3e-9)}, {"to_deg": 35.3 + 0.01},
                   {"from_deg": 22.1 - 0.01}):  # fmt: skip
        spec = cam({"windows": [window | change]}, tolerance=0.05)
        assert not judged(spec, design.curve, size)[field].holds
    for change in ({"to_deg": 35.2}, {"from_deg": 22.2, "to_deg": 22.3}):
        spec = cam({"windows": [window | change]}, tolerance=0.05)
        assert judged(spec, design.curve, size)[field].holds


def test_a_window_that_ends_at_a_jump_sees_its_own_side() -> None:
    """The parabolic law's acceleration is 4 h/β² in the first half, −4 in the second."""
    parabolic, unit = {"law": {"kind": "parabolic"}}, LIFT / np.radians(UP) ** 2 * OMEGA**2
    bounds = {"min": -3.0 * unit, "max": 5.0 * unit}
    for first, last, value in ((2.0, UP / 2.0, 4.0), (UP / 2.0, 61.3, -4.0)):
        window = {"from_deg": first, "to_deg": last, "acceleration_mm_per_s2": bounds}
        spec = cam({**parabolic, "windows": [window]}, parabolic)
        reported = judged(spec, Motion.of(spec.placed_segments()), (0.0, 60.0))
        for side in bounds:
            found = reported[f"program/0/windows/0/acceleration_mm_per_s2/{side}"]
            assert found.value == pytest.approx(value * unit, rel=1e-12)
            assert found.holds == (side == "max" or value > 0.0)
    window = {"from_deg": 2.0, "to_deg": 61.3, "jerk_mm_per_s3": {"max": 1e9}}
    spec = cam({**parabolic, "windows": [window]}, parabolic)
    reported = judged(spec, Motion.of(spec.placed_segments()), (0.0, 60.0))
    assert reported["program/0/windows/0/jerk_mm_per_s3/max"].value is None


# -- what makes no sense --------------------------------------------------------------------------

WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "empty": ({"windows": [{"from_deg": 5, "to_deg": 5, "travel_mm": 1}]}, "window_empty"),
    "says nothing": ({"windows": [{"from_deg": 5, "to_deg": 7}]}, "window_says_nothing"),
    "open range": (
        {"windows": [{"from_deg": 5, "to_deg": 7, "travel_mm": {}}]}, "window_says_nothing"
    ),
    "outside": (
        {"windows": [{"from_deg": 5, "to_deg": 63.8, "travel_mm": {"min": 0}}]},
        "window_outside_segment",
    ),
    "too short": (
        {"windows": [{"from_deg": 5, "to_deg": 5.06, "velocity_mm_per_s": 3}]}, "window_too_short"
    ),
    "range upside down": (
        {"windows": [{"from_deg": 5, "to_deg": 7, "travel_mm": {"min": 3, "max": 2}}]},
        "range_empty",
    ),
    "contradiction": (
        {"windows": [{"from_deg": 5, "to_deg": 17, "velocity_mm_per_s": {"max": 90.0}},
                     {"from_deg": 16.9, "to_deg": 27, "velocity_mm_per_s": 90.1}]},
        "windows_contradict",
    ),
    "beyond the stroke": (
        {"windows": [{"from_deg": 5, "to_deg": 7, "travel_mm": {"min": 27.4}}]}, "outside_stroke"
    ),
    "point beyond the stroke": (
        {"points": [{"angle_deg": 9, "travel_mm": -0.1}]}, "outside_stroke"
    ),
    "point at the end": ({"points": [{"angle_deg": 63.7, "travel_mm": 27.3}]},
                         "point_outside_segment"),
    "back and forth": (
        {"points": [{"angle_deg": 30, "travel_mm": 9.0}, {"angle_deg": 20, "travel_mm": 9.1}]},
        "points_out_of_order",
    ),
    "against the move": (
        {"windows": [{"from_deg": 5, "to_deg": 7, "velocity_mm_per_s": {"max": -1e-3}}]},
        "against_the_move",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_nonsense_is_refused(name: str) -> None:
    fields, kind = WRONG[name]
    with pytest.raises(ValidationError) as caught:
        cam(fields)
    assert caught.value.errors()[-1]["type"] == kind
    assert "program" in caught.value.errors()[0]["loc"]


@pytest.mark.parametrize("name", ["beyond the stroke", "back and forth", "against the move"])
def test_a_law_that_may_overshoot_may_do_so(name: str) -> None:
    fields, _ = WRONG[name]
    cam({**fields, "law": {"kind": "spline", "overshoot": True}})


def test_an_overshooting_law_goes_where_it_is_sent() -> None:
    up = {"law": {"kind": "spline", "overshoot": True},
          "points": [{"angle_deg": 50.3, "travel_mm": LIFT + 1.7}]}  # fmt: skip
    limits = [LIMITS[0], {"kind": "jerk", "max_mm_per_s3": 4e6}]
    design = synthesise(cam(up, limits=limits, proof="quick"))
    assert design.status in ("optimal", "feasible")
    assert motion_at(design, 50.3, 0) == pytest.approx(LIFT + 1.7, abs=1e-9 * LIFT)


def test_a_point_of_a_small_move_far_up_is_still_exact() -> None:
    """The enclosure has to be finer than 1e-10 of the displacement."""
    high, small = 310.7, 2.3
    program = [
        {"kind": "rise", "angle_deg": 120.0, "lift_mm": high, "law": {"kind": "cycloidal"}},
        {"kind": "dwell", "angle_deg": 10.0},
        {"kind": "rise", "angle_deg": 40.0, "lift_mm": small,
         "points": [{"angle_deg": 13.7, "travel_mm": 0.71}]},
        {"kind": "dwell", "angle_deg": 10.0},
        {"kind": "return", "angle_deg": 180.0, "lift_mm": high + small,
         "law": {"kind": "cycloidal"}},
    ]  # fmt: skip
    limits = [LIMITS[0], {"kind": "jerk", "max_mm_per_s3": 2e7}]
    design = synthesise(cam(program=program, limits=limits, tolerance=0.05))
    reported = extreme(design, "program/2/points/0/travel_mm")
    assert reported.holds
    assert reported.width <= reported.margin <= 1.001e-9 * small


# -- followers on arms ----------------------------------------------------------------------------

ARM = {"kind": "oscillating_roller", "arm_mm": 85.0, "centre_distance_mm": 104.3,
       "roller_radius_mm": 11.7}  # fmt: skip


def swung(**fields: Any) -> DesignSpec:
    """An arm that falls 24.3° by the cycloidal law in 169.8°."""
    law = {"law": {"kind": "cycloidal"}}
    program = [
        {"kind": "rise", "angle_deg": 120.4, "lift_deg": 24.3, **law},
        {"kind": "dwell", "angle_deg": 69.8},
        {"kind": "return", "angle_deg": 169.8, "lift_deg": 24.3, **law, **fields},
    ]
    return cam(program=program, follower=ARM, limits=[], base_radius_mm=41.2)


@pytest.mark.usefixtures("unmended")
def test_on_arms_windows_and_points_are_in_degrees() -> None:
    x = np.array([31.3, 90.7]) / 169.8
    travel = 24.3 * (x - np.sin(2.0 * pi * x) / (2.0 * pi))
    speed = -24.3 / np.radians(169.8) * (1.0 - np.cos(2.0 * pi * x)) * OMEGA
    window = {"from_deg": 31.3, "to_deg": 80.1, "velocity_deg_per_s": {"max": -7.0}}
    point = {"angle_deg": 90.7, "travel_deg": travel[1], "velocity_deg_per_s": speed[1]}
    found = analyse(swung(windows=[window], points=[point]))
    reported = {e.field: e for e in found.extremes}
    slowest = reported["program/2/windows/0/velocity_deg_per_s/max"]
    assert slowest.unit == "deg/s"
    assert slowest.value == pytest.approx(speed[0], rel=1e-9)
    assert slowest.holds
    for name, value in (("travel_deg", travel[1]), ("velocity_deg_per_s", speed[1])):
        there = reported[f"program/2/points/0/{name}"]
        assert there.value == pytest.approx(value, rel=1e-9)
        assert there.holds
    off = {**point, "travel_deg": travel[1] + 1e-6, "velocity_deg_per_s": None}
    assert not analyse(swung(points=[off])).holds


def test_units_of_windows_are_the_follower_s() -> None:
    mixed = {"angle_deg": 90.7, "travel_mm": 3.0}
    with pytest.raises(ValidationError) as caught:
        swung(points=[mixed])
    assert caught.value.errors()[0]["type"] == "units_mixed"
    for point in ({"angle_deg": 9.0}, {**mixed, "travel_deg": 3.0}):
        with pytest.raises(ValidationError) as caught:
            swung(points=[point])
        assert caught.value.errors()[0]["type"] == "point_unclear"


def test_a_law_on_an_arm_keeps_its_window_and_passes_its_point() -> None:
    window = {"from_deg": 30.3, "to_deg": 49.7, "velocity_deg_per_s": 100.0}
    point = {"angle_deg": 41.0, "travel_deg": 4.1}
    program = [
        {"kind": "rise", "angle_deg": 100.0, "lift_deg": 17.3, "windows": [window]},
        {"kind": "dwell", "angle_deg": 50.0},
        {"kind": "return", "angle_deg": 120.0, "lift_deg": 17.3, "points": [point]},
        {"kind": "dwell", "angle_deg": 90.0},
    ]
    limits = [LIMITS[0] | {"rise_deg": 40.0}, {"kind": "jerk", "max_deg_per_s3": 6e5}]
    design = synthesise(cam(program=program, follower=ARM, limits=limits, tolerance=0.03))
    assert design.status == "optimal"
    assert "all motion laws" in design.certificate.bound_valid_for
    arc = np.degrees(1.0 / ARM["arm_mm"])  # degrees of the arm in a millimetre of the roller's way
    inside = motion_at(design, np.linspace(30.3 + 1e-9, 49.7 - 1e-9, 77), 1) * arc
    assert inside == pytest.approx(100.0, rel=1e-9)
    there = motion_at(design, 191.0, 0) * arc
    assert there == pytest.approx(17.3 - 4.1, abs=1e-9 * 17.3)
