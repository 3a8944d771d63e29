"""P5: a six-bar shaper, against formulas that the product does not use.

Velocities by Kennedy's theorem, the guide by its textbook closed form, the rest by differences of
positions to forty digits; then what each fault of the printed program makes of it.
"""

from __future__ import annotations

import runpy
from decimal import Decimal
from math import asin, cos, degrees, hypot, pi, radians, sin, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from service.contract.examples import examples
from synthesis.machines.linkages.files.shaper import SampledTurn
from synthesis.machines.linkages.shaper import ShaperSpec, SixBarShaper, analyse_or_size_shaper
from tests import forty_digits

Array = NDArray[np.float64]
DOCS = Path(__file__).resolve().parents[2] / "docs" / "reference"
R, L, C, A, H = 125.0, 600.0, 150.0, 275.0, 575.0
BETA = asin(R / A)
STEP = Decimal(10) ** -12
MISSED = radians(0.033)


def solve(**changes: Any) -> SixBarShaper:
    value = examples("linkages/six-bar-shapers")["p5"]["value"]
    return analyse_or_size_shaper(ShaperSpec.model_validate(value | changes))


@pytest.fixture(scope="module")
def p5() -> SixBarShaper:
    return solve()


def end(phi: Array) -> tuple[Array, Array]:
    """The guide's end: on the line from its pivot through the crank's pin."""
    x, y = R * np.cos(phi), A + R * np.sin(phi)
    return L * x / np.hypot(x, y), L * y / np.hypot(x, y)


def ram(phi: Array, side: float = -1.0) -> Array:
    x, y = end(phi)
    return x + side * np.sqrt(C**2 - (H - y) ** 2)


def guide_rates(phi: Array) -> tuple[Array, Array]:
    """ψ' = r (r + a sin φ)/ρ² and ψ'' = r a (a² − r²) cos φ/ρ⁴, from tan ψ."""
    square = R**2 + A**2 + 2.0 * R * A * np.sin(phi)
    return R * (R + A * np.sin(phi)) / square, R * A * (A**2 - R**2) * np.cos(phi) / square**2


def ram_rate(phi: Array) -> Array:
    """x' by Kennedy: guide and ram share the point where the coupler's line cuts the upright.

    That upright goes through the guide's pivot, so that the point moves with −ψ' times its height.
    """
    x, y = end(phi)
    at = ram(phi)
    height = H - at * (H - y) / (at - x)
    return -guide_rates(phi)[0] * height


def exactly(phi: float) -> tuple[list[Decimal], list[Decimal]]:
    """Ram and sine of the coupler's angle, each with two derivatives, from places to forty digits.

    The guide's height is taken from its angle at the crank: the triangle of both pivots and pin.
    """
    r, guide, coupler, a, line = (Decimal(each) for each in (R, L, C, A, H))

    def place(at: Decimal) -> tuple[Decimal, Decimal]:
        rho = (r * r + a * a + 2 * r * a * forty_digits.sin(at)).sqrt()
        sine = (rho * rho + a * a - r * r) / (2 * rho * a)
        cosine = r * forty_digits.cos(at) / rho
        up = line - guide * sine
        return guide * cosine - (coupler * coupler - up * up).sqrt(), up / coupler

    low, here, high = (place(Decimal(phi) + k * STEP) for k in (-1, 0, 1))
    both = []
    for a0, a1, a2 in zip(low, here, high, strict=True):
        both.append([a1, (a2 - a0) / (2 * STEP), (a2 - 2 * a1 + a0) / STEP**2])
    return both[0], both[1]


def test_closed_forms(p5: SixBarShaper) -> None:
    left, right = sorted(p5.dead_centres, key=lambda one: one.ram_mm)
    assert p5.stroke_mm == pytest.approx(2.0 * L * R / A, rel=1e-14)
    assert left.crank_deg == pytest.approx(180.0 + degrees(BETA), rel=1e-14)
    assert right.crank_deg == pytest.approx(360.0 - degrees(BETA), rel=1e-14)
    across = sqrt(C**2 - (H - L * cos(BETA)) ** 2)
    assert right.ram_mm == pytest.approx(L * sin(BETA) - across, rel=1e-13)
    assert p5.quick_return is not None
    assert p5.quick_return.ratio == pytest.approx((pi + 2 * BETA) / (pi - 2 * BETA), rel=1e-14)
    assert p5.quick_return.slow_towards == "left"
    steepest = max(abs(H - L), abs(H - L * cos(BETA))) / C
    least = 90.0 - degrees(asin(steepest))
    assert p5.least_transmission_angle_deg == pytest.approx(least, rel=1e-14)


def test_velocities_over_the_turn_are_kennedy_s(p5: SixBarShaper) -> None:
    phi = np.linspace(0.0, 2.0 * pi, 721)
    motion = p5.spec.shaper(p5.dimensions).motion(phi)
    assert np.abs(motion.ram[0] - ram(phi)).max() < 1e-11
    assert np.abs(motion.ram[1] - ram_rate(phi)).max() < 1e-10
    for mine, closed in zip(motion.guide_turn, guide_rates(phi), strict=True):
        assert np.abs(mine - closed).max() < 1e-13


@pytest.mark.parametrize("crank", range(0, 360, 30))
def test_the_page_s_table_to_forty_digits(p5: SixBarShaper, crank: int) -> None:
    phi = radians(crank)
    motion = p5.spec.shaper(p5.dimensions).motion(np.float64(phi))
    place, sine = exactly(phi)
    for mine, true in zip(motion.ram, place, strict=True):
        assert float(mine) == pytest.approx(float(true), rel=1e-12, abs=1e-11)
    s, s1, s2 = (float(each) for each in sine)
    cosine = -sqrt(1.0 - s * s)  # the left branch
    turn = s1 / cosine, (s2 + s * (s1 / cosine) ** 2) / cosine
    assert [float(each) for each in motion.coupler_turn] == pytest.approx(
        turn, rel=1e-11, abs=1e-13
    )


def test_extremes(p5: SixBarShaper) -> None:
    """The ram's by fine steps of Kennedy's; the rest in closed form."""
    of = {each.quantity: each for each in p5.extremes}
    phi = np.linspace(0.0, 2.0 * pi, 160_001)
    speed = ram_rate(phi)
    assert of["ram_velocity"].largest.value == pytest.approx(speed.max(), rel=1e-8)
    assert of["ram_velocity"].smallest.value == pytest.approx(speed.min(), rel=1e-8)
    bend = np.gradient(speed, phi)[1:-1]
    assert of["ram_acceleration"].largest.value == pytest.approx(bend.max(), rel=1e-6)
    assert of["ram_acceleration"].smallest.value == pytest.approx(bend.min(), rel=1e-6)
    fastest = degrees(R / (A - R)), degrees(R / (A + R))
    guide = of["guide_velocity"]
    assert (-guide.smallest.value, guide.largest.value) == pytest.approx(fastest, rel=1e-10)
    peak = degrees(guide_rates(phi)[1].max())
    assert of["guide_acceleration"].largest.value == pytest.approx(peak, rel=1e-7)


def test_beside_the_dead_centre_the_ram_moves() -> None:
    """0.033° off: 0.18 mm/s where the program takes it to stand still; half a ten-thousandth mm."""
    beside = np.array([-BETA - MISSED, -BETA, -BETA + MISSED])
    assert ram_rate(beside) == pytest.approx([0.1797, 0.0, -0.1795], abs=5e-5)
    away = ram(beside) - ram(beside)[1]
    assert away == pytest.approx([-5.2e-5, 0.0, -5.2e-5], abs=5e-7)


@pytest.mark.parametrize("alpha", [0.1, -0.05])
def test_a_crank_that_changes_its_speed_moves_another_ram(p5: SixBarShaper, alpha: float) -> None:
    """Over time, φ(t) = ω t + α t²/2: differences of places, and the peaks told."""
    found = solve(acceleration_rad_per_s2=alpha)
    of = {each.quantity: each.largest.value for each in found.extremes}
    last = (sqrt(1.0 + 4.0 * pi * alpha) - 1.0) / alpha
    t = np.linspace(0.0, last, 20_001)
    speed = np.gradient(ram(t + 0.5 * alpha * t * t), t)[1:-1]
    assert of["ram_velocity"] == pytest.approx(speed.max(), rel=1e-6)
    bend = np.gradient(speed, t[1:-1])[1:-1]
    assert of["ram_acceleration"] == pytest.approx(bend.max(), rel=1e-5)
    constant = {each.quantity: each.largest.value for each in p5.extremes}
    assert abs(of["ram_velocity"] / constant["ram_velocity"] - 1.0) > 0.25
    left = min(found.dead_centres, key=lambda one: one.ram_mm)
    turned = left.time_s + 0.5 * alpha * left.time_s**2
    assert turned == pytest.approx(pi + BETA, rel=1e-13)


def test_the_block_along_the_guide(p5: SixBarShaper) -> None:
    """By the cosine rule alone: ρ² = r² + a² + 2 r a sin φ, differentiated twice; at 1 rad/s."""
    turn = {name: column.values for name, column in SampledTurn.of(p5, 360).columns.items()}
    phi = np.radians(turn["crank_deg"])
    rho = np.sqrt(R * R + A * A + 2.0 * R * A * np.sin(phi))
    first = R * A * np.cos(phi) / rho
    second = -(R * A * np.sin(phi) + first**2) / rho
    for name, wanted in (("mm", rho), ("mm_per_s", first), ("mm_per_s2", second)):
        assert turn[f"slide_{name}"] == pytest.approx(wanted, abs=1e-9)
    (block,) = (each for each in p5.extremes if each.quantity == "sliding_acceleration")
    for peak, value, place in (
        (block.largest, R * A / (A - R), 270.0), (block.smallest, -R * A / (A + R), 90.0),
    ):  # fmt: skip
        assert peak.value == pytest.approx(value, rel=1e-10)
        assert peak.crank_deg == pytest.approx(place, abs=1e-3)


def test_the_sliding_velocity_is_largest_where_the_ram_stands(p5: SixBarShaper) -> None:
    """ρ' = r a cos φ/ρ, r at most: where crank and guide are square, at both dead centres."""
    (sliding,) = (each for each in p5.extremes if each.quantity == "sliding_velocity")
    assert sliding.largest.value == pytest.approx(R, rel=1e-11)
    centres = sorted(one.crank_deg for one in p5.dead_centres)
    at = [sliding.smallest.crank_deg, sliding.largest.crank_deg]
    assert at == pytest.approx(centres, abs=1e-6)
    for one in p5.dead_centres:
        phi = radians(one.crank_deg)
        rho = hypot(R * cos(phi), A + R * sin(phi))
        motion = p5.spec.shaper(p5.dimensions).motion(np.float64(phi))
        assert float(motion.slide[1]) == pytest.approx(R * A * cos(phi) / rho, rel=1e-13)
        assert abs(float(motion.ram[1])) < 1e-11


def test_the_other_branch_is_another_machine(p5: SixBarShaper) -> None:
    other = solve(ram_side="right")
    phi = np.linspace(0.0, 6.0, 13)
    mine = other.spec.shaper(other.dimensions).motion(phi).ram[0]
    assert np.abs(mine - ram(phi, side=1.0)).max() < 1e-11
    assert np.abs(mine + ram(pi - phi)).max() < 1e-11
    peaks = [each.largest for one in (p5, other) for each in one.extremes[:1]]
    assert peaks[0].value == pytest.approx(peaks[1].value, rel=1e-10)
    assert peaks[0].crank_deg + peaks[1].crank_deg == pytest.approx(540.0, abs=1e-4)


def test_time_is_the_angle_over_the_speed(p5: SixBarShaper) -> None:
    fast = solve(speed_rpm=60.0)
    for slow, quick in zip(p5.dead_centres, fast.dead_centres, strict=True):
        assert slow.time_s == pytest.approx(radians(slow.crank_deg), rel=1e-14)
        assert quick.time_s == pytest.approx(slow.time_s / (2.0 * pi), rel=1e-14)
    for order, name in enumerate(("ram_velocity", "ram_acceleration"), start=1):
        slow_peak, peak = (
            next(each for each in one.extremes if each.quantity == name).largest.value
            for one in (p5, fast)
        )
        assert peak == pytest.approx(slow_peak * (2.0 * pi) ** order, rel=1e-9)


def test_the_page_is_what_its_command_prints(capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(str(DOCS / "p5.py"), run_name="__main__")
    page = (DOCS / "p5.md").read_text(encoding="utf-8")
    tables = capsys.readouterr().out.strip().split("\n\n")
    assert len(tables) == 8
    for table in tables:
        assert table in page, "docs/reference/p5.md is out of date: python docs/reference/p5.py"
