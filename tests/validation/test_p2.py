"""P2: parabolic rise, harmonic return; what it breaks, where it jumps, what mends it.

The textbook formulas are typed here from the literature and share nothing with the product.
"""

from __future__ import annotations

import json
import runpy
from math import atan, cos, degrees, hypot, pi, radians, sin, sqrt, tan
from pathlib import Path

import numpy as np
import pytest

from service.contract.examples import examples
from synthesis import Analysis, DesignSpec, analyse, synthesise
from synthesis.catalogue.motion import Motion
from synthesis.catalogue.profile import cam_profile

DOCS = Path(__file__).resolve().parents[2] / "docs" / "reference"
H, E, RP, RR = 60.0, 15.0, 40.0, 10.0
RISE, BACK = radians(100.0), radians(90.0)
JOINTS = [0.0, 50.0, 100.0, 160.0, 250.0]


def motion(angle_deg: float, side: str = "right") -> tuple[float, float, float]:
    """s, s', s'' [mm, per rad] by the textbook, one-sided at the joints."""
    edge = 1e-12 if side == "right" else -1e-12
    at = (angle_deg + edge) % 360.0
    if at < 50.0:
        t = radians(at)
        return 2.0 * H * (t / RISE) ** 2, 4.0 * H * t / RISE**2, 4.0 * H / RISE**2
    if at < 100.0:
        t = RISE - radians(at)
        return H - 2.0 * H * (t / RISE) ** 2, 4.0 * H * t / RISE**2, -4.0 * H / RISE**2
    if at < 160.0:
        return H, 0.0, 0.0
    if at < 250.0:
        p, k = pi * radians(at - 160.0) / BACK, pi / BACK
        return 0.5 * H * (1 + cos(p)), -0.5 * H * k * sin(p), -0.5 * H * k**2 * cos(p)
    return 0.0, 0.0, 0.0


def alpha(angle_deg: float, prime: float = RP, e: float = E) -> float:
    s, v, _ = motion(angle_deg)
    return degrees(atan((v - e) / (sqrt(prime**2 - e**2) + s)))


def curvature(angle_deg: float, side: str) -> float:
    """κ = [X² + u (2s' − e) − X s''] / (X² + u²)^{3/2} (Rothbart)."""
    s, v, a = motion(angle_deg, side)
    x, u = sqrt(RP**2 - E**2) + s, v - E
    return (x**2 + u * (2.0 * v - E) - x * a) / hypot(x, u) ** 3


@pytest.fixture(scope="module")
def given() -> DesignSpec:
    value = examples("analyses")["p2-as-given"]["value"]
    return DesignSpec.model_validate_json(json.dumps(value), strict=True)


@pytest.fixture(scope="module")
def found(given: DesignSpec) -> Analysis:
    return analyse(given)


def test_the_rise_breaks_30_degrees(found: Analysis) -> None:
    assert found.violated == ["pressure_angle_rise"]
    grid = np.arange(0.0, 100.0, 0.01)
    worst = max(grid, key=lambda at: abs(alpha(at)))
    (rise,) = (e for e in found.extremes if e.limit == "pressure_angle_rise")
    assert rise.angle_deg == pytest.approx(worst, abs=0.01)
    assert rise.value == pytest.approx(alpha(50.0), abs=1e-9)
    assert rise.margin == pytest.approx(30.0 - alpha(50.0), abs=1e-9)
    assert round(-rise.margin, 4) == 8.7067


def test_the_return_keeps_70_degrees(found: Analysis) -> None:
    (back,) = (e for e in found.extremes if e.limit == "pressure_angle_return")
    worst = max(np.arange(160.0, 250.0, 0.01), key=lambda at: abs(alpha(at)))
    assert back.holds
    assert back.angle_deg == pytest.approx(worst, abs=0.01)
    assert back.value == pytest.approx(alpha(worst), abs=1e-6)


def test_acceleration_and_curvature_jump_at_five_angles(found: Analysis) -> None:
    for name in ("acceleration", "pitch_curvature"):
        jumps = [jump for jump in found.jumps if jump.curve == name]
        assert [jump.angle_deg for jump in jumps] == JOINTS
        for jump in jumps:
            sides = [
                motion(jump.angle_deg, side)[2]
                if name == "acceleration"
                else curvature(jump.angle_deg, side)
                for side in ("left", "right")
            ]
            assert [jump.before, jump.after] == pytest.approx(sides, rel=1e-9, abs=1e-9)
    assert {jump.curve for jump in found.jumps} == {"acceleration", "pitch_curvature"}


def test_extremes_at_a_jump_name_their_side(found: Analysis) -> None:
    by_name = {c.curve: c for c in found.curves if c.over == "turn"}
    largest, smallest = by_name["acceleration"].largest, by_name["acceleration"].smallest
    assert (largest.value, largest.angle_deg, largest.side) == pytest.approx((120.0, 250.0, "left"))
    assert (smallest.value, smallest.side) == pytest.approx((-120.0, "right"))
    convex = by_name["convex_radius"].smallest
    assert (convex.angle_deg, convex.side) == (50.0, "right")
    assert convex.value == pytest.approx(1.0 / curvature(50.0, "right") - RR, rel=1e-9)
    hollow = by_name["hollow_radius"].smallest
    assert hollow.value == pytest.approx(-1.0 / curvature(250.0, "left") + RR, rel=1e-9)
    assert found.undercut is None


GRID = [motion(at) for at in np.arange(0.0, 100.0, 0.25)]
BACK_GRID = [motion(at) for at in np.arange(160.0, 250.0, 0.25)]


def fits(prime: float, e: float) -> bool:
    """Whether both limits hold on the grids, which hold the worst angle of the rise."""
    s0 = sqrt(prime**2 - e**2)
    rise = max(abs(v - e) / (s0 + s) for s, v, _ in GRID)
    back = max(abs(v - e) / (s0 + s) for s, v, _ in BACK_GRID)
    return rise <= tan(radians(30.0)) and back <= tan(radians(70.0))


def smallest(e: float) -> float:
    """Least prime radius for an offset, by halving."""
    low, high = abs(e), 400.0
    while high - low > 1e-7:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if fits(middle, e) else (middle, high)
    return high


def test_the_smallest_prime_radius_that_mends_it(found: Analysis) -> None:
    kept, free = found.remedy.sizes
    s0 = (2.0 * H / RISE - E) / tan(radians(30.0)) - H / 2.0
    assert kept.dimensions["prime_radius_mm"] == pytest.approx(smallest(E), abs=2e-6)
    assert kept.dimensions["prime_radius_mm"] == pytest.approx(hypot(s0, E), abs=2e-6)
    offsets = np.arange(-10.0, 40.0, 0.5)
    best = min((smallest(e), e) for e in offsets)
    best = min((smallest(e), e) for e in np.arange(best[1] - 0.5, best[1] + 0.5, 0.005))
    assert free.dimensions["prime_radius_mm"] <= best[0] + 2e-6
    assert free.dimensions["prime_radius_mm"] == pytest.approx(best[0], abs=0.01)
    assert free.dimensions["offset_mm"] == pytest.approx(best[1], abs=0.01)


def test_the_sized_example_is_that_cam(found: Analysis) -> None:
    design = synthesise(DesignSpec.model_validate(examples()["p2-sized"]["value"]))
    assert design.status == "optimal"
    free = found.remedy.sizes[1].dimensions
    assert design.dimensions["prime_radius_mm"] == pytest.approx(free["prime_radius_mm"], abs=1e-5)
    assert design.dimensions["offset_mm"] == pytest.approx(free["offset_mm"], abs=1e-4)


@pytest.mark.parametrize("at", [17.3, 71.9, 123.1, 188.8, 231.7, 301.3])
def test_the_roller_also_turns_by_the_change_of_the_pressure_angle(
    given: DesignSpec, at: float
) -> None:
    """Fault 5: rolling without slip, from velocities, against arc length and dα/dθ."""
    step = 1e-5
    theta = radians(at) + step * np.array([-1.0, 0.0, 1.0])
    size = (E, sqrt(RP**2 - E**2))
    p = cam_profile(Motion.of(given.placed_segments()), given.follower, size, "ccw", theta)
    s, v, _ = motion(at)
    n = (-sin(p.pressure_angle[1]), cos(p.pressure_angle[1]))
    contact = (E - RR * n[0], size[1] + s - RR * n[1])
    slip = (-contact[1], contact[0] - v)  # cam's material against the roller's centre, ω = 1
    turning = (slip[0] * n[1] - slip[1] * n[0]) / RR
    arc = hypot(p.x[2] - p.x[0], p.y[2] - p.y[0]) / (2.0 * step)
    wandering = (p.pressure_angle[2] - p.pressure_angle[0]) / (2.0 * step)
    assert turning == pytest.approx(-arc / RR + wandering, rel=1e-6)


def test_the_page_holds_the_tables_that_its_command_prints(
    capsys: pytest.CaptureFixture[str],
) -> None:
    runpy.run_path(str(DOCS / "p2.py"), run_name="__main__")
    page = (DOCS / "p2.md").read_text(encoding="utf-8")
    tables = capsys.readouterr().out.strip().split("\n\n")
    assert len(tables) == 5
    for table in tables:
        assert table in page, "docs/reference/p2.md is out of date: python docs/reference/p2.py"
