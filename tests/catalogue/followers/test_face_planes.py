"""Rows that the limits of a swinging face imply where its angle and its speed lie in ranges."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from synthesis.catalogue.constraints import MotionSizeBox
from synthesis.catalogue.followers.swinging_face import SwingingFaceConstraint, minorant_plane

DISTANCE, COUNT = 71.3, 24


def limits(offset: float, least: float) -> dict[str, dict[str, float]]:
    return {
        "radius": {"bend": -1.0, "cubed": -(offset + least)},
        "own side": {"along": -1.0},
        "pressure angle": {"along": -0.15, "first": -abs(offset)},
        "far end": {"along": 1.0, "first": 50.0},
        "near end": {"along": -1.0, "first": -20.0},
    }


def least_bend(psi: np.ndarray, w: np.ndarray, radius: float, offset: float) -> np.ndarray:
    """φ'' at which the radius is reached: by h + h'' along the normal, h = d sinψ − f."""
    v = w - 1.0  # σ φ'; d/dχ = (1/w) d/dθ, the sign of χ drops out of the second derivative
    # h_χχ = d (cosψ φ'' − sinψ φ'²)/w² − d cosψ φ' σ φ''/w³ = d cosψ φ''/w³ − d sinψ v²/w²
    h = DISTANCE * np.sin(psi) - offset
    return (radius - h + DISTANCE * np.sin(psi) * v**2 / w**2) * w**3 / (DISTANCE * np.cos(psi))


@settings(max_examples=36)
@given(
    seed=st.integers(0, 10**6),
    name=st.sampled_from(sorted(limits(0.0, 0.0))),
    sigma=st.sampled_from([1.0, -1.0]),
    width=st.floats(0.01, 1.0),
)
def test_rows_hold_wherever_the_limit_does(
    seed: int, name: str, sigma: float, width: float
) -> None:
    rng = np.random.default_rng(seed)
    offset, least = rng.uniform(-6.0, 6.0), rng.uniform(0.0, 8.0)
    terms = limits(offset, least)[name]
    curve = SwingingFaceConstraint("", DISTANCE, sigma, offset, DISTANCE, **terms)
    low, slow = DISTANCE * rng.uniform(0.0, 0.3, COUNT), DISTANCE * rng.uniform(-0.5, 0.4, COUNT)
    high = low + 0.3 * DISTANCE * width * rng.uniform(0.0, 1.0, COUNT)
    fast = slow + 0.4 * DISTANCE * width * rng.uniform(0.0, 1.0, COUNT)
    base = rng.uniform(max(0.0, -offset), 33.0)
    sizes = (base, base + 24.0 * width)
    rows = curve.relax(MotionSizeBox(low, high, slow, fast, (sizes,)), None)
    assume(rows)  # over the widest boxes the face may turn past the axis: nothing is implied
    (row,) = rows
    for _ in range(40):
        s, z = np.zeros((4, COUNT)), rng.choice([*sizes, rng.uniform(*sizes)])
        s[0], s[1] = rng.uniform(low, high), rng.uniform(slow, fast)
        if name == "radius":
            psi = s[0] / DISTANCE + math.asin((z + offset) / DISTANCE)
            at = least_bend(psi, 1.0 + sigma * s[1] / DISTANCE, least, offset)
            s[2] = DISTANCE * (at + rng.choice([0.0, 1e-3]))
        kept = curve.excess(s, (z,))[0] <= 1e-12
        assert name != "radius" or np.all(kept)
        left = np.sum(row.coefficients * s, axis=0) + row.size[0] * z - row.upper
        assert np.all(left[kept] <= 1e-9)


def test_the_plane_closes_in_with_the_square_of_the_ranges() -> None:
    rng, lost = np.random.default_rng(3), []
    psi, w = rng.uniform(0.0, 0.8, COUNT), rng.uniform(0.6, 1.5, COUNT)
    for reach in (0.04, 0.02):
        below = minorant_plane(0.11, (psi - reach, psi + reach), (w - reach, w + reach))
        assert below is not None
        by_angle, by_speed, height = below
        there = 0.11 * w**3 / np.cos(psi) - w * (2.0 * w - 1.0) * np.tan(psi)
        lost.append(there - by_angle * psi - by_speed * w - height)
    assert np.all(lost[1] > 0.0)
    np.testing.assert_allclose(lost[0] / lost[1], 4.0, rtol=0.1)


@pytest.mark.parametrize(
    "change",
    [
        {"distance": None, "bend": -1.0},
        {"distance": DISTANCE, "lean": 1.0},
        {"distance": DISTANCE, "bend": -1.0, "offset": -30.0},
    ],
)
def test_where_no_row_is_known_none_is_said(change: dict[str, Any]) -> None:
    distance, offset = change.pop("distance"), change.pop("offset", 2.0)
    curve = SwingingFaceConstraint("", DISTANCE, 1.0, offset, distance, **change)
    one = np.ones(3)
    sizes = ((12.0, 13.0),) if distance else ((60.0, 61.0), (12.0, 13.0))
    assert not curve.relax(MotionSizeBox(one, 2.0 * one, one, 2.0 * one, sizes), None)
