"""Questions whose best law is known in closed form: value above, bound below, both near.

Source: calculus of variations and bang-bang control; docs/reference/exact-optima.md.
"""

import runpy
from math import pi, sqrt
from pathlib import Path

import pytest
from pydantic import ValidationError

from synthesis import DesignSpec, synthesise

DOCS = Path(__file__).resolve().parents[2] / "docs" / "reference"
OPTIMA = runpy.run_path(str(DOCS / "exact_optima.py"))
CASES = {case.law if case.optimum != 32.0 else "least jerk": case for case in OPTIMA["CASES"]}
THRESHOLDS = {case.law: case for case in OPTIMA["THRESHOLDS"]}

# (name, tolerance): largest value above and bound below; the tolerance where nothing is said
REACHED = {
    ("√12", 1e-6): (2.6e-4, 1e-6)  # C2 splines have no jumps of acceleration: see the page
}


@pytest.mark.parametrize("tolerance", OPTIMA["TOLERANCES"])
@pytest.mark.parametrize("name", CASES)
def test_value_above_and_bound_below(name: str, tolerance: float) -> None:
    design, above, below = OPTIMA["reached"](CASES[name], tolerance)
    most_above, most_below = REACHED.get((name, tolerance), (tolerance, tolerance))
    assert design.certificate.certified
    assert -1e-7 <= above <= most_above
    assert "all motion laws" in design.certificate.bound_valid_for
    assert -1e-9 <= below <= most_below
    assert (design.status == "optimal") == ((name, tolerance) not in REACHED)


@pytest.mark.usefixtures("unexplained")
@pytest.mark.parametrize("name", THRESHOLDS)
def test_peak_velocity_just_above_the_least_and_just_below(name: str) -> None:
    case = THRESHOLDS[name]
    assert case.status(1.0 + case.above) == "optimal"
    assert case.status(1.0 - case.below) == "infeasible"


@pytest.mark.parametrize(
    ("objective", "caps", "order", "least"),
    [("peak_jerk", (), 3, 32.0), ("peak_acceleration", (50.0,), 2, 5.0)],
)
def test_the_published_task_30_mm_over_60_degrees(
    objective: str, caps: tuple[float, ...], order: int, least: float
) -> None:
    omega, beta = 10.0, pi / 3.0
    move = {"angle_deg": 60.0, "lift_mm": 30.0}
    spec = DesignSpec.model_validate(
        {
            "speed_rpm": omega * 30.0 / pi,
            "program": [
                {"kind": "rise", **move},
                {"kind": "dwell", "angle_deg": 30.0},
                {"kind": "return", **move},
                {"kind": "dwell", "angle_deg": 210.0},
            ],
            "follower": {"kind": "translating_roller", "roller_radius_mm": 10.0},
            "base_radius_mm": 300.0,
            "limits": [
                {"kind": "jerk", "max_mm_per_s3": cap * 30.0 * (omega / beta) ** 3} for cap in caps
            ],
            "objective": {"kind": objective},
            "tolerance": 2e-3,
        }
    )
    design = synthesise(spec)
    exact = least * 30.0 * (omega / beta) ** order
    assert design.status == "optimal"
    assert exact * (1.0 - 1e-7) <= design.certificate.value <= exact * 1.002
    assert exact * 0.998 <= design.certificate.lower_bound <= exact * (1.0 + 1e-9)


@pytest.mark.parametrize(
    ("start", "end"),
    [((0.0, 0.0), (0.0, 0.0)), ((31.7, 0.0), (0.0, -913.0)), ((-17.3, 1207.0), (53.9, 411.0))],
    ids=["R-R", "G-U", "B-B"],
)
def test_least_rms_jerk_between_any_states(
    start: tuple[float, float], end: tuple[float, float]
) -> None:
    """The quintic Hermite's ∫ j², VDI 2143's tasks: free laws reach it to a millionth."""
    state = [{"velocity_mm_per_s": v, "acceleration_mm_per_s2": a} for v, a in (start, end)]
    omega, lift, law = 7.9, 17.3, {"kind": "spline", "overshoot": True}
    moves = [("rise", 131.7, lift, start, end), ("return", 228.3, -lift, end, start)]
    spec = DesignSpec.model_validate(
        {
            "speed_rpm": omega * 30.0 / pi,
            "program": [
                {"kind": kind, "angle_deg": angle, "lift_mm": lift, "law": law,
                 "start": state[i], "end": state[1 - i]}
                for i, (kind, angle, *_) in enumerate(moves)
            ],
            "follower": {"kind": "translating_roller", "roller_radius_mm": 4.1, "offset_mm": 0.0},
            "base_radius_mm": 519.0,
            "objective": {"kind": "rms_jerk"},
            "tolerance": 1e-6,
        }
    )  # fmt: skip
    energy = 0.0
    for _, angle, D, (v0, a0), (v1, a1) in moves:
        T = angle * pi / 180.0 / omega  # s: the formula for unit time, scaled
        v0, v1, a0, a1 = v0 * T, v1 * T, a0 * T * T, a1 * T * T
        energy += T**-5 * (
            720 * D**2 - 120 * D * (a0 - a1) - 720 * D * (v0 + v1) + 9 * (a0**2 + a1**2)
            - 6 * a0 * a1 + 72 * (a0 * v0 - a1 * v1) + 48 * (a0 * v1 - a1 * v0)
            + 192 * (v0**2 + v1**2) + 336 * v0 * v1
        )  # fmt: skip
    exact = sqrt(energy * omega / (2.0 * pi))
    proof = synthesise(spec).certificate
    assert exact * (1.0 - 1e-9) <= proof.value <= exact * (1.0 + 1e-6)
    assert exact * (1.0 - 1e-6) <= proof.lower_bound <= exact * (1.0 + 1e-9)


def test_jerk_of_a_law_whose_acceleration_may_jump_is_refused() -> None:
    case = next(case for case in OPTIMA["CASES"] if case.smoothness == 1)
    body = case.spec(1e-3).model_dump(mode="json")
    for wrong in (
        {"objective": {"kind": "rms_jerk"}},
        {"objective": {"kind": "peak_jerk"}},
        {"limits": [{"kind": "jerk", "max_mm_per_s3": 1e9}]},
    ):
        with pytest.raises(ValidationError, match="speaks of jerk"):
            DesignSpec.model_validate(body | wrong)


def test_the_closed_forms_at_known_points() -> None:
    assert OPTIMA["peak_acceleration"](50.0) == pytest.approx(5.0, rel=1e-15)
    assert OPTIMA["peak_acceleration"](32.0) == pytest.approx(8.0, rel=1e-15)
    assert OPTIMA["peak_acceleration"](1e9) == pytest.approx(4.0, rel=1e-7)
    assert OPTIMA["rms_acceleration"](1e9) == pytest.approx(sqrt(12.0), rel=1e-7)
    assert THRESHOLDS["(A − √(A² − 4A))/2, A = 5.3"].least == pytest.approx(1.33755953, rel=1e-8)


@pytest.mark.usefixtures("unexplained")
def test_the_documented_tables_are_what_the_command_prints() -> None:
    page = (DOCS / "exact-optima.md").read_text(encoding="utf-8").splitlines()
    known = ("| peak", "| rms")
    optima = [line for line in page if line.startswith(known) and line.count("|") == 8]
    limits = [line for line in page if line.startswith(("| V(", "| (A", "| the same, C1"))]
    for printed, now in (
        *zip(optima, OPTIMA["optima"](), strict=True),
        *zip(limits, OPTIMA["thresholds"](), strict=True),
    ):
        for documented, found in zip(printed.split("|"), now.split("|"), strict=True):
            try:
                number = float(documented)
            except ValueError:
                assert documented == found
            else:  # millionths: solvers differ a little from machine to machine
                assert float(found) == pytest.approx(number, rel=0.2, abs=60.0)
