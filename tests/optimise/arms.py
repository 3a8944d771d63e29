"""Arms on a pivot in few words, and their pressure angle by the instant centre."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import pi, radians
from typing import Any

import numpy as np
from scipy.optimize import differential_evolution

from synthesis.numerics.piecewise import Array
from synthesis.spec.design_spec import DesignSpec

RPM = 47.3
OMEGA = RPM * 2.0 * pi / 60.0
ARM, SWING = 83.7, 21.3
RISE, HOLD, FALL = 78.4, 33.1, 101.9
SENSES = {"opposite": 1.0, "same": -1.0}


def jerk(factor: float, swing: float = SWING) -> dict[str, Any]:
    """``factor`` times the least that the rise needs, in deg/s³."""
    return {"kind": "jerk", "max_deg_per_s3": factor * 32.0 * swing / radians(RISE) ** 3 * OMEGA**3}


def angles(rise: float = 38.3, back: float = 44.1) -> dict[str, Any]:
    return {"kind": "pressure_angle", "rise_deg": rise, "return_deg": back}


def body(
    *limits: dict[str, Any],
    distance: Any = None,
    sense: str = "opposite",
    law: str = "spline",
    scale: float = 1.0,
    **more: Any,
) -> dict[str, Any]:
    def move(kind: str, angle: float) -> dict[str, Any]:
        return {"kind": kind, "angle_deg": angle, "lift_deg": SWING, "law": {"kind": law}}

    return {
        "speed_rpm": RPM,
        "program": [
            move("rise", RISE), {"kind": "dwell", "angle_deg": HOLD}, move("return", FALL),
            {"kind": "dwell", "angle_deg": 360.0 - RISE - HOLD - FALL},
        ],
        "follower": {
            "kind": "oscillating_roller", "arm_mm": ARM * scale, "sense": sense,
            "roller_radius_mm": 7.9 * scale, "centre_distance_mm": distance,
        },
        "limits": list(limits),
        **more,
    }  # fmt: skip


def scene(*limits: dict[str, Any], **more: Any) -> DesignSpec:
    return DesignSpec.model_validate(body(*limits, **more))


def slope(
    psi: Array, rate: Array, distance: float | Array, sense: str, arm: float | Array = ARM
) -> Array:
    """tan α by the instant centre of cam and arm, which divides d as the speeds do.

    Args:
        psi: angle at the pivot between arm and line of centres [rad].
        rate: φ', positive where the arm lifts.
    """
    away = distance / (1.0 + SENSES[sense] * rate)  # of the centre from the pivot
    return np.asarray((arm - away * np.cos(psi)) / (away * np.sin(psi)))


Ends = tuple[float, float]


def least(worth: Callable[[Array, int], Array], bounds: Sequence[Ends]) -> float:
    """Least value by differential evolution: roughly over the bounds, then finely near it.

    ``worth`` takes points (n, k) and the number of cam angles at which limits are looked at, and
    gives the values (k,) of all points at once.
    """

    def search(count: int, ends: Sequence[Ends], accuracy: float) -> Any:
        return differential_evolution(
            worth, ends, (count,), rng=7, popsize=12, tol=0.0, atol=accuracy, maxiter=400,
            polish=False, vectorized=True, updating="deferred",
        )  # fmt: skip

    rough = search(151, bounds, 1e-6).x
    around = [
        (max(low, x - 0.005 * (high - low)), min(high, x + 0.005 * (high - low)))
        for x, (low, high) in zip(rough, bounds, strict=True)
    ]
    return float(search(1501, around, 1e-8).fun)
