"""The conveyor spot-weld cam: durations free, against a search over all angles and a formula.

Source: public benchmark: 58 rpm, rise 6.7 in, dwell 20°, return with 1.1 in at −22 in/s, no dwell
at the bottom.
"""

import json
import runpy
from math import sqrt
from pathlib import Path

import numpy as np
import pytest

from synthesis import DesignSpec

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "reference" / "spot-weld.md"
CAM = runpy.run_path(str(ROOT / "docs" / "reference" / "spot_weld.py"))
INCH, PER_SECOND = 25.4, 348.0
OMEGA = np.radians(PER_SECOND)


def test_the_formula_is_that_of_full_speed_and_full_brakes() -> None:
    """Bang-bang motions at the formula's peak fill the turn, and no split is quicker."""
    peak, speed, rest = CAM["exact_acceleration"](), 22.0, 5.6
    assert peak == pytest.approx(114.2757, abs=1e-4)

    def quickest(lift: float, end: float) -> float:
        """From rest over a lift to an end speed, or back: full acceleration, full brakes [s]."""
        top = sqrt((2.0 * peak * lift + end**2) / 2.0)
        return (2.0 * top - end) / peak if top >= end else np.inf

    times = [
        quickest(first, speed) + quickest(rest - first, speed)
        for first in np.linspace(0.0, rest, 2001)
    ]
    total = 2.0 * sqrt(6.7 / peak) + min(times) + 1.1 / speed + 20.0 / PER_SECOND
    assert total == pytest.approx(360.0 / PER_SECOND, rel=1e-4)
    assert total >= 360.0 / PER_SECOND * (1.0 - 1e-12)


@pytest.mark.parametrize("objective", ["peak_acceleration", "peak_jerk"])
def test_no_angles_are_better(objective: str) -> None:
    design, (scanned, *_) = CAM["designed"](objective), CAM["scanned"](objective)
    value = design.certificate.value / INCH
    assert value == pytest.approx(scanned, rel=2e-3)
    assert design.certificate.lower_bound <= design.certificate.value
    assert design.certificate.gap <= 5e-3
    if objective == "peak_acceleration":
        exact = CAM["exact_acceleration"]()
        assert exact * (1.0 - 1e-9) <= value <= 1.002 * exact
        assert design.certificate.lower_bound <= exact * INCH
        assert scanned >= exact * (1.0 - 1e-9)


@pytest.mark.parametrize("objective", ["peak_acceleration", "peak_jerk"])
def test_the_answer_is_certified_and_says_what_was_chosen(objective: str) -> None:
    design = CAM["designed"](objective)
    assert design.status == "optimal"
    assert design.certificate.certified
    assert design.certificate.bound_valid_for.startswith("all motion laws")
    assert design.certificate.bound_valid_for.endswith("at all angles and lifts that are free")
    assert list(design.free_parameters) == [
        "program/0/angle_deg", "program/2/angle_deg", "program/2/lift_mm", "program/4/angle_deg",
        "program/4/lift_mm",
    ]  # fmt: skip
    angles = [segment.angle_deg for segment in design.motion]
    assert sum(angles) == pytest.approx(360.0, abs=1e-9)
    assert [angles[0], angles[2], angles[4]] == [
        design.free_parameters[f"program/{i}/angle_deg"] for i in (0, 2, 4)
    ]
    lifts = [segment.s_end_mm - segment.s_start_mm for segment in design.motion]
    assert lifts == pytest.approx(
        [170.18, 0.0, -design.free_parameters["program/2/lift_mm"], -27.94,
         -design.free_parameters["program/4/lift_mm"]], abs=1e-9,
    )  # fmt: skip


def test_the_motion_is_what_was_asked() -> None:
    design = CAM["designed"]("peak_jerk")
    starts = np.radians([segment.start_deg for segment in design.motion])
    conveying = np.linspace(starts[3] + 1e-9, starts[4] - 1e-9, 501)
    v = design.curve.derivatives(conveying)[1] * OMEGA
    assert v == pytest.approx(-22.0 * INCH, rel=1e-9)
    s = design.curve.derivatives(np.linspace(0.0, 2.0 * np.pi, 20001))
    assert s[0].min() == pytest.approx(0.0, abs=1e-9)
    assert s[0].max() == pytest.approx(170.18, abs=1e-9)
    jerk = np.abs(s[3]).max() * OMEGA**3
    assert jerk == pytest.approx(design.certificate.value, rel=1e-6)
    left, right = (design.curve.derivatives([0.0], 3, side)[:, 0] for side in ("left", "right"))
    assert left[:3] == pytest.approx(right[:3], abs=1e-6)
    assert left[2] > 1.0  # the bottom is no dwell


def test_the_example_of_the_service_is_this_cam() -> None:
    file = ROOT / "openapi" / "examples" / "spot-weld.json"
    example = DesignSpec.model_validate(json.loads(file.read_text(encoding="utf-8"))["value"])
    assert example == CAM["spec"]("peak_jerk")


def test_the_documented_table_is_what_the_command_prints() -> None:
    page = [line for line in PAGE.read_text(encoding="utf-8").splitlines() if line[:3] == "| `"]
    for printed, row in zip(page, CAM["rows"](), strict=True):
        for documented, found in zip(printed.split("|"), row.split("|"), strict=True):
            if documented.strip()[:1].isdigit():
                numbers, now = (
                    [float(word.strip(" °")) for word in cell.split("+")]
                    for cell in (documented, found)
                )
                assert now == pytest.approx(numbers, rel=2e-3, abs=0.6)
            else:
                assert documented == found
