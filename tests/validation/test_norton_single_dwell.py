"""Norton's single-dwell cam: the textbook's 547 in/s², and the least at the same peak jerk.

Source: Norton, Design of Machinery, chapter on cams: lift 1 in, rise 90°, return 90°, dwell 180°,
15 rad/s, polynomial 3-4-5-6 over rise and return together.
"""

import json
import runpy
from math import pi
from pathlib import Path

import numpy as np
import pytest

from synthesis import DesignSpec, synthesise

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "reference" / "norton-single-dwell.md"
CAM = runpy.run_path(str(ROOT / "docs" / "reference" / "norton_single_dwell.py"))
INCH, OMEGA = 25.4, 15.0
A = (OMEGA / (pi / 2.0)) ** 2  # h ω²/β², in/s²
J = (OMEGA / (pi / 2.0)) ** 3


def test_the_textbook_law_has_the_printed_peak() -> None:
    a, j = CAM["peaks"]("polynomial_3_4_5_6")
    assert round(a) == 547
    assert a == pytest.approx(6.0 * A, rel=1e-9)
    assert j == pytest.approx(48.0 * J, rel=1e-9)
    assert round(CAM["peaks"]("double_harmonic")[0]) == 900


def test_rise_and_return_are_one_polynomial_of_the_half_turn() -> None:
    motion = synthesise(CAM["spec"]("polynomial_3_4_5_6")).curve
    theta = np.array([0.013, 0.4, 1.1, 1.5707, 1.5709, 2.345, 3.1])
    y = theta / pi
    np.testing.assert_allclose(
        motion.derivatives(theta)[0], INCH * 64.0 * y**3 * (1.0 - y) ** 3, rtol=0, atol=1e-12
    )


def pulses(jerk: float, peak: float) -> tuple[float, float]:
    """Velocity and displacement at x = 1 of jerk pulses +J, 0, −J, 0, integrated exactly.

    The first pause is what makes the velocity vanish; found by bisection.
    """

    def run(pause: float) -> tuple[float, float]:
        k = peak / jerk
        parts = [(jerk, k), (0.0, pause), (-jerk, 2.0 * k)]
        parts.append((0.0, 1.0 - sum(length for _, length in parts)))
        s = v = a = 0.0
        for j, t in parts:
            s, v, a = (s + v * t + a * t**2 / 2 + j * t**3 / 6, v + a * t + j * t**2 / 2, a + j * t)
        return v, s

    low, high = 0.0, 1.0 - 3.0 * peak / jerk
    for _ in range(200):
        middle = (low + high) / 2.0
        low, high = (middle, high) if run(middle)[0] < 0.0 else (low, middle)
    return run(low)


@pytest.mark.parametrize("jerk", [36.585, 42.41, 48.0, 71.3])
def test_the_closed_form_is_that_of_the_pulses(jerk: float) -> None:
    v, s = pulses(jerk, CAM["least"](jerk))
    assert v == pytest.approx(0.0, abs=1e-12)
    assert s == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("law", CAM["TEXTBOOK"])
def test_the_least_peak_at_the_same_jerk(law: str) -> None:
    jerk = CAM["peaks"](law)[1]
    design = CAM["optimum"](jerk)
    exact = CAM["least"](jerk / J) * A * INCH
    proof = design.certificate
    assert design.status == "optimal"
    assert "all motion laws" in proof.bound_valid_for
    assert exact * (1.0 - 1e-7) <= proof.value <= exact * 1.002
    assert exact * 0.998 <= proof.lower_bound <= exact * (1.0 + 1e-9)


def test_a_quarter_lower_than_the_textbook() -> None:
    a, j = CAM["peaks"]("polynomial_3_4_5_6")
    lower = 1.0 - CAM["optimum"](j).certificate.value / (a * INCH)
    assert 0.25 <= lower <= 0.26


def test_the_example_of_the_service_is_this_cam() -> None:
    file = ROOT / "openapi" / "examples" / "norton-single-dwell.json"
    example = DesignSpec.model_validate(json.loads(file.read_text(encoding="utf-8"))["value"])
    ours = CAM["spec"]("spline", jerk=48.0 * J)
    alike = example.model_copy(update={"speed_rpm": ours.speed_rpm, "limits": ours.limits})
    assert alike == ours
    assert example.speed_rpm == pytest.approx(ours.speed_rpm, rel=1e-12)
    found, question = example.limits[0].max_mm_per_s3, ours.limits[0].max_mm_per_s3
    assert found == pytest.approx(question, rel=1e-6)


def test_the_documented_table_is_what_the_command_prints() -> None:
    page = [line for line in PAGE.read_text(encoding="utf-8").splitlines() if line[:3] == "| `"]
    for printed, row in zip(page, CAM["rows"](), strict=True):
        for documented, found in zip(printed.split("|"), row.split("|"), strict=True):
            if documented.strip()[:1].isdigit():
                number, now = (float(cell.strip(" %")) for cell in (documented, found))
                assert now == pytest.approx(number, rel=1e-3, abs=0.06)
            else:
                assert documented == found
