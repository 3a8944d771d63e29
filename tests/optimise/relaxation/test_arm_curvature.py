"""Curvature on arms: rows over boxes hold wherever the judge sees the limit kept."""

from __future__ import annotations

from itertools import product
from math import radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from synthesis.catalogue.box_bounds import BoxBound
from synthesis.catalogue.constraints import MotionBox
from synthesis.catalogue.followers import OscillatingRoller
from synthesis.catalogue.followers.closures import Force
from synthesis.catalogue.followers.conjugate import ConjugateArm
from synthesis.catalogue.followers.kinematics import TracePoint
from synthesis.certify.quantities import TracedPoint, pitch_curvature

ARM, DISTANCE, COUNT = 83.7, 101.9, 24


def trace(sense: str, counter: bool, pivot: bool) -> TracePoint:
    other = ConjugateArm(roller_radius_mm=6.1, arm_mm=71.3, angle_deg=74.9)
    main = OscillatingRoller(
        arm_mm=ARM, centre_distance_mm=DISTANCE if pivot else None, roller_radius_mm=7.9,
        sense=sense, closure=other if counter else Force(),
    )  # fmt: skip
    return other.counter(main) if counter else main


def size(angle: float, pivot: bool) -> tuple[float, ...]:
    return (ARM * angle,) if pivot else (DISTANCE * np.cos(angle), DISTANCE * np.sin(angle))


def relaxed(
    bound: BoxBound, low: np.ndarray, high: np.ndarray, sizes: tuple[tuple[float, float], ...],
    about: tuple[np.ndarray, tuple[float, ...]] | None,
) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:  # fmt: skip
    """Rows over s and s' in (2, n) ranges and a box of sizes: (3, n), (d, n) and (n,)."""
    seen = bound.coordinates
    corners = [seen.evaluate([*s, 0.0 * s[0]], z) for s in (low, high) for z in product(*sizes)]
    points = np.stack([np.stack(np.broadcast_arrays(*corner)) for corner in corners])
    free = np.full((1, low.shape[1]), np.inf)
    moving = MotionBox(
        np.zeros(low.shape[1]), np.concatenate([low, -free]), np.concatenate([high, free]), sizes,
        about,
    )  # fmt: skip
    place = None if about is None else np.stack(np.broadcast_arrays(*seen.evaluate(*about)))
    rows = bound.linear_relaxation(points.min(axis=0), points.max(axis=0), place, moving)
    return [(row.coefficients, row.size, row.upper) for row in rows]


@settings(max_examples=40)
@given(
    seed=st.integers(0, 10**6),
    sense=st.sampled_from(["same", "opposite"]),
    counter=st.booleans(),
    pivot=st.booleans(),
    side=st.sampled_from([1, -1]),
    width=st.floats(1e-3, 0.3),
    near=st.booleans(),
)
def test_rows_hold_wherever_the_judge_measures_no_more(
    seed: int, sense: str, counter: bool, pivot: bool, side: int, width: float, near: bool
) -> None:
    rng, radius = np.random.default_rng(seed), 17.3
    point = trace(sense, counter, pivot)
    (bound,) = point.curvature_bounds(side, 1.0 / radius)
    start = rng.uniform(0.2, 0.6)
    low = ARM * rng.uniform([[0.0], [-0.5]], [[0.3], [0.4]], (2, COUNT))
    high = low + ARM * width * rng.uniform(0.0, 0.4, (2, COUNT))
    middle = size(start, pivot)
    sizes = tuple((z - 0.2 * width * ARM, z + 0.2 * width * ARM) for z in middle)
    about = None
    if near:
        share = rng.uniform(0.0, 1.0, (2, COUNT))
        there = low + share * (high - low)
        about = np.concatenate([there, np.zeros((1, COUNT))]), middle
    rows = relaxed(bound, low, high, sizes, about)
    assert rows
    for _ in range(25):
        s, z = np.zeros((4, COUNT)), tuple(rng.choice([a, b, rng.uniform(a, b)]) for a, b in sizes)
        s[:2] = low + rng.choice([0.0, 1.0, 0.37], (2, COUNT)) * (high - low)
        # s'' at which the curvature is the limit: it is linear in s''
        at = []
        for bend in (0.0, ARM):
            s[2] = bend
            at.append(side * pitch_curvature(TracedPoint(point, z, tuple(s))))
        slope = (at[1] - at[0]) / ARM
        s[2] = (1.0 / radius - at[0]) / slope - np.sign(slope) * rng.choice([0.0, 1e-2], COUNT)
        for by, by_size, upper in rows:
            left = np.sum(by[:3] * s[:3], axis=0) + np.array(z) @ by_size - upper
            assert np.all(left <= 1e-9)


@pytest.mark.parametrize("pivot", [True, False])
@pytest.mark.parametrize("counter", [True, False])
def test_rows_close_in_on_the_limit_with_the_square_of_the_box(pivot: bool, counter: bool) -> None:
    point, lost = trace("same", counter, pivot), []
    (bound,) = point.curvature_bounds(1, 1.0 / 17.3)
    rng, z = np.random.default_rng(4), size(radians(25.0), pivot)
    s = ARM * rng.uniform([[0.0], [-0.4], [0.0]], [[0.3], [0.3], [0.0]], (3, COUNT))
    for reach in (0.02, 0.01):
        sizes = tuple((v - reach * ARM, v + reach * ARM) for v in z)
        low, high = s[:2] - reach * ARM, s[:2] + reach * ARM
        ((by, by_size, upper),) = relaxed(bound, low, high, sizes, (s, z))
        still = np.zeros(COUNT)
        curvature = [
            pitch_curvature(TracedPoint(point, z, (s[0], s[1], still + bend, still)))
            for bend in (0.0, ARM)
        ]
        bend = ARM * (1.0 / 17.3 - curvature[0]) / (curvature[1] - curvature[0])
        lost.append(upper - by[0] * s[0] - by[1] * s[1] - by[2] * bend - np.array(z) @ by_size)
    assert np.all(lost[1] > 0.0)
    np.testing.assert_allclose(lost[0] / lost[1], 4.0, rtol=0.2)


@pytest.mark.parametrize("pivot", [True, False])
def test_no_row_is_said_of_arms_beyond_the_line_to_the_axis(pivot: bool) -> None:
    """There Q ≤ 0, and the limit reads the other way round."""
    for counter, start in ((False, -0.7), (False, 0.01), (True, 1.4)):
        (bound,) = trace("same", counter, pivot).curvature_bounds(1, 1.0 / 17.3)
        low = ARM * np.array([[0.0, 0.01], [-0.1, 0.1]])
        sizes = tuple((z - 2.0, z + 2.0) for z in size(start, pivot))
        assert not relaxed(bound, low, low + 1.0, sizes, None)
