"""P3: the oscillating roller in both senses; pressure angles, the pivot in the way, the faults.

The cam is built here a second time, from complex numbers and finite differences, with the law of
cosines and the motion laws typed from the literature; nothing is shared with the product.
"""

from __future__ import annotations

import json
import runpy
from math import acos, atan, cos, degrees, pi, radians, sin, sqrt
from pathlib import Path

import numpy as np
import pytest

from service.contract.examples import examples
from synthesis import Analysis, DesignSpec, analyse, synthesise
from synthesis.exporters import PROFILE_FORMATS, PointOptions

DOCS = Path(__file__).resolve().parents[2] / "docs" / "reference"
L, D, RB, RR, GAMMA = 85.0, 100.0, 80.0, 30.0, radians(30.0)
RP = RB + RR
RISE, BACK, SWING = radians(80.0), radians(150.0), radians(45.0)
PSI0 = acos((D**2 + L**2 - RP**2) / (2.0 * D * L))
SIGMA = {"opposite": 1.0, "same": -1.0}
SENSES = list(SIGMA)


def swing(theta: np.ndarray) -> np.ndarray:
    """φ(θ) [rad]: 3-4-5 up, cycloidal down."""
    theta = np.asarray(theta) % (2.0 * pi)
    x = np.clip(theta / RISE, 0.0, 1.0)
    y = np.clip((theta - radians(120.0)) / BACK, 0.0, 1.0)
    return SWING * (10.0 * x**3 - 15.0 * x**4 + 6.0 * x**5 - y + np.sin(2.0 * pi * y) / (2.0 * pi))


def centre(theta: np.ndarray, sense: str) -> np.ndarray:
    """The roller's centre in the cam's frame, as complex numbers."""
    back = GAMMA + pi - SIGMA[sense] * (PSI0 + swing(theta))
    return (D * np.exp(1j * GAMMA) + L * np.exp(1j * back)) * np.exp(-1j * np.asarray(theta))


def difference(f, theta: np.ndarray, step: float = 1e-5) -> np.ndarray:
    return (f(theta + step) - f(theta - step)) / (2.0 * step)


def profile(theta: np.ndarray, sense: str) -> np.ndarray:
    """Its envelope, by the normal of a difference quotient."""
    tangent = difference(lambda at: centre(at, sense), theta)
    return centre(theta, sense) - RR * 1j * tangent / abs(tangent)


def alpha(theta: np.ndarray, sense: str) -> np.ndarray:
    """|tan α| = |l (1 + σφ') − d cosψ| / (d sinψ) [deg]."""
    psi = PSI0 + swing(theta)
    lever = L * (1.0 + SIGMA[sense] * difference(swing, theta)) - D * np.cos(psi)
    return np.degrees(np.arctan(abs(lever) / (D * np.sin(psi))))


def spec(sense: str) -> DesignSpec:
    value = examples("analyses")[f"p3-{sense}"]["value"]
    return DesignSpec.model_validate_json(json.dumps(value), strict=True)


@pytest.fixture(scope="module", params=SENSES)
def sense(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module")
def found(sense: str) -> Analysis:
    return analyse(spec(sense))


def largest(found: Analysis, over: str) -> tuple[float, float]:
    """Largest |pressure angle| [deg], and the cam angle."""
    (curve,) = (c for c in found.curves if (c.curve, c.over) == ("pressure_angle", over))
    peak = max((curve.largest, curve.smallest), key=lambda each: abs(each.value))
    return abs(peak.value), peak.angle_deg


def test_the_prime_radius_is_the_base_radius_and_the_roller(found: Analysis) -> None:
    assert found.dimensions["prime_radius_mm"] == pytest.approx(110.0, abs=1e-12)
    assert found.dimensions["base_radius_mm"] == pytest.approx(80.0, abs=1e-12)
    assert found.dimensions["initial_angle_deg"] == pytest.approx(degrees(PSI0), abs=1e-12)


@pytest.mark.parametrize(("over", "start", "end"), [("rise", 0, 80), ("return", 120, 270)])
def test_the_pressure_angle_reaches_the_sixties(
    found: Analysis, sense: str, over: str, start: float, end: float
) -> None:
    theta = np.linspace(radians(start), radians(end), 60_001)[1:-1]
    reported = alpha(theta, sense)
    value, at = largest(found, over)
    assert value == pytest.approx(np.max(reported), abs=1e-3)  # on the grid, ends left out
    assert abs(at - degrees(theta[np.argmax(reported)])) < 0.02
    if (sense, over) in (("opposite", "rise"), ("same", "return")):
        known = {"opposite": 63.0592, "same": 58.7091}
        assert round(value, 4) == known[sense]


def test_every_point_of_both_curves(sense: str) -> None:
    """The point files in three columns, against the curves built here."""
    design = synthesise(spec(sense))
    assert design.certificate.certified
    for curve, truth in (("pitch", centre), ("profile", profile)):
        options = PointOptions(points_per_degree=1.0, curve=curve)
        text = PROFILE_FORMATS["txt"].write(design, options).decode()
        points = np.array([line.split() for line in text.splitlines()], dtype=float)
        assert points.shape == (360, 3)
        assert not np.any(points[:, 2])
        seam = 315.0  # the middle of the longer dwell
        want = truth(np.radians(seam + np.arange(360.0)), sense)
        np.testing.assert_allclose(points[:, 0], want.real, rtol=0, atol=2e-7)
        np.testing.assert_allclose(points[:, 1], want.imag, rtol=0, atol=2e-7)


def test_the_sharpest_radius(found: Analysis, sense: str) -> None:
    theta = np.radians(np.arange(0.0005, 360.0, 0.01))
    speed = difference(lambda at: centre(at, sense), theta)
    bend = difference(lambda at: difference(lambda on: centre(on, sense), at, 1e-4), theta, 1e-4)
    curvature = -np.imag(np.conj(speed) * bend) / abs(speed) ** 3  # passed clockwise
    reported = {c.curve: c for c in found.curves}
    assert reported["convex_radius"].smallest.value == pytest.approx(
        1.0 / np.max(curvature) - RR, rel=1e-4
    )
    hollow = reported["hollow_radius"].smallest
    assert hollow.value == pytest.approx(RR - 1.0 / np.min(curvature), rel=2e-3)
    assert found.undercut is None


def test_the_nose_sweeps_past_the_pivot(found: Analysis, sense: str) -> None:
    theta = np.linspace(0.0, 2.0 * pi, 20_001)
    outer = np.max(abs(profile(theta, sense)))
    highest = sqrt(D**2 + L**2 - 2.0 * D * L * cos(PSI0 + SWING)) - RR
    assert found.dimensions["outer_radius_mm"] == pytest.approx(highest, abs=1e-9)
    assert outer == pytest.approx(highest, abs=1e-6)
    assert found.dimensions["pivot_clearance_mm"] == pytest.approx(D - highest, abs=1e-9)
    assert round(found.dimensions["pivot_clearance_mm"], 4) == -28.3118


def test_the_two_directions_are_no_mirror_images() -> None:
    both = {sense: analyse(spec(sense)) for sense in SENSES}
    mirrored = analyse(spec("opposite").model_copy(update={"rotation": "cw"}))
    assert mirrored.curves == both["opposite"].curves
    assert mirrored.dimensions == both["opposite"].dimensions == both["same"].dimensions
    assert abs(largest(both["opposite"], "turn")[0] - largest(both["same"], "turn")[0]) > 4.0


def test_what_follows_from_the_wrong_prime_radius() -> None:
    wrong = acos((D**2 + L**2 - RB**2) / (2.0 * D * L))
    assert degrees(PSI0 - wrong) == pytest.approx(22.005, abs=1e-3)
    # the same cam at rest, from either formula
    rest = degrees(atan((L - D * cos(PSI0)) / (D * sin(PSI0))))
    (curve,) = (
        c for c in analyse(spec("opposite")).curves
        if (c.curve, c.over) == ("pressure_angle", "dwell")
    )  # fmt: skip
    assert curve.smallest.value == pytest.approx(rest, abs=1e-9)


def test_the_page_holds_the_tables_that_its_command_prints(
    capsys: pytest.CaptureFixture[str],
) -> None:
    runpy.run_path(str(DOCS / "p3.py"), run_name="__main__")
    page = (DOCS / "p3.md").read_text(encoding="utf-8")
    tables = capsys.readouterr().out.strip().split("\n\n")
    assert len(tables) == 5
    for table in tables:
        assert table in page, "docs/reference/p3.md is out of date: python docs/reference/p3.py"
