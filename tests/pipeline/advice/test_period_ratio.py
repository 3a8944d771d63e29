"""The figures in the reason of the rule period_ratio, by a train of one mass of the test's own."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from synthesis.pipeline.advice.period_ratio import LEAST, RULE

STEPS = 6000  # of a move; the ratios keep five digits


def cycloidal(t: np.ndarray) -> np.ndarray:
    return 2.0 * np.pi * np.sin(2.0 * np.pi * t)


def polynomial(t: np.ndarray) -> np.ndarray:
    return 60.0 * t - 180.0 * t**2 + 120.0 * t**3


def modified_sine(t: np.ndarray) -> np.ndarray:
    middle = np.cos(4.0 * np.pi * (t - 0.125) / 3.0)
    ends = np.where(t < 0.5, np.sin(4.0 * np.pi * t), np.sin(4.0 * np.pi * (t - 1.0)))
    return np.where((t > 0.125) & (t < 0.875), middle, ends)


def amplification(law: Callable[[np.ndarray], np.ndarray], periods: float) -> float:
    """Peak acceleration of an undamped mass on a spring over that of its foot, during a move.

    Exact where the foot's acceleration is linear in a step: x'' + ω² x = −a, x the compression.
    """
    a = law(np.linspace(0.0, 1.0, STEPS + 1))
    omega, h = 2.0 * np.pi * periods, 1.0 / STEPS
    cos, sin = np.cos(omega * h), np.sin(omega * h)
    x, v, largest = 0.0, 0.0, 0.0
    for start, end in pairwise(a):
        still, slope = -start / omega**2, -(end - start) / h / omega**2
        x, v = x - still, v - slope
        x, v = (x * cos + v / omega * sin + still + slope * h,
                v * cos - x * omega * sin + slope)  # fmt: skip
        largest = max(largest, abs(omega**2 * x))
    return largest / float(np.max(np.abs(a)))


@pytest.mark.parametrize(
    ("law", "told"), [(cycloidal, "1.5 "), (polynomial, "1.65 "), (modified_sine, "1.84 ")]
)
def test_a_short_move_is_amplified_as_the_rule_says(
    law: Callable[[np.ndarray], np.ndarray], told: str
) -> None:
    assert told in RULE.reason
    assert f"{amplification(law, LEAST):.3g}" == told.strip()
    assert f"{amplification(law, 10.0):.2f}" in ("1.10", "1.15")
