"""Pressure angle on an arm as a curved limit: what it says, and what follows from it."""

from __future__ import annotations

from math import atan, degrees, radians, tan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from synthesis.catalogue.constraints import MotionSizeBox, NonconvexConstraint
from synthesis.catalogue.followers import OscillatingRoller
from synthesis.catalogue.followers.arm_pressure_angle import (
    ConcaveHull,
    FixedPivotPressureAngle,
    FreePivotPressureAngle,
)
from synthesis.certify.quantities import TracedPoint, pressure_angle
from synthesis.optimise.conic.linear_rows import Scales
from synthesis.optimise.problem.problem import formulate_problem
from synthesis.optimise.relaxation.size_rows import reverse_convex_rows
from tests.optimise.arms import angles, jerk, scene

ARM, DISTANCE = 83.7, 101.9
SENSES = {"opposite": 1.0, "same": -1.0}


def motion(seed: int, count: int = 400) -> np.ndarray:
    rng = np.random.default_rng(seed)
    swing, rate = rng.uniform(0.0, 0.6, count), rng.uniform(-2.4, 2.4, count)
    return np.stack([ARM * swing, ARM * rate, np.zeros(count), np.zeros(count)])


def both(sense: str, limit: float) -> list[tuple[NonconvexConstraint, tuple[float, ...]]]:
    """The limit in its two charts, with one and the same size in both."""
    sigma, slope, angle = SENSES[sense], tan(limit), radians(31.7)
    free = FreePivotPressureAngle("pressure_angle", ARM, sigma, slope)
    fixed = FixedPivotPressureAngle("pressure_angle", ARM, DISTANCE, sigma, slope)
    pivot = DISTANCE * np.cos(angle), DISTANCE * np.sin(angle)
    return [(free, (float(pivot[0]), float(pivot[1]))), (fixed, (ARM * angle,))]


@pytest.mark.parametrize("sense", SENSES)
def test_exceeded_exactly_where_the_judge_measures_more(sense: str) -> None:
    limit, s = radians(38.3), motion(1)
    follower = OscillatingRoller(
        arm_mm=ARM, centre_distance_mm=DISTANCE, roller_radius_mm=7.9, sense=sense
    )
    for curve, z in both(sense, limit):
        size = z if len(z) == 1 else (ARM * float(np.arctan2(z[1], z[0])),)
        alpha = np.abs(pressure_angle(TracedPoint(follower, size, tuple(s))))
        beyond = np.max(np.stack(curve.excess(s, z)), axis=0) > 0.0
        clear = np.abs(alpha - limit) > 1e-9
        np.testing.assert_array_equal(beyond[clear], (alpha > limit)[clear])
        assert 0.1 < np.mean(beyond) < 0.95


@pytest.mark.parametrize("sense", SENSES)
def test_half_planes_allow_the_sizes_that_the_limit_allows(sense: str) -> None:
    s = motion(2)
    for curve, z in both(sense, radians(38.3)):
        for size in (z, *(tuple(k * v for v in z) for k in (0.7, 1.6, 4.6))):
            exceeded = np.max(np.stack(curve.excess(s, size)), axis=0) > 0.0
            planes = [np.array(size) @ cuts.size - cuts.upper for cuts in curve.half_planes(s)]
            outside = np.max(np.stack(planes), axis=0) > 0.0
            clear = np.abs(np.max(np.stack(planes), axis=0)) > 1e-9
            np.testing.assert_array_equal(outside[clear], exceeded[clear])


def test_where_no_size_is_allowed_the_half_planes_exclude_each_other() -> None:
    s = np.array([[3.0], [ARM], [0.0], [0.0]])  # l (1 + φ') = 2 l, more than D
    curve = FixedPivotPressureAngle("pressure_angle", ARM, DISTANCE, 1.0, tan(radians(35.0)))
    cuts = curve.half_planes(s)
    low = max(-part.upper[0] for part in cuts if part.size[0, 0] < 0.0)
    high = min(part.upper[0] for part in cuts if part.size[0, 0] > 0.0)
    assert low > high


@settings(max_examples=24)
@given(
    seed=st.integers(0, 10**6),
    sense=st.sampled_from(sorted(SENSES)),
    limit=st.floats(2.0, 80.0),
    ratio=st.floats(0.4, 2.5),
    w=st.tuples(st.floats(0.05, 2.6), st.floats(0.05, 2.6)),
    about=st.booleans(),
)
def test_cuts_hold_wherever_the_limit_does(
    seed: int, sense: str, limit: float, ratio: float, w: tuple[float, float], about: bool
) -> None:
    """Every motion and size within that keeps the limit keeps every row."""
    rng, n = np.random.default_rng(seed), 40
    slope, sigma = tan(radians(limit)), SENSES[sense]
    curve = FixedPivotPressureAngle("pressure_angle", ARM, ratio * ARM, sigma, slope)
    places = np.sort(ARM * rng.uniform(0.0, 0.5, (2, n)), axis=0)
    speeds = np.sort(ARM * rng.uniform(-1.2, 1.2, (2, n)), axis=0)
    sizes = (ARM * min(w), ARM * max(w))
    within = MotionSizeBox(places[0], places[1], speeds[0], speeds[1], (sizes,))
    where = np.stack([rng.uniform(*places), rng.uniform(*speeds)])
    place = (where, (rng.uniform(*sizes),)) if about else None
    rows = curve.linear_relaxation(within, place)
    assert rows
    for _ in range(20):
        s = np.zeros((4, n))
        s[0], s[1] = rng.uniform(places[0], places[1]), rng.uniform(speeds[0], speeds[1])
        size = rng.uniform(*sizes)
        psi = (s[0] + size) / ARM
        kept = np.max(np.stack(curve.excess(s, (size,))), axis=0) <= 0.0
        kept &= (psi >= 0.0) & (psi <= np.pi)
        for cuts in rows:
            left = np.sum(cuts.coefficients * s, axis=0) + cuts.size[0] * size
            assert np.all((left - cuts.upper)[kept] <= 1e-9 * ARM)


@settings(max_examples=18)
@given(
    seed=st.integers(0, 10**6),
    sense=st.sampled_from(sorted(SENSES)),
    limit=st.floats(2.0, 80.0),
    width=st.floats(1e-3, 2.0),
    about=st.booleans(),
)
def test_planes_of_a_free_pivot_hold_wherever_the_limit_does(
    seed: int, sense: str, limit: float, width: float, about: bool
) -> None:
    rng, n = np.random.default_rng(seed), 40
    curve = FreePivotPressureAngle("pressure_angle", ARM, SENSES[sense], tan(radians(limit)))
    places = np.sort(ARM * rng.uniform(0.0, 1.4, (2, n)), axis=0)
    speeds = np.sort(ARM * rng.uniform(-1.2, 1.2, (2, n)), axis=0)
    corner = ARM * rng.uniform(-0.5, 1.5), ARM * rng.uniform(0.0, 1.0)
    sizes = tuple((at, at + width * ARM * rng.uniform(0.1, 1.0)) for at in corner)
    within = MotionSizeBox(places[0], places[1], speeds[0], speeds[1], sizes)
    where = np.stack([rng.uniform(*places), rng.uniform(*speeds)])
    rows = curve.linear_relaxation(within, (where, corner) if about else None)
    assert rows
    for _ in range(20):
        s = np.zeros((4, n))
        s[0], s[1] = rng.uniform(places[0], places[1]), rng.uniform(speeds[0], speeds[1])
        size = tuple(rng.choice([a, b, rng.uniform(a, b)]) for a, b in sizes)
        kept = np.max(np.stack(curve.excess(s, size)), axis=0) <= 0.0
        for cuts in rows:
            left = np.sum(cuts.coefficients * s, axis=0) + np.array(size) @ cuts.size
            assert np.all((left - cuts.upper)[kept] <= 1e-11 * ARM)


def test_planes_of_a_free_pivot_close_in_on_the_limit_with_the_square_of_the_region() -> None:
    curve = FreePivotPressureAngle("pressure_angle", ARM, 1.0, tan(radians(38.3)))
    s, free = motion(3, 30), np.full(30, np.inf)
    size, lost = (93.1, 24.7), []
    for reach in (0.04, 0.02):
        ends = tuple((v - reach * ARM, v + reach * ARM) for v in size)
        within = MotionSizeBox(s[0] - reach * ARM, s[0] + reach * ARM, -free, free, ends)
        rows = curve.linear_relaxation(within, (s[:2], size))
        left = [
            np.sum(c.coefficients * s, axis=0) + np.array(size) @ c.size - c.upper for c in rows
        ]
        lost.append(ARM * np.stack(curve.excess(s, size)) - np.stack(left))
    assert np.all(lost[0] > 0.0)
    np.testing.assert_allclose(lost[0] / lost[1], 4.0, rtol=0.12)


def test_a_least_centre_distance_implies_a_row_over_a_box() -> None:
    """At its corners it is the distance itself; no size that is far enough is cut off."""
    question = scene(angles(), jerk(1.9), distance={"min": 97.3})
    sizes, scales = ((83.1, 97.9), (12.3, 31.7)), Scales(29.3, 1.0)
    problem = formulate_problem(question, question.objectives()[0])
    (row, *_) = reverse_convex_rows(problem, sizes, scales)

    def left(p: float, q: float) -> float:
        return float(row.size @ np.array([p, q]) / scales.size - row.rhs[0])

    rng = np.random.default_rng(5)
    inside = rng.uniform([a for a, _ in sizes], [b for _, b in sizes], (4000, 2))
    far = np.hypot(*inside.T) >= 97.3
    over = np.array([left(*z) for z in inside])
    assert 0.1 < np.mean(far) < 0.9
    assert np.all(over[far] <= 1e-12)
    assert np.mean(over[~far] > 0.0) > 0.7
    for p in sizes[0]:
        for q in sizes[1]:
            assert (left(p, q) > 0.0) == (np.hypot(p, q) < 97.3)
    assert not list(reverse_convex_rows(problem, ((97.4, 99.0), (0.0, 9.0)), scales))


@pytest.mark.parametrize("sense", SENSES)
def test_cuts_are_the_limit_itself_where_they_touch_and_it_is_convex(sense: str) -> None:
    """90° − α ≤ ψ ≤ 90° + α: there a row about a point has the limit's own value at it."""
    limit, n = radians(42.0), 30
    curve = FixedPivotPressureAngle("pressure_angle", ARM, DISTANCE, SENSES[sense], tan(limit))
    s = np.zeros((4, n))
    s[0], s[1] = np.linspace(0.0, 0.5 * ARM, n), np.linspace(-0.4, 0.4, n) * ARM
    size = ARM * radians(55.0)
    free = np.full(n, np.inf)
    within = MotionSizeBox(s[0] - 5.0, s[0] + 5.0, -free, free, ((size - 1.0, size + 1.0),))
    unit = max(ARM, DISTANCE / np.cos(limit))
    rows = curve.linear_relaxation(within, (s[:2], (size,)))
    assert len(rows) == 2
    for cuts, excess in zip(rows, curve.excess(s, (size,)), strict=True):
        left = np.sum(cuts.coefficients * s, axis=0) + cuts.size[0] * size - cuts.upper
        np.testing.assert_allclose(left, unit * excess, atol=1e-10 * unit)


@pytest.mark.parametrize("sense", SENSES)
@pytest.mark.parametrize("fastest", [np.inf, 0.5 * ARM])
def test_cuts_touch_the_limit_where_the_cosine_rises(sense: str, fastest: float) -> None:
    """ψ < α, so that v = ψ − α < 0: a row about a point has the limit's own value there too."""
    limit, n = radians(42.0), 30
    curve = FixedPivotPressureAngle("pressure_angle", ARM, ARM, SENSES[sense], tan(limit))
    s = np.zeros((4, n))
    s[0], s[1] = np.linspace(0.0, 0.5 * ARM, n), np.linspace(-0.4, 0.4, n) * ARM
    size, most = ARM * radians(5.0), np.full(n, fastest)
    # Everywhere the box holds angles on both sides of v = 0.
    within = MotionSizeBox(s[0] - 1.0, s[0] + ARM, -most, most, ((size - 1.0, size + 1.0),))
    unit = max(ARM, ARM / np.cos(limit))
    above, _ = curve.linear_relaxation(within, (s[:2], (size,)))
    left = np.sum(above.coefficients * s, axis=0) + above.size[0] * size - above.upper
    excess = unit * curve.excess(s, (size,))[0]
    assert np.all(left <= excess + 1e-10 * unit)
    active = np.arccos(np.clip((ARM + fastest) * np.cos(limit) / ARM, -1.0, 1.0))
    touched = (s[0] + size) / ARM - limit < -active - 0.05
    assert np.sum(touched) > 5
    np.testing.assert_allclose(left[touched], excess[touched], atol=1e-10 * unit)


def test_hull_is_the_least_concave_function_above_the_cosine() -> None:
    low, high = np.array([-0.6, 0.3, 1.7]), np.array([2.9, 1.2, 3.0])
    hull = ConcaveHull.over(low, high)
    for k in range(3):
        v = np.linspace(low[k], high[k], 2001)
        one = ConcaveHull(*(np.full(len(v), ends[k]) for ends in (hull.low, hull.high, hull.touch)))
        value, slope = one.line(v)
        least = np.array([np.min(value + slope * x) for x in v])
        assert np.all(least >= np.cos(v) - 1e-12)
        # the hull of the sampled graph, by chords
        chords = [
            np.max((np.cos(v[i + 1 :]) - np.cos(x)) / (v[i + 1 :] - x), initial=-2.0)
            for i, x in enumerate(v[:-1])
        ]
        assert least[0] == pytest.approx(np.cos(low[k]), abs=1e-9)
        assert least[-1] == pytest.approx(np.cos(high[k]), abs=1e-9)
        assert degrees(atan(max(chords))) < 90.0
        assert np.all(np.diff(least, 2) <= 1e-12)  # concave


def test_tangents_of_the_hull_touch_where_they_pass_the_end() -> None:
    """Or where the range begins, if none of them passes above the end."""
    rng = np.random.default_rng(29)
    low = rng.uniform(-1.57, 3.1, 4000)
    high = low + rng.uniform(0.0, 1.0, 4000) ** 3 * (np.pi - low)
    low[:50], high[:50] = 0.5 * np.pi, 0.5 * np.pi + np.logspace(-9, 0, 50)
    high[50:99] = low[50:99]
    with np.errstate(all="raise"):
        touch = ConcaveHull.over(low, high).touch
    assert np.all((low <= touch) & (touch <= high))
    over = np.cos(touch) - np.sin(touch) * (high - touch) - np.cos(high)
    assert np.all(over[touch > low] > -1e-14)
    beyond = (high > 0.5 * np.pi) & (touch > low)
    assert np.all(over[beyond] < 1e-14)
    assert np.sum(beyond) > 400
