"""Questions whose best law is known in closed form: value above, bound below, both near.

Source: calculus of variations and bang-bang control; docs/reference/exact-optima.md.
"""

import runpy
from math import pi, sqrt
from pathlib import Path

import pytest

from synthesis import DesignSpec, synthesise

DOCS = Path(__file__).resolve().parents[2] / "docs" / "reference"
OPTIMA = runpy.run_path(str(DOCS / "exact_optima.py"))
CASES = {case.law if case.optimum != 32.0 else "least jerk": case for case in OPTIMA["CASES"]}
THRESHOLDS = {case.law: case for case in OPTIMA["THRESHOLDS"]}
CAPPED = [name for name in CASES if "J = " in name and CASES[name].objective[:4] == "peak"]

# (name, tolerance): largest value above and bound below; the tolerance where nothing is said
REACHED = {
    ("4", 2e-3): (2.1e-3, 1e-6),  # splines have no jumps of acceleration: see the page
    ("4", 1e-4): (2.1e-3, 1e-6),
    ("√12", 1e-4): (1.1e-3, 1e-6),
    **{(name, 1e-4): (1e-4, 1.2e-3) for name in CAPPED},
}
OVER_SPLINES = {"Jτ/√3, J = 53.7"}


@pytest.mark.parametrize("tolerance", OPTIMA["TOLERANCES"])
@pytest.mark.parametrize("name", CASES)
def test_value_above_and_bound_below(name: str, tolerance: float) -> None:
    design, above, below = OPTIMA["reached"](CASES[name], tolerance)
    most_above, most_below = REACHED.get((name, tolerance), (tolerance, tolerance))
    assert design.certificate.certified
    assert -1e-7 <= above <= most_above
    if name in OVER_SPLINES:
        assert design.certificate.bound_over.startswith("splines")
        assert -above - 1e-9 <= below
    else:
        assert "all motion laws" in design.certificate.bound_over
        assert -1e-9 <= below <= most_below
    assert (design.status == "optimal") == ((name, tolerance) not in REACHED)


@pytest.mark.parametrize("name", THRESHOLDS)
def test_peak_velocity_just_above_the_least_and_just_below(name: str) -> None:
    case = THRESHOLDS[name]
    assert case.status(1.0 + case.above) == "optimal"
    assert case.status(1.0 - OPTIMA["BELOW"]) == "infeasible"


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


def test_the_closed_forms_at_known_points() -> None:
    assert OPTIMA["peak_acceleration"](50.0) == pytest.approx(5.0, rel=1e-15)
    assert OPTIMA["peak_acceleration"](32.0) == pytest.approx(8.0, rel=1e-15)
    assert OPTIMA["peak_acceleration"](1e9) == pytest.approx(4.0, rel=1e-7)
    assert OPTIMA["rms_acceleration"](1e9) == pytest.approx(sqrt(12.0), rel=1e-7)
    assert THRESHOLDS["(A − √(A² − 4A))/2, A = 5.3"].least == pytest.approx(1.33755953, rel=1e-8)


def test_the_documented_tables_are_what_the_command_prints() -> None:
    page = (DOCS / "exact-optima.md").read_text(encoding="utf-8").splitlines()
    known = ("| peak", "| rms")
    optima = [line for line in page if line.startswith(known) and line.count("|") == 8]
    limits = [line for line in page if line.startswith(("| V(", "| (A"))]
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
