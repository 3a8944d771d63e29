"""The shaper's motion against forty-digit differences of its position, and its dead centres."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from decimal import Decimal

import numpy as np
import pytest

from synthesis.errors import InputError
from synthesis.machines.linkages.shaper import report
from synthesis.machines.linkages.shaper.mechanism import Drive, Motion, Shaper, Side, angle
from tests.forty_digits import cos, sin

P5 = Shaper(125.0, 600.0, 150.0, 275.0, 575.0, "left")
ROCKING = Shaper(61.3, 297.1, 143.7, 129.9, 281.3)
TURNING = Shaper(130.7, 137.3, 333.1, 71.9, 41.7)
IN_LINE = Shaper(100.0, 600.0, 60.0, 200.0, 575.0)  # four dead centres a turn
ALL = [replace(one, side=side) for one in (P5, ROCKING, TURNING) for side in ("left", "right")]
STEP = Decimal(10) ** -12
PHI = [0.37, 2.113, 3.9, 5.71]


def place(shaper: Shaper, phi: Decimal) -> dict[str, Decimal]:
    """Sines, cosines and lengths at a crank angle, from the triangles alone, to forty digits."""
    lengths = (shaper.crank, shaper.guide, shaper.coupler, shaper.pivot_distance, shaper.ram_line)
    r, guide, coupler, a, height = (Decimal(each) for each in lengths)
    x, y = r * cos(phi), a + r * sin(phi)
    rho = (x * x + y * y).sqrt()
    end_x, end_y = guide * x / rho, guide * y / rho
    across = (coupler**2 - (height - end_y) ** 2).sqrt()
    side = 1 if shaper.side == "right" else -1
    return {"slide": rho, "ram": end_x + side * across, "guide": y / rho,
            "coupler": (height - end_y) / coupler}  # fmt: skip


def differences(shaper: Shaper, phi: float, name: str) -> tuple[Decimal, Decimal, Decimal]:
    """A quantity with both derivatives by central differences: exact to some twenty digits."""
    at = Decimal(phi)
    low, here, high = (place(shaper, at + k * STEP)[name] for k in (-1, 0, 1))
    return here, (high - low) / (2 * STEP), (high - 2 * here + low) / (STEP * STEP)


def rates(motion: Motion, name: str) -> tuple[float, float, float]:
    """The same from the product; of angles their sines."""
    if name in ("slide", "ram"):
        return getattr(motion, name)
    (c, s), (first, second) = getattr(motion, name), getattr(motion, f"{name}_turn")
    return s, c * first, c * second - s * first**2


@pytest.mark.parametrize("shaper", ALL, ids=lambda one: f"{one.crank:g}-{one.side}")
def test_rates_are_the_derivatives_of_positions(shaper: Shaper) -> None:
    for phi, name in itertools.product(PHI, ("slide", "ram", "guide", "coupler")):
        found = rates(shaper.motion(np.float64(phi)), name)
        size = max(abs(value) for value in found)
        for mine, true in zip(found, differences(shaper, phi, name), strict=True):
            assert abs(Decimal(float(mine)) - true) <= Decimal(1e-12 * size), (phi, name)


def test_branches_are_mirror_images() -> None:
    phi = np.linspace(0.0, 6.0, 7)
    for shaper in (P5, TURNING):
        other = replace(shaper, side="right" if shaper.side == "left" else "left")
        mine, mirrored = shaper.motion(phi).ram, other.motion(math.pi - phi).ram
        for order, (one, two) in enumerate(zip(mine, mirrored, strict=True)):
            assert np.allclose(one, -((-1) ** order) * two, rtol=1e-12, atol=1e-10)


@pytest.mark.parametrize("shaper", [P5, ROCKING, TURNING, IN_LINE], ids=lambda one: f"{one.crank}")
@pytest.mark.parametrize(("sense", "side"), [(1.0, "right"), (-1.0, "right"), (1.0, "left")])
def test_dead_centres_are_all_turns_of_the_ram(shaper: Shaper, sense: float, side: Side) -> None:
    shaper = replace(shaper, side=side)
    drive = Drive(0.3, sense, 1.0)
    found = report.dead_centres(shaper, drive)
    for one in found:
        phi = math.radians(one.crank_deg)
        assert abs(shaper.motion(np.float64(phi)).ram[1]) < 1e-12 * shaper.guide
    turned = np.linspace(0.0, 2.0 * math.pi, 20_001)
    ram = shaper.motion(drive.phi(turned)).ram
    turns = np.flatnonzero(np.diff(np.sign(ram[1])))
    assert len(turns) == len(found)
    assert np.allclose(
        turned[turns], np.radians([one.crank_travel_deg for one in found]), atol=2e-3
    )
    stroke = max(one.ram_mm for one in found) - min(one.ram_mm for one in found)
    assert stroke == pytest.approx(np.ptp(ram[0]), rel=1e-6)


def test_p5() -> None:
    """Closed forms: stroke 2 L r/a, ratio (π + 2β)/(π − 2β), dead centres at −β and π + β."""
    beta = math.asin(125.0 / 275.0)
    right, left = sorted(report.dead_centres(P5, Drive(0.0, 1.0, 1.0)), key=lambda one: -one.ram_mm)
    assert right.ram_mm - left.ram_mm == pytest.approx(2.0 * 600.0 * 125.0 / 275.0, rel=1e-14)
    assert right.crank_travel_deg == pytest.approx(360.0 - math.degrees(beta), rel=1e-14)
    assert left.crank_travel_deg == pytest.approx(180.0 + math.degrees(beta), rel=1e-14)


def test_extremes_enclose_what_is_found_by_sampling() -> None:
    drive = Drive(1.2, -1.0, 2.3, 0.31)
    found = report.extremes(IN_LINE, drive)
    turned = np.linspace(0.0, 2.0 * math.pi, 100_001)
    motion = IN_LINE.motion(drive.phi(turned))
    for quantity, peaks in zip(report.QUANTITIES, found, strict=True):
        largest, smallest = peaks.largest, peaks.smallest
        values = quantity.of(motion, drive, turned) / quantity.per_unit
        for peak, sampled in ((largest, values.max()), (smallest, values.min())):
            assert peak.value == pytest.approx(sampled, rel=1e-6)
            assert abs(peak.value - sampled) <= 1e-6 * np.ptp(values)
            assert peak.width is not None
            assert peak.width <= 1e-6 * np.ptp(values)
        assert largest.value + (largest.width or 0.0) >= values.max()
        assert smallest.value - (smallest.width or 0.0) <= values.min()


def test_what_is_not_proven_is_not_claimed() -> None:
    """A coupler that all but stands upright: values that are reached, without an enclosure."""
    coupler = P5.ram_line - P5.guide * math.cos(P5.swing)
    nearly = replace(P5, coupler=coupler * (1.0 + 2.0**-50))
    found = report.extremes(nearly, Drive(0.0, 1.0, 1.0))
    widths = {peaks.quantity: peaks.largest.width for peaks in found}
    assert widths["coupler_velocity"] is None
    assert widths["guide_velocity"] is not None
    assert all(
        math.isfinite(peak.value) for peaks in found for peak in (peaks.largest, peaks.smallest)
    )


def test_time_is_not_angle_where_the_crank_speeds_up() -> None:
    """Rates by time against differences in time, φ(t) = φ0 + σ (ω0 t + α t²/2)."""
    drive = Drive(0.4, -1.0, 3.1, 0.57)
    times = np.array([0.05, 0.4, 0.9, 1.4])

    def turned(t: np.ndarray) -> np.ndarray:
        return 3.1 * t + 0.5 * 0.57 * t * t

    def ram(t: np.ndarray) -> np.ndarray:
        return P5.motion(drive.phi(turned(t))).ram[0]

    h = 1e-4
    at, motion = turned(times), P5.motion(drive.phi(turned(times)))
    assert np.allclose(drive.time(at), times, rtol=1e-14)
    speed = (ram(times + h) - ram(times - h)) / (2.0 * h)
    assert np.allclose(drive.first(motion.ram[1], at), speed, rtol=1e-6)
    bend = (ram(times + h) - 2.0 * ram(times) + ram(times - h)) / h**2
    assert np.allclose(drive.second(motion.ram[1], motion.ram[2], at), bend, rtol=1e-4, atol=1e-2)


def test_a_turning_guide_turns_once() -> None:
    turned = np.linspace(0.0, 2.0 * math.pi, 401)
    guide = angle(TURNING.motion(turned).guide)
    assert guide[-1] - guide[0] == pytest.approx(2.0 * math.pi, rel=1e-12)
    assert np.ptp(angle(P5.motion(turned).guide)) == pytest.approx(2.0 * P5.swing, rel=1e-4)


@pytest.mark.parametrize(
    ("change", "field", "words"),
    [
        ({"coupler": 40.0}, "/coupler_mm", "more than 40.5659 mm, or a ram_line_mm between"),
        ({"ram_line": 900.0}, "/coupler_mm", "more than 365.566 mm"),
        ({"crank": 275.0}, "/crank_mm", "shorter crank"),
        ({"crank": 290.0}, "/coupler_mm", "more than 1175 mm"),
        ({"crank": 1e-4}, "/crank_mm", "at least 0.0006 mm"),
    ],
)
def test_what_cannot_turn_is_refused(change: dict[str, float], field: str, words: str) -> None:
    with pytest.raises(InputError) as refused:
        report.check_assembly(replace(P5, **change))
    assert refused.value.field == field
    assert words in refused.value.remedy


def test_a_crank_that_stops_is_refused() -> None:
    with pytest.raises(InputError, match="stops after") as refused:
        Drive(0.0, 1.0, 1.0, -0.1)
    assert "-0.0795775" in refused.value.remedy
