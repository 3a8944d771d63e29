"""Pressure angle on an arm as a curved limit: what it says, and what follows from it."""

from __future__ import annotations

from math import atan, degrees, radians, tan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from synthesis.certify.quantities import pressure_angle
from synthesis.followers import OscillatingRoller
from synthesis.followers.arm_pressure import FixedPivot, FreePivot, Hull
from synthesis.terms import Curved, Within

ARM, DISTANCE = 83.7, 101.9
SENSES = {"opposite": 1.0, "same": -1.0}


def motion(seed: int, count: int = 400) -> np.ndarray:
    rng = np.random.default_rng(seed)
    swing, rate = rng.uniform(0.0, 0.6, count), rng.uniform(-2.4, 2.4, count)
    return np.stack([ARM * swing, ARM * rate, np.zeros(count), np.zeros(count)])


def both(sense: str, limit: float) -> list[tuple[Curved, tuple[float, ...]]]:
    """The limit in its two charts, with one and the same size in both."""
    sigma, slope, angle = SENSES[sense], tan(limit), radians(31.7)
    free = FreePivot("pressure_angle", ARM, sigma, slope)
    fixed = FixedPivot("pressure_angle", ARM, DISTANCE, sigma, slope)
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
        alpha = np.abs(pressure_angle(follower, size, tuple(s)))
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
    curve = FixedPivot("pressure_angle", ARM, DISTANCE, 1.0, tan(radians(35.0)))
    cuts = curve.half_planes(s)
    low = max(-part.upper[0] for part in cuts if part.size[0, 0] < 0.0)
    high = min(part.upper[0] for part in cuts if part.size[0, 0] > 0.0)
    assert low > high


@settings(max_examples=300)
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
    curve = FixedPivot("pressure_angle", ARM, ratio * ARM, sigma, slope)
    places = np.sort(ARM * rng.uniform(0.0, 0.5, (2, n)), axis=0)
    speeds = np.sort(ARM * rng.uniform(-1.2, 1.2, (2, n)), axis=0)
    sizes = (ARM * min(w), ARM * max(w))
    within = Within(places[0], places[1], speeds[0], speeds[1], (sizes,))
    where = np.stack([rng.uniform(*places), rng.uniform(*speeds)])
    place = (where, (rng.uniform(*sizes),)) if about else None
    rows = curve.cuts(within, place)
    assert rows
    for _ in range(60):
        s = np.zeros((4, n))
        s[0], s[1] = rng.uniform(places[0], places[1]), rng.uniform(speeds[0], speeds[1])
        size = rng.uniform(*sizes)
        psi = (s[0] + size) / ARM
        kept = np.max(np.stack(curve.excess(s, (size,))), axis=0) <= 0.0
        kept &= (psi >= 0.0) & (psi <= np.pi)
        for cuts in rows:
            left = np.sum(cuts.coefficients * s, axis=0) + cuts.size[0] * size
            assert np.all((left - cuts.upper)[kept] <= 1e-9 * ARM)


@pytest.mark.parametrize("sense", SENSES)
def test_cuts_are_the_limit_itself_where_they_touch_and_it_is_convex(sense: str) -> None:
    """90° − α ≤ ψ ≤ 90° + α: there a row about a point has the limit's own value at it."""
    limit, n = radians(42.0), 30
    curve = FixedPivot("pressure_angle", ARM, DISTANCE, SENSES[sense], tan(limit))
    s = np.zeros((4, n))
    s[0], s[1] = np.linspace(0.0, 0.5 * ARM, n), np.linspace(-0.4, 0.4, n) * ARM
    size = ARM * radians(55.0)
    free = np.full(n, np.inf)
    within = Within(s[0] - 5.0, s[0] + 5.0, -free, free, ((size - 1.0, size + 1.0),))
    unit = max(ARM, DISTANCE / np.cos(limit))
    rows = curve.cuts(within, (s[:2], (size,)))
    assert len(rows) == 2
    for cuts, excess in zip(rows, curve.excess(s, (size,)), strict=True):
        left = np.sum(cuts.coefficients * s, axis=0) + cuts.size[0] * size - cuts.upper
        np.testing.assert_allclose(left, unit * excess, atol=1e-10 * unit)


def test_hull_is_the_least_concave_function_above_the_cosine() -> None:
    low, high = np.array([-0.6, 0.3, 1.7]), np.array([2.9, 1.2, 3.0])
    hull = Hull.over(low, high)
    for k in range(3):
        v = np.linspace(low[k], high[k], 2001)
        one = Hull(*(np.full(len(v), ends[k]) for ends in (hull.low, hull.high, hull.touch)))
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
