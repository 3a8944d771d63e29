"""The whole way: what synthesise delivers is what was asked, by measures of the test's own."""

from __future__ import annotations

import time
from collections.abc import Callable
from itertools import pairwise
from math import sqrt
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from synthesis import Design, DesignSpec, synthesise
from synthesis.errors import TimeBudgetExceeded
from synthesis.optimise import root_node
from tests.pipeline.scenes import BETA, CYCLOIDAL, LIFT, OMEGA, PRESSURE, jerk, program, spec

ROOT = 1.0 + 1e-9


def sampled(design: Design) -> tuple[np.ndarray, dict[str, np.ndarray], np.ndarray]:
    """θ, (s … s''') and the kinds of segment at 40,000 angles, from the coefficients alone."""
    theta = np.linspace(0.0, 2.0 * np.pi, 40_001)[:-1] + 1e-7
    s = design.curve.derivatives(theta, 3)
    ends = np.radians([m.start_deg + m.angle_deg for m in design.motion])
    kinds = np.array([m.kind for m in design.motion])[np.searchsorted(ends, theta)]
    return theta, {"s": s[0], "v": s[1], "a": s[2], "j": s[3]}, kinds


def pressure_angle(design: Design, s: dict[str, np.ndarray]) -> np.ndarray:
    """Textbook formula, typed again: tan α = (s' − e)/(s0 + s) [deg]."""
    e, prime = design.dimensions["offset_mm"], design.dimensions["prime_radius_mm"]
    return np.degrees(np.arctan((s["v"] - e) / (sqrt(prime**2 - e**2) + s["s"])))


def assert_sound(design: Design) -> None:
    """Certified, and true by dense sampling: pressure angle, jerk, dwells, closure."""
    assert design.certificate.certified, [e for e in design.extremes if not e.holds]
    _, s, kinds = sampled(design)
    alpha = pressure_angle(design, s)
    for limit in design.spec.limits:
        if limit.kind == "pressure_angle":
            assert np.max(np.abs(alpha[kinds == "rise"])) <= limit.rise_deg * ROOT
            assert np.max(np.abs(alpha[kinds == "return"])) <= limit.return_deg * ROOT
        if limit.kind == "jerk":
            speed = design.speed_rpm * np.pi / 30.0
            assert np.max(np.abs(s["j"])) * speed**3 <= limit.max_mm_per_s3 * ROOT
    assert np.all(s["v"][kinds == "rise"] >= -1e-7)
    assert np.all(s["v"][kinds == "return"] <= 1e-7)
    assert np.ptp(s["s"]) == pytest.approx(design.spec.stroke(), rel=1e-7)


def test_example_13_6_sized() -> None:
    design = synthesise(spec())
    assert_sound(design)
    assert design.status == "optimal"
    assert design.certificate.gap is not None
    assert design.certificate.gap <= 5e-3
    assert design.certificate.bound_valid_for == "all motion laws with a bounded jerk"
    # the answer of 80 intervals without refinement lies in between (computed beforehand)
    assert design.certificate.lower_bound is not None
    assert design.certificate.lower_bound <= 45.0130 - 10.0
    assert design.dimensions["base_radius_mm"] <= 45.0130 * 1.003 - 10.0
    assert {s.stage.split()[0] for s in design.report.stages} == {"convex"}


@pytest.mark.parametrize("tolerance", [2e-2, 2e-3, 5e-4])
def test_tolerance_buys_gap(tolerance: float) -> None:
    design = synthesise(spec(tolerance=tolerance))
    assert_sound(design)
    assert design.status == "optimal"
    assert design.certificate.gap is not None
    assert design.certificate.gap <= tolerance


def test_bounds_and_values_of_all_tolerances_agree() -> None:
    """Every lower bound lies below every value, whatever it was computed with."""
    designs = [synthesise(spec(tolerance=t)) for t in (3e-2, 1e-2, 3e-3, 1e-3)]
    bounds = [d.certificate.lower_bound for d in designs]
    values = [d.certificate.value for d in designs]
    assert max(b for b in bounds if b is not None) <= min(v for v in values if v is not None)


# -- exact optima of rest-to-rest laws ----------------------------------------------------------


def one_objective(kind: str, limits: list[dict[str, Any]], **more: Any) -> Design:
    design = synthesise(spec(objective={"kind": kind}, limits=limits, base_radius_mm=400.0, **more))
    assert_sound(design)
    assert design.status == "optimal"
    return design


@pytest.mark.parametrize(
    ("kind", "limits", "exact"),
    [
        ("peak_jerk", [], 32.0 * LIFT / BETA**3 * OMEGA**3),
        ("peak_acceleration", [jerk(50.0)], 5.0 * LIFT / BETA**2 * OMEGA**2),
        ("rms_jerk", [], sqrt(720.0 * 2.0 * BETA / (2.0 * np.pi)) * LIFT / BETA**3 * OMEGA**3),
    ],
)
def test_closed_form_optima(kind: str, limits: list[dict[str, Any]], exact: float) -> None:
    design = one_objective(kind, limits, tolerance=2e-3)
    assert design.certificate.value == pytest.approx(exact, rel=2e-3)
    assert design.certificate.value >= exact * (1.0 - 1e-9)
    assert design.certificate.lower_bound is not None
    assert design.certificate.lower_bound <= exact * (1.0 + 1e-9)
    assert design.certificate.lower_bound >= exact * (1.0 - 2e-3)


def test_least_rms_acceleration_under_a_jerk_cap() -> None:
    """min ∫a² = (Jτ)²/3 with τ = (1 − √(1 − 24/J))/2, J = 40."""
    cap = 40.0
    tau = (1.0 - sqrt(1.0 - 24.0 / cap)) / 2.0
    share = sqrt(2.0 * BETA / (2.0 * np.pi))
    exact = share * cap * tau / sqrt(3.0) * LIFT / BETA**2 * OMEGA**2
    design = one_objective("rms_acceleration", [jerk(cap)], tolerance=2e-3)
    assert design.certificate.value == pytest.approx(exact, rel=2e-3)


def test_turning_joint_reaches_its_optimum() -> None:
    """Rise and return without a dwell between: min max|j| = 6(2 + √2) h/β³ for dwell to turn."""
    turning = [
        {"kind": "rise", "angle_deg": 75.0, "lift_mm": 17.0},
        {"kind": "return", "angle_deg": 75.0, "lift_mm": 17.0},
        {"kind": "dwell", "angle_deg": 210.0},
    ]
    design = one_objective("peak_jerk", [], program=turning, tolerance=5e-3)
    exact = 6.0 * (2.0 + sqrt(2.0)) * 17.0 / np.radians(75.0) ** 3 * OMEGA**3
    assert design.certificate.value == pytest.approx(exact, rel=5e-3)
    top = np.radians(75.0)
    left = design.curve.derivatives([top], 2, "left")[:, 0]
    right = design.curve.derivatives([top], 2, "right")[:, 0]
    assert left[1] == pytest.approx(0.0, abs=1e-9)
    assert left[2] == pytest.approx(right[2], rel=1e-8)
    assert left[2] < 0.0


# -- the ladder ----------------------------------------------------------------------------------


def test_given_laws_and_pressure_angle_alone_need_no_solver() -> None:
    design = synthesise(spec(program=program(CYCLOIDAL), limits=[PRESSURE]))
    assert [s.stage for s in design.report.stages] == ["closed form"]
    assert_sound(design)
    assert design.status == "optimal"
    # brute force: the smallest prime radius over a fine mesh of offsets
    _, s, kinds = sampled(design)
    best = np.inf
    for e in np.linspace(14.9, 15.3, 81):
        need = np.abs(s["v"] - e) / np.where(
            kinds == "rise", np.tan(np.radians(30.0)), np.tan(np.radians(45.0))
        )
        moving = kinds != "dwell"
        best = min(best, float(np.hypot(e, np.max((need - s["s"])[moving]))))
    assert design.dimensions["prime_radius_mm"] == pytest.approx(best, rel=1e-5)


def test_very_unequal_limits_bind_at_the_start_of_the_rise() -> None:
    """5° and 70°: the apex of two half-planes is not the answer; |e| ≤ t s0 binds as well."""
    limits = [{"kind": "pressure_angle", "rise_deg": 5.0, "return_deg": 70.0}]
    design = synthesise(spec(program=program(CYCLOIDAL), limits=limits))
    assert_sound(design)
    e, s0 = design.size
    assert e == pytest.approx(s0 * np.tan(np.radians(5.0)), rel=1e-6)


def test_a_profile_radius_that_bites_calls_for_tangents() -> None:
    free = synthesise(spec())
    design = synthesise(
        spec(limits=[PRESSURE, jerk(48.0), {"kind": "profile_radius", "min_mm": 12.0}])
    )
    assert_sound(design)
    assert design.report.stages[-1].stage == "tangents"
    assert "tangents" not in {s.stage for s in free.report.stages}
    assert free.dimensions["base_radius_mm"] < design.dimensions["base_radius_mm"] < 36.6
    x, y = pitch(design)
    radius = signed_radius(x, y)
    assert np.min(radius[radius > 0.0]) == pytest.approx(22.0, rel=1e-3)


def pitch(design: Design) -> tuple[np.ndarray, np.ndarray]:
    """The pitch curve at equal angles, formula typed again."""
    theta, s, _ = sampled(design)
    e = design.dimensions["offset_mm"]
    x0 = sqrt(design.dimensions["prime_radius_mm"] ** 2 - e**2) + s["s"]
    return x0 * np.sin(theta) + e * np.cos(theta), x0 * np.cos(theta) - e * np.sin(theta)


def signed_radius(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Radius of curvature by central differences on a closed curve, convex positive."""
    step = 2.0 * np.pi / len(x)

    def first(f: np.ndarray) -> np.ndarray:
        return (np.roll(f, -1) - np.roll(f, 1)) / (2.0 * step)

    def second(f: np.ndarray) -> np.ndarray:
        return (np.roll(f, -1) - 2.0 * f + np.roll(f, 1)) / step**2

    turn = first(x) * second(y) - first(y) * second(x)
    return -((first(x) ** 2 + first(y) ** 2) ** 1.5) / turn


# -- ordered objectives --------------------------------------------------------------------------


def test_ordered_objectives_keep_the_first() -> None:
    first = synthesise(spec(tolerance=1e-2))
    both = synthesise(
        spec(objective=[{"kind": "base_radius"}, {"kind": "peak_acceleration"}], tolerance=1e-2)
    )
    assert_sound(both)
    peak = [np.max(np.abs(sampled(d)[1]["a"])) for d in (first, both)]
    assert peak[1] < 0.98 * peak[0]
    assert both.certificate.gap is not None
    assert both.certificate.gap <= 1e-2
    assert [p.objective for p in both.certificate.other_objectives] == [
        "peak_acceleration_mm_per_s2"
    ]
    assert both.objectives["peak_acceleration_mm_per_s2"] == pytest.approx(
        peak[1] * OMEGA**2, rel=1e-6
    )


@pytest.mark.parametrize("kind", ["rms_acceleration", "peak_jerk"])
def test_a_later_objective_has_a_bound_where_only_the_first_ones_cam_is_known(kind: str) -> None:
    """The first objective is held so closely that no search finds another cam."""
    law = {"kind": "spline"}
    design = synthesise(
        DesignSpec.model_validate(
            {
                "speed_rpm": 52.8,
                "program": [
                    {"kind": "rise", "angle_deg": 80.4, "lift_mm": 12.8, "law": law},
                    {"kind": "dwell", "angle_deg": 35.9},
                    {"kind": "return", "angle_deg": 93.0, "lift_mm": 12.8, "law": law},
                    {"kind": "dwell", "angle_deg": 150.7},
                ],
                "follower": {"kind": "translating_roller", "roller_radius_mm": 8.42},
                "limits": [
                    {"kind": "pressure_angle", "rise_deg": 33.8, "return_deg": 36.3},
                    {"kind": "jerk", "max_mm_per_s3": 73900.0},
                ],
                "tolerance": 5e-3,
                "objective": [{"kind": "base_radius"}, {"kind": kind}],
                "proof": "quick",
            }
        )
    )
    (later,) = design.certificate.other_objectives
    assert later.gap is not None
    assert 0.0 < later.gap < 0.5


def test_peak_pressure_angle() -> None:
    design = one_objective_at_60("peak_pressure_angle")
    _, s, kinds = sampled(design)
    alpha = pressure_angle(design, s)
    peak = np.max(np.abs(alpha[kinds != "dwell"]))
    assert design.certificate.value == pytest.approx(peak, rel=1e-6)
    # the same question asked the other way round: 50 mm is the least base radius for this angle
    request = {"kind": "pressure_angle", "rise_deg": peak, "return_deg": peak}
    other = synthesise(spec(limits=[request, jerk(48.0)], tolerance=2e-3))
    assert other.certificate.value == pytest.approx(50.0, rel=1e-2)


def one_objective_at_60(kind: str) -> Design:
    design = synthesise(
        spec(objective={"kind": kind}, limits=[jerk(48.0)], base_radius_mm=50.0, tolerance=2e-3)
    )
    assert design.certificate.certified
    assert design.status == "optimal"
    return design


# -- invariance, determinism, the wire -----------------------------------------------------------


@pytest.mark.parametrize("factor", [1e-6, 1.0, 1e3])
def test_lift_scales_everything(factor: float) -> None:
    lift = LIFT * factor
    limits = [PRESSURE, jerk(48.0, lift=lift)]
    roller = {"kind": "translating_roller", "roller_radius_mm": 10.0 * factor}
    design = synthesise(spec(program=program(lift=lift), limits=limits, follower=roller))
    reference = synthesise(spec())
    assert design.status == "optimal"
    for name, value in reference.dimensions.items():
        assert design.dimensions[name] == pytest.approx(value * factor, rel=1e-9)


def test_a_dwell_of_no_extent_is_no_dwell() -> None:
    touching = program()
    touching[1]["angle_deg"], touching[3]["angle_deg"] = 0.0, 240.0
    design = synthesise(spec(program=touching))
    assert_sound(design)
    top = np.radians(60.0)
    assert design.curve.derivatives([top], 2)[2, 0] < -100.0


def test_a_tiny_lift_on_a_large_cam() -> None:
    small = 1e-4
    design = synthesise(
        spec(
            program=program(lift=small), limits=[PRESSURE, jerk(48.0, lift=small)],
            base_radius_mm=100.0, objective={"kind": "peak_acceleration"},
        )
    )  # fmt: skip
    assert_sound(design)
    reference = synthesise(
        spec(limits=[jerk(48.0)], base_radius_mm=400.0, objective={"kind": "peak_acceleration"})
    )
    ratio = design.certificate.value / reference.certificate.value
    assert ratio == pytest.approx(small / LIFT, rel=1e-3)


def test_speed_changes_nothing_but_the_physical_values() -> None:
    fast = 1e4
    slow = synthesise(spec())
    quick = synthesise(
        spec(
            speed_rpm=OMEGA * fast * 30.0 / np.pi, limits=[PRESSURE, jerk(48.0, omega=OMEGA * fast)]
        )
    )
    assert quick.dimensions["base_radius_mm"] == pytest.approx(
        slow.dimensions["base_radius_mm"], rel=1e-7
    )


def test_reversed_program_mirrors_the_offset() -> None:
    """Time run backwards: rise and return change places, and the offset changes sides."""
    limits = [{"kind": "pressure_angle", "rise_deg": 30.0, "return_deg": 45.0}, jerk(48.0)]
    mirrored = [{"kind": "pressure_angle", "rise_deg": 45.0, "return_deg": 30.0}, jerk(48.0)]
    a, b = synthesise(spec(limits=limits)), synthesise(spec(limits=mirrored))
    assert a.dimensions["offset_mm"] > 1.0
    assert b.dimensions["offset_mm"] == pytest.approx(-a.dimensions["offset_mm"], rel=1e-3)
    assert b.dimensions["prime_radius_mm"] == pytest.approx(
        a.dimensions["prime_radius_mm"], rel=1e-5
    )


def test_same_spec_same_design() -> None:
    first, second = (synthesise(spec()).model_dump(mode="json") for _ in range(2))
    first.pop("report"), second.pop("report")
    assert first == second


def test_the_wire_keeps_every_bit() -> None:
    design = synthesise(spec())
    again = Design.model_validate_json(design.model_dump_json())
    theta = np.linspace(0.0, 6.2, 977)
    assert np.array_equal(design.curve.derivatives(theta), again.curve.derivatives(theta))


@pytest.mark.parametrize("smoothness", [2, 3, 4])
def test_smoothness_is_kept_through_every_joint(smoothness: int) -> None:
    law = {"kind": "spline", "smoothness": smoothness}
    design = synthesise(spec(program=program(law), tolerance=2e-2))
    assert_sound(design)
    breaks = design.curve.curve.breaks[1:-1]
    for order in range(smoothness + 1):
        left = design.curve.curve(breaks, order, "left")
        right = design.curve.curve(breaks, order, "right")
        # coefficients are rounded to 1e-16, and knots may lie 1e-3 of the segment apart
        rounding = 1e-13 * LIFT / (1e-3 * BETA) ** order
        assert np.max(np.abs(left - right)) <= max(rounding, 1e-9 * LIFT / BETA**order)


def test_two_rises_share_velocity_and_acceleration() -> None:
    steps = [
        {"kind": "rise", "angle_deg": 41.0, "lift_mm": 13.0},
        {"kind": "rise", "angle_deg": 31.0, "lift_mm": 17.0},
        {"kind": "dwell", "angle_deg": 28.0},
        {"kind": "return", "angle_deg": 60.0, "lift_mm": 30.0, "law": CYCLOIDAL},
        {"kind": "dwell", "angle_deg": 200.0},
    ]
    design = synthesise(spec(program=steps, limits=[PRESSURE, jerk(90.0)]))
    assert_sound(design)
    joint = np.radians(41.0)
    left = design.curve.derivatives([joint], 2, "left")[:, 0]
    right = design.curve.derivatives([joint], 2, "right")[:, 0]
    assert left[1] > 1.0
    assert left == pytest.approx(right, rel=1e-8)


def test_no_time_at_all() -> None:
    with pytest.raises(TimeBudgetExceeded) as caught:
        synthesise(spec(), deadline=time.monotonic() - 1.0)
    assert caught.value.best is None


def test_time_that_ends_after_a_round_leaves_the_best_so_far(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The clock jumps past the deadline as soon as the first round has reported."""
    late: list[float] = [0.0]
    real, report = time.monotonic, root_node.program_stage

    def reported(*given: Any) -> Any:
        late[0] = 1e6
        return report(*given)

    monkeypatch.setattr(root_node, "program_stage", reported)
    monkeypatch.setattr(time, "monotonic", lambda: real() + late[0])
    with pytest.raises(TimeBudgetExceeded) as caught:
        synthesise(spec(tolerance=1e-5, time_budget_s=100.0))
    best = caught.value.best
    assert best is not None
    assert_sound(best)
    assert best.status == "feasible"
    assert len(best.report.stages) == 1


# -- refusals ------------------------------------------------------------------------------------


def test_a_cam_given_down_to_its_size_is_measured_and_refused() -> None:
    """P1 as printed (offset 20, base radius 50) breaks 30° on the rise: by how much and where."""
    given: dict[str, Any] = {
        "program": program(CYCLOIDAL),
        "follower": {"kind": "translating_roller", "roller_radius_mm": 10.0, "offset_mm": 20.0},
        "base_radius_mm": 50.0,
        "limits": [{"kind": "pressure_angle", "rise_deg": 25.0, "return_deg": 45.0}],
    }
    design = synthesise(spec(**given))
    assert design.status == "infeasible"
    broken = {e.limit: e for e in design.extremes if not e.holds}
    assert "pressure_angle_return" in broken
    _, s, kinds = sampled(design)
    alpha = pressure_angle(design, s)
    worst = broken["pressure_angle_return"]
    assert worst.value is not None
    assert abs(worst.value) == pytest.approx(np.max(np.abs(alpha[kinds == "return"])), rel=1e-6)
    assert worst.margin is not None
    assert worst.margin < 0.0
    assert design.conflict is not None
    assert design.conflict.relaxations


def test_a_jerk_limit_below_the_theoretical_minimum_is_refused_with_the_minimum(
    explain_only: Callable[[str], None],
) -> None:
    explain_only("limits/1/max_mm_per_s3")
    design = synthesise(spec(limits=[PRESSURE, jerk(31.0)]))
    assert design.status == "infeasible"
    assert design.certificate.certified is False
    assert design.conflict is not None
    needed = {r.limit: r.needed for r in design.conflict.relaxations}
    found = next(v for k, v in needed.items() if k.startswith("jerk"))
    assert found == pytest.approx(32.0 * LIFT / BETA**3 * OMEGA**3, rel=1e-3)


def test_stages_report_what_was_modelled() -> None:
    design = synthesise(spec(tolerance=1e-3))
    for earlier, later in pairwise(design.report.stages):
        assert later.unknowns > earlier.unknowns
    assert all(s.rows > s.unknowns and s.iterations > 0 for s in design.report.stages)
    assert design.report.seconds >= sum(s.seconds for s in design.report.stages)


def test_spec_is_the_request_body() -> None:
    body = spec().model_dump(mode="json")
    assert DesignSpec.model_validate(body) == spec()


@pytest.mark.usefixtures("unexplained")
def test_a_law_that_must_overshoot_is_refused_by_name() -> None:
    """A return that has to end with a downward acceleration at rest cannot come from above."""
    steps = [
        {"kind": "rise", "angle_deg": 100.0, "lift_mm": 23.0},
        {"kind": "dwell", "angle_deg": 60.0},
        {"kind": "return", "angle_deg": 90.0, "lift_mm": 11.0},
        {"kind": "return", "angle_deg": 60.0, "lift_mm": 12.0, "law": {"kind": "simple_harmonic"}},
        {"kind": "dwell", "angle_deg": 50.0},
    ]
    design = synthesise(spec(program=steps, limits=[PRESSURE]))
    assert design.status == "unsolved"
    assert design.conflict is not None
    assert "overshoot" in design.conflict.limits
    allowed = [dict(step) for step in steps]
    allowed[2]["law"] = {"kind": "spline", "overshoot": True}
    assert synthesise(spec(program=allowed, limits=[PRESSURE])).certificate.certified


@pytest.mark.parametrize("roller", [0.0, 3.4])
def test_peaks_between_samples_are_grown_out_of(roller: float) -> None:
    """A hollow that only just admits the cutter, on long pieces: certified at the first attempt."""
    design = synthesise(
        spec(
            program=program({"kind": "polynomial_4_5_6_7"}),
            follower={"kind": "translating_roller", "roller_radius_mm": roller, "offset_mm": 3.3},
            limits=[{"kind": "cutter_radius", "radius_mm": 41.7}],
            objective={"kind": "base_radius"},
        )
    )
    assert design.certificate.certified
    hollow = next(e for e in design.extremes if e.limit == "cutter_radius")
    assert hollow.value == pytest.approx(41.7, rel=1e-5)


def test_the_largest_cam_is_no_answer() -> None:
    with pytest.raises(ValueError, match="every larger cam has a smaller pressure angle"):
        spec(objective={"kind": "peak_pressure_angle"})
    spec(objective=[{"kind": "base_radius"}, {"kind": "peak_pressure_angle"}])


@pytest.mark.parametrize("tolerance", [2e-2, 7e-3])
def test_without_a_cap_the_bound_is_no_least_of_splines(tolerance: float) -> None:
    """No best law exists: the finer the knots, the smaller the cam, and none reaches the bound."""
    knife = {"kind": "translating_roller", "roller_radius_mm": 0.0}
    aim = {"kind": "base_radius"}
    question = spec(limits=[PRESSURE], follower=knife, tolerance=tolerance, objective=aim)
    design = synthesise(question)
    proof = design.certificate
    assert proof.bound_valid_for.startswith("every motion law")
    assert proof.lower_bound is not None
    assert proof.value is not None
    assert proof.lower_bound <= proof.value
    assert design.status == "feasible"


def test_a_design_read_back_has_its_spec_checked() -> None:
    """One that is built here has not: its spec was checked when it was made."""
    body = synthesise(spec()).model_dump(mode="json")
    assert Design.model_validate(body).spec == spec()
    body["spec"]["program"][0]["angle_deg"] += 1.0
    with pytest.raises(ValidationError, match="sum to 361"):
        Design.model_validate(body)


def test_a_later_objective_does_not_enlarge_the_cam_for_its_curvature() -> None:
    """The least base radius is kept: a cam of less jerk that undercuts is not made larger."""
    lift, spline = 13.4, {"kind": "spline"}
    question = {
        "speed_rpm": 205.0,
        "program": [
            {"kind": "rise", "angle_deg": 67.1, "lift_mm": lift, "law": spline},
            {"kind": "dwell", "angle_deg": 38.9},
            {"kind": "return", "angle_deg": 123.0, "lift_mm": lift, "law": spline},
            {"kind": "dwell", "angle_deg": 131.0},
        ],
        "follower": {"kind": "translating_roller", "roller_radius_mm": 8.87},
        "limits": [
            {"kind": "pressure_angle", "rise_deg": 41.6, "return_deg": 38.4},
            {"kind": "jerk", "max_mm_per_s3": 3.94e6},
        ],
        "tolerance": 0.02,
        "proof": "quick",
    }
    base, jerk = {"kind": "base_radius"}, {"kind": "peak_jerk"}
    alone = synthesise(DesignSpec.model_validate({**question, "objective": base}))
    both = synthesise(DesignSpec.model_validate({**question, "objective": [base, jerk]}))
    assert both.certificate.certified
    least, kept = (d.dimensions["base_radius_mm"] for d in (alone, both))
    assert kept == pytest.approx(least, rel=0.02)
