"""What mends an arm that breaks its pressure angle, against looking at every place of its pivot."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from synthesis import DesignSpec, analyse
from synthesis.design.analysis import Analysis
from synthesis.design.design import WITHOUT_CAM

EXAMPLES = Path(__file__).parents[2] / "openapi" / "examples" / "analyses"
ARM, ROLLER, SWING, RISE, FALL = 85.0, 30.0, np.radians(45.0), np.radians(80.0), np.radians(150.0)
LIMIT = np.tan(np.radians(45.0))


def body(sense: str) -> dict[str, Any]:
    example: dict[str, Any] = json.loads((EXAMPLES / f"p3-{sense}.json").read_text())["value"]
    limit = {"kind": "pressure_angle", "rise_deg": 45.0, "return_deg": 45.0}
    return example | {"limits": [limit]}


def moves() -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """φ, φ', φ'' of the 3-4-5 rise and of the cycloidal return, (m, 1) each."""
    x = np.linspace(0.0, 1.0, 101)[:, None]
    up = (10 * x**3 - 15 * x**4 + 6 * x**5, 30 * x**2 * (1 - x) ** 2,
          60 * x * (1 - x) * (1 - 2 * x))  # fmt: skip
    turn = 2.0 * np.pi * x
    down = (x - np.sin(turn) / (2 * np.pi), 1 - np.cos(turn), 2 * np.pi * np.sin(turn))
    rise = tuple(SWING * g / RISE**k for k, g in enumerate(up))
    fall = tuple(SWING * ((1 - g) if k == 0 else -g) / FALL**k for k, g in enumerate(down))
    return [rise, fall]  # type: ignore[list-item]


def worst(sense: str, d: np.ndarray, psi0: np.ndarray) -> np.ndarray:
    """Excess over the pressure angle and over the roller's curvature, (n,) of (n,) places.

    tan α = (l (1 + σφ') − d cosψ) / (d sinψ); the roller's centre as a complex number, its arm L:
    c = e^{−iθ} (d + L), L' = iτψ' L with τ = −σ.
    """
    sigma, found = {"opposite": 1.0, "same": -1.0}[sense], np.full(len(d), -np.inf)
    for phi, rate, bend in moves():
        psi = psi0 + phi
        tan = np.abs(ARM * (1.0 + sigma * rate) - d * np.cos(psi)) / (d * np.sin(psi))
        arm = ARM * np.exp(1j * (np.pi - sigma * psi))
        first = -1j * sigma * rate * arm
        second = -1j * sigma * bend * arm - rate**2 * arm
        c1, c2 = -1j * (d + arm) + first, -(d + arm) - 2j * first + second
        undercut = -ROLLER * np.imag(np.conj(c1) * c2) / np.abs(c1) ** 3 - 1.0
        excess = np.maximum(np.where(np.sin(psi) > 0.0, tan, np.inf) - LIMIT, undercut)
        found = np.maximum(found, np.max(excess, axis=0))
    return found


def least(sense: str, distances: np.ndarray) -> float:
    """The smallest prime radius at which some pivot keeps both, on a grid closed in twice."""
    best, span = (np.inf, 0.0, 0.0), (0.02, 2.2)
    width = float(np.ptp(distances))
    for _ in range(7):
        d, psi0 = (a.ravel() for a in np.meshgrid(distances, np.linspace(*span, 41)))
        kept = np.concatenate([worst(sense, *part) for part in zip(
            np.array_split(d, 40), np.array_split(psi0, 40), strict=True)]) <= 0.0  # fmt: skip
        prime = np.sqrt(d**2 + ARM**2 - 2.0 * d * ARM * np.cos(psi0))
        if kept.any():
            k = int(np.argmin(np.where(kept, prime, np.inf)))
            best = min(best, (float(prime[k]), float(d[k]), float(psi0[k])))
        if not np.isfinite(best[0]):
            return np.inf
        width, reach = 0.25 * width, 0.125 * (span[1] - span[0])
        span = (best[2] - reach, best[2] + reach)
        distances = np.linspace(best[1] - 0.5 * width, best[1] + 0.5 * width, len(distances))
    return best[0]


@cache
def analysed(sense: str) -> Analysis:
    return analyse(DesignSpec.model_validate(body(sense)))


@pytest.mark.usefixtures("unexplained")
@pytest.mark.parametrize("sense", ["opposite", "same"])
def test_what_mends_an_arm_s_pressure_angle_is_the_smallest_there_is(sense: str) -> None:
    found = analysed(sense)
    assert found.violated == ["pressure_angle_rise", "pressure_angle_return"]
    assert found.remedy is not None
    kept, free = found.remedy.sizes
    here = least(sense, np.array([100.0]))
    assert (kept.status == "infeasible") == (not np.isfinite(here))
    if kept.status != "infeasible":
        assert kept.dimensions["prime_radius_mm"] == pytest.approx(here, rel=1e-3)
    anywhere = least(sense, np.linspace(40.0, 300.0, 31))
    assert free.dimensions["prime_radius_mm"] == pytest.approx(anywhere, rel=2e-3)


@pytest.mark.usefixtures("unexplained")
@pytest.mark.parametrize("sense", ["opposite", "same"])
def test_a_mended_arm_keeps_every_limit(sense: str) -> None:
    question, found = body(sense), analysed(sense)
    assert found.remedy is not None
    for size in found.remedy.sizes:
        if size.status in WITHOUT_CAM:
            continue
        place = {"centre_distance_mm": size.dimensions["centre_distance_mm"]}
        mended = question | {
            "follower": question["follower"] | place,
            "base_radius_mm": size.dimensions["base_radius_mm"],
        }
        again = analyse(DesignSpec.model_validate(mended))
        assert again.holds, again.broken
