"""Rows that the limits of a swinging face imply where its angle and its speed lie in ranges."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from synthesis.catalogue.constraints import MotionSizeBox
from synthesis.catalogue.followers.swinging_face import SwingingFaceConstraint

DISTANCE, COUNT = 71.3, 24


def limits(offset: float, least: float) -> dict[str, dict[str, float]]:
    return {
        "radius": {"bend": -1.0, "cubed": -(offset + least)},
        "own side": {"along": -1.0},
        "pressure angle": {"along": -0.15, "first": -abs(offset)},
        "far end": {"along": 1.0, "first": 50.0},
        "near end": {"along": -1.0, "first": -20.0},
        "outer radius": {"lean": 1.0, "known": 30.0 + offset},
    }


def least_bend(
    psi: np.ndarray, w: np.ndarray, radius: float, offset: float, distance: float = DISTANCE
) -> np.ndarray:
    """φ'' at which the radius is reached: by h + h'' along the normal, h = d sinψ − f."""
    v = w - 1.0  # σ φ'; d/dχ = (1/w) d/dθ, the sign of χ drops out of the second derivative
    # h_χχ = d (cosψ φ'' − sinψ φ'²)/w² − d cosψ φ' σ φ''/w³ = d cosψ φ''/w³ − d sinψ v²/w²
    h = distance * np.sin(psi) - offset
    return (radius - h + distance * np.sin(psi) * v**2 / w**2) * w**3 / (distance * np.cos(psi))


@settings(max_examples=36)
@given(
    seed=st.integers(0, 10**6),
    name=st.sampled_from(sorted(limits(0.0, 0.0))),
    sigma=st.sampled_from([1.0, -1.0]),
    width=st.floats(0.01, 1.0),
    pivot=st.booleans(),
    near=st.booleans(),
)
def test_rows_hold_wherever_the_limit_does(
    seed: int, name: str, sigma: float, width: float, pivot: bool, near: bool
) -> None:
    """The centre distance is given, or it is a size variable."""
    rng = np.random.default_rng(seed)
    offset, least = rng.uniform(-6.0, 6.0), rng.uniform(0.0, 8.0)
    terms = limits(offset, least)[name]
    distance = DISTANCE if pivot else None
    curve = SwingingFaceConstraint("", DISTANCE, sigma, offset, distance, **terms)
    low, slow = DISTANCE * rng.uniform(0.0, 0.3, COUNT), DISTANCE * rng.uniform(-0.5, 0.4, COUNT)
    high = low + 0.3 * DISTANCE * width * rng.uniform(0.0, 1.0, COUNT)
    fast = slow + 0.4 * DISTANCE * width * rng.uniform(0.0, 1.0, COUNT)
    base = rng.uniform(max(0.0, -offset), 33.0)
    sizes = [(base, base + 24.0 * width)]
    if not pivot:
        p = math.sqrt(DISTANCE**2 - (base + offset) ** 2)
        sizes.insert(0, (p - 9.0 * width, p + 9.0 * width))
    place = np.zeros((3, COUNT))
    place[0], place[1] = rng.uniform(low, high), rng.uniform(slow, fast)
    about = (place, tuple(a for a, _ in sizes)) if near else None
    rows = curve.linear_relaxation(MotionSizeBox(low, high, slow, fast, tuple(sizes)), about)
    assume(rows)  # over the widest boxes the face may turn past the axis: nothing is implied
    (row,) = rows
    for _ in range(40):
        s, z = np.zeros((4, COUNT)), [rng.choice([a, b, rng.uniform(a, b)]) for a, b in sizes]
        s[0], s[1] = rng.uniform(low, high), rng.uniform(slow, fast)
        q = z[-1] + offset
        reach = DISTANCE if pivot else math.hypot(z[0], q)
        if name == "radius":
            psi, w = s[0] / DISTANCE + math.asin(q / reach), 1.0 + sigma * s[1] / DISTANCE
            at = least_bend(psi, w, least, offset, reach)
            s[2] = DISTANCE * (at + rng.choice([0.0, 1e-3]))
        kept = curve.excess(s, z)[0] <= 1e-12
        assert name != "radius" or np.all(kept)
        left = np.sum(row.coefficients * s, axis=0) + np.array(z) @ row.size - row.upper
        assert np.all(left[kept] <= 1e-9)


def test_a_row_closes_in_with_the_square_of_the_ranges() -> None:
    rng, lost = np.random.default_rng(3), []
    s, z = DISTANCE * np.zeros((3, COUNT)), 14.9
    s[0], s[1] = DISTANCE * rng.uniform(0.0, 0.3, COUNT), DISTANCE * rng.uniform(-0.3, 0.3, COUNT)
    curve = SwingingFaceConstraint("", DISTANCE, 1.0, 2.0, DISTANCE, bend=-1.0, cubed=-6.3)
    at = least_bend(
        s[0] / DISTANCE + math.asin((z + 2.0) / DISTANCE), 1.0 + s[1] / DISTANCE, 4.3, 2.0
    )
    for reach in (0.04, 0.02):
        away = reach * DISTANCE
        sizes = ((z - away, z + away),)
        box = MotionSizeBox(s[0] - away, s[0] + away, s[1] - away, s[1] + away, sizes)
        (row,) = curve.linear_relaxation(box, (s, (z,)))
        left = np.sum(row.coefficients[:2] * s[:2], axis=0) + row.coefficients[2] * DISTANCE * at
        lost.append(row.upper - left - row.size[0] * z)
    assert np.all(lost[1] > 0.0)
    np.testing.assert_allclose(lost[0] / lost[1], 4.0, rtol=0.2)


@pytest.mark.parametrize("distance", [None, DISTANCE])
@pytest.mark.parametrize("far", [0, 1, 2])
def test_where_no_row_is_known_none_is_said(distance: float | None, far: int) -> None:
    """Motion without bounds; a face past the right angle; one beyond its pivot."""
    curve = SwingingFaceConstraint("", DISTANCE, 1.0, 2.0, distance, bend=-1.0)
    one = DISTANCE * np.full(3, 0.1)
    sizes = ((40.0, 41.0),) if distance else ((60.0, 61.0), (40.0, 41.0))
    fast, high = (np.inf if far == 0 else 1.0) * one, (12.0 if far == 1 else 2.0) * one
    if far == 2:
        sizes = ((68.0, 70.0),) if distance else ((-1.0, 3.0), (40.0, 41.0))
    assert not curve.linear_relaxation(MotionSizeBox(one, high, -one, fast, sizes), None)
    within = ((40.0, 41.0),) if distance else ((60.0, 61.0), (40.0, 41.0))
    assert curve.linear_relaxation(MotionSizeBox(one, 2.0 * one, -one, one, within), None)
