"""Allowances for rounding and tolerances of verdicts: each one is needed, and none is tenfold."""

from __future__ import annotations

import math
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq

from synthesis.catalogue.followers import TranslatingRoller
from synthesis.catalogue.motion import FreeLaw, Motion
from synthesis.certify import certify, measure_objective, motion_checks, objectives
from synthesis.certify.objectives import root_mean_square
from synthesis.certify.piecewise_motion import PiecewiseMotion
from synthesis.certify.roller_interference import (
    NearestPair,
    OffsetProfile,
    ThickChords,
    _Pairs,
    _Search,
    groups_apart,
    near_groups,
)
from synthesis.numerics.box_search import Boxes
from synthesis.numerics.piecewise import Piecewise
from tests.certify.cams import Cam, motion_of, spline

LIFT = 17.3
BREAKS = np.linspace(0.0, 1.0, 12)
EXACT = np.polynomial.polynomial.polyint


def cam_of(rise: Piecewise, free: FreeLaw) -> Cam:
    segments = [("rise", 63.0, LIFT, rise), ("dwell", 40.0, 0.0, None),
                ("return", 257.0, LIFT, spline(3, BREAKS))]  # fmt: skip
    return Cam(motion_of(segments, free), 4.1, 6.7, 35.3)


def line(cam: Cam, name: str):
    found = certify(cam.motion, cam.machine, cam.size, [])
    return next(extreme for extreme in found if extreme.limit == name)


def bumped(size: float) -> Cam:
    bumps = np.zeros(14)
    bumps[-4] = 10.0**size
    return cam_of(spline(3, BREAKS, bumps), FreeLaw(2, overshoot=False))


@pytest.mark.parametrize(("share", "holds"), [(0.6e-9, True), (4e-9, False)])
def test_backward_travel_of_a_billionth_of_the_lift_is_none(share: float, holds: bool) -> None:
    def excess(size: float) -> float:
        motion = PiecewiseMotion(bumped(size).motion)
        travel = motion_checks.backward_travel(motion, motion.pieces_of([0]))[1][0] / LIFT
        return math.log(max(travel, 1e-300) / share)

    cam = bumped(brentq(excess, -6.0, -1.0, xtol=1e-9))
    assert line(cam, "overshoot").holds == holds


class Jets(SimpleNamespace):
    """Derivatives of a curve without their bounds of rounding: what is left to other guards."""

    def derivatives(self, piece, x):
        values = self.curve.jet(x, piece, 7)
        return values, np.zeros_like(values)


def polynomials(count: int, seed: int) -> Piecewise:
    """Whole numbers as coefficients, on pieces of a quarter: exact in floating point."""
    rng = np.random.default_rng(seed)
    ends = 0.25 * np.arange(count + 1)
    return Piecewise.of(ends, list(rng.integers(-(2**20), 2**20, (count, 5)).astype(float)))


def test_bernstein_coefficients_are_rounded() -> None:
    """Travel on intervals of one sign is enclosed, though the series itself is exact."""
    curve = polynomials(400, 3)
    motion = SimpleNamespace(
        curve=curve, jets=Jets(curve=curve), segment_of_piece=np.zeros(400, dtype=int),
        segments=[SimpleNamespace(lift=1.0)],
    )  # fmt: skip
    search = motion_checks._BackwardTravel(motion)
    boxes = Boxes.from_spans(
        np.arange(400), curve.breaks[:-1], curve.breaks[1:], np.full(400, 3)
    )  # fmt: skip
    search.bound(boxes)
    _, low, high = search.ends
    tight = 0
    for piece, lo, hi, least, most in zip(
        boxes.piece.tolist(), boxes.lo, boxes.hi, low, high, strict=True
    ):
        ends = [Fraction(float(x)) - Fraction(float(curve.origins[piece])) for x in (lo, hi)]
        before, after = (
            sum(Fraction(float(c)) * x**k for k, c in enumerate(curve.poly[piece])) for x in ends
        )
        if least > 0.0 and most - least < 1e-9 * most:  # of one sign
            tight += 1
            assert Fraction(least) <= before - after <= Fraction(most)
            assert most - least < 2.0**-40 * max(most, 2.0**20)
    assert tight > 100


def test_quadrature_is_rounded() -> None:
    for seed in range(20):
        curve = polynomials(7, seed)
        found = root_mean_square(Jets(curve=curve), 1)
        total = Fraction(0)
        for row in curve.poly:
            slope = [k * Fraction(float(c)) for k, c in enumerate(row)][1:]
            square = [Fraction(0)] * (2 * len(slope) - 1)
            for i, a in enumerate(slope):
                for j, b in enumerate(slope):
                    square[i + j] += a * b
            total += sum(c * Fraction(1, 4) ** (k + 1) / (k + 1) for k, c in enumerate(square))
        mean = (Decimal(total.numerator) / total.denominator / (2 * Decimal(math.pi))).sqrt()
        assert found.lower < found.value < found.upper
        assert Decimal(found.lower) <= mean <= Decimal(found.upper)
        assert found.width < 3e-13 * found.value


@pytest.mark.parametrize("nodes", [3, 4, 6, 9])
def test_the_remainder_of_few_gauss_points_is_bounded(
    nodes: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a sinusoid over a turn, whose mean square is ½ (aω^k)²."""
    monkeypatch.setattr(objectives, "WAVE_NODES", nodes)
    amplitude, frequency = 3.0, 2.0
    breaks = 2.0 * math.pi * np.array([0.0, 0.11, 0.29, 0.47, 0.68, 0.81, 1.0])
    waves = np.tile([amplitude, frequency, 0.3], (6, 1, 1))
    curve = Piecewise(breaks, np.zeros(6), np.zeros((6, 1)), waves)
    for order in (2, 3):
        found = root_mean_square(Jets(curve=curve), order)
        exact = amplitude * frequency**order / math.sqrt(2.0)
        assert found.lower <= exact <= found.upper
        assert nodes > 4 or abs(found.value - exact) > 1e-12 * exact


def test_the_prime_radius_is_rounded() -> None:
    rng = np.random.default_rng(4)
    for e, s0 in rng.uniform([1.0, 20.0], [10.0, 60.0], (200, 2)).tolist():
        cam = replace(cam_of(spline(3, BREAKS), FreeLaw(2, overshoot=True)), e=e, s0=s0)
        found = measure_objective("prime_radius", cam.motion, cam.machine, cam.size)
        exact = (Decimal(e) ** 2 + Decimal(s0) ** 2).sqrt()
        assert Decimal(found.lower) <= exact <= Decimal(found.upper)
        assert found.width < 4e-15 * found.value


# -- junctions -------------------------------------------------------------------------------


def torn(cam: Cam, piece: int, order: int, jump: float) -> Cam:
    """The cam with a derivative of s of one piece that is off by a jump."""
    curve = cam.motion.curve
    poly = curve.poly.copy()
    poly[piece, order] += jump / math.factorial(order)
    bent = Piecewise(curve.breaks, curve.origins, poly, curve.waves)
    return replace(cam, motion=Motion(cam.motion.segments, bent))


@pytest.mark.parametrize(("share", "holds"), [(0.6e-9, True), (4e-9, False)])
def test_a_jump_of_a_billionth_of_the_scale_is_none(share: float, holds: bool) -> None:
    cam = cam_of(spline(3, BREAKS), FreeLaw(2, overshoot=True))
    assert line(torn(cam, 5, 0, share * LIFT), "displacement_join").holds == holds


@pytest.mark.parametrize(("share", "holds"), [(0.6e-13, True), (4e-13, False)])
def test_control_points_are_rounded_beside_short_pieces(share: float, holds: bool) -> None:
    breaks = np.sort(np.append(BREAKS, BREAKS[5] + 1e-4))
    cam = cam_of(spline(3, breaks), FreeLaw(2, overshoot=True))
    length = float(np.diff(cam.motion.curve.breaks)[5])
    assert line(torn(cam, 5, 2, share * LIFT / length**2), "acceleration_join").holds == holds


@pytest.mark.parametrize(("off", "count"), [(15.0, 1), (-15.0, 1), (-60.0, 2)])
def test_a_part_that_reaches_into_a_piece_by_rounding_leaves_it_out(off: float, count: int) -> None:
    motion = PiecewiseMotion(cam_of(spline(3, BREAKS), FreeLaw(2, overshoot=True)).motion)
    junction = motion.curve.breaks[5]
    start, angle = motion.segments[0].start, motion.segments[0].angle
    part = ((junction + off * 2.0**-53 - start) / angle, (motion.curve.breaks[6] - start) / angle)
    pieces, _ = motion.spans_of([0], part)
    assert len(pieces) == count


def test_a_motion_that_stands_still_is_continuous() -> None:
    cam = Cam(motion_of([("dwell", 1.0, 0.0, None), ("dwell", 2.0, 0.0, None)]), 4.1, 6.7, 35.3)
    found = certify(cam.motion, cam.machine, cam.size, [], 2)
    assert all(extreme.holds for extreme in found)


# -- the roller and far parts of its profile -------------------------------------------------


@pytest.mark.parametrize(("depth", "excluded"), [(0.6e-9, True), (4e-9, False)])
def test_a_billionth_of_the_roller_is_no_interference(depth: float, excluded: bool) -> None:
    assert NearestPair(7.0, 7.0 * (1.0 - depth), 0.0, 0.0, 1).excludes_interference(7.0) == excluded


@pytest.mark.parametrize(("less", "near"), [(0.0, False), (5e-13, False), (5e-12, True)])
def test_half_a_turn_is_not_near(less: float, near: bool) -> None:
    heading = np.array([0.0, math.pi - less, 0.0, math.pi])
    found = near_groups(np.arange(4), heading, heading)
    assert found[0, 1] == near
    assert not found[2, 3]


@pytest.mark.parametrize(("apart", "disjoint"), [(0.0, False), (5e-13, False), (5e-12, True)])
def test_ranges_that_touch_are_not_disjoint(apart: float, disjoint: bool) -> None:
    low = np.array([0.0, 1.0 + apart, 2.5, 4.0])
    found = groups_apart(np.arange(4), low, np.array([1.0, 2.0, 3.0, 5.0]))
    assert found[0, 1] == disjoint


def test_distances_of_chords_are_rounded() -> None:
    """Of chords that are exact, far from the origin and near each other."""
    rng = np.random.default_rng(6)
    middle = rng.uniform(50.0, 60.0, (2, 500))
    half = rng.uniform(-1e-3, 1e-3, (2, 500))
    nothing = np.zeros(500)
    other = middle + rng.uniform(0.01, 0.1, (2, 500))
    chords = [ThickChords(m, half, nothing, m, nothing) for m in (middle, other)]
    profile = OffsetProfile(None, None, 1.0)
    search = _Search(profile)
    search.profile = SimpleNamespace(models=lambda _: SimpleNamespace(chords=lambda: chords))
    index = np.arange(500)
    lower = -search.bound(_Pairs(Boxes.from_spans(index, nothing, nothing, index), index, index))
    for k in range(500):
        d = [Decimal(float(x)) for x in middle[:, k]], [Decimal(float(x)) for x in other[:, k]]
        dx, dy = d[0][0] - d[1][0], d[0][1] - d[1][1]
        apart = (dx * dx + dy * dy).sqrt()
        a, b = (Decimal(float(x)) for x in half[:, k])
        exact = apart - 2 * abs(a * dx + b * dy) / apart
        assert Decimal(float(lower[k])) <= exact
        assert float(exact) - lower[k] < 2.0**-44 * 120.0


def test_a_roller_beside_the_axis_is_seen_whole() -> None:
    """Next to touching the axis, where the arc sine magnifies a rounding most."""
    follower = TranslatingRoller(roller_radius_mm=1.0, offset_mm=0.0)
    still = motion_of([("dwell", 1.0, 0.0, None)])
    rng = np.random.default_rng(2)
    for gap in 10.0 ** rng.uniform(-15.0, -9.0, 60):
        R, s0 = 1.0, 1.0 + gap
        profile = OffsetProfile(
            PiecewiseMotion(still), lambda s, s0=s0: follower.position(s, (0.0, s0)), R
        )
        point = Boxes.from_spans(np.array([0]), np.array([1.0]), np.array([1.0]), np.array([1]))
        low, high = profile.models(point).polar_range()
        # ± arcsin R/s0 = ± (π/2 − √(2 (1 − R/s0)) …) about π/2 − θ
        gap_exact = Decimal(1) - Decimal(R) / Decimal(float(s0))
        half = 0.5 * math.pi - float(2 * (gap_exact / 2).sqrt())
        assert high[0] - low[0] >= 2.0 * half - 1e-15
