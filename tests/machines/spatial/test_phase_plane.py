"""The bound of the fastest run, against closed forms, other bounds and many laws."""

from __future__ import annotations

import math
from itertools import pairwise, product
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from synthesis.catalogue.laws import LAWS
from synthesis.catalogue.laws.rest_to_rest import scca
from synthesis.machines.spatial.sizing.phase_plane import PhasePlane, least_size
from synthesis.machines.spatial.sizing.sequential_convex import bound_by_chords, minimise_size
from synthesis.optimise.problem.boundary import boundary_states
from synthesis.optimise.problem.grid import uniform_grid
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.state import SolveState
from tests.machines.spatial.sizes import (
    INNER,
    SPEED,
    TURN,
    WIDTH,
    globoidal,
    jerk,
    pressure_angle,
    problem_of,
)

OUTER = INNER + WIDTH
SLOPE = math.tan(math.radians(41.3))
LIMIT = pressure_angle(41.3)


def phase_plane_bound(problem: Problem) -> float:
    """The bound in lengths of the rollers' outer ends."""
    grids = [uniform_grid(segment, 8) for segment in problem.free]
    ends, _ = boundary_states(problem.segments, grids)
    (track,) = (
        PhasePlane.of(problem, segment, (own.start, own.end))
        for segment, own in zip(problem.free, ends, strict=True)
    )
    return least_size(track, 1.5 * OUTER, 1e6) / OUTER


@pytest.mark.parametrize(("rollers", "dwell_on", "steps"), [
    (6, "rib", 1), (6, "groove", 1), (9, "rib", 2), (4, "groove", 1),
])  # fmt: skip
def test_with_nothing_capped_the_pressure_angle_is_the_limit_all_along(
    rollers: int, dwell_on: str, steps: int
) -> None:
    """∫ dψ / (c − cos ψ) of the nearest roller is β tan α."""
    spacing, lift = 2.0 * math.pi / rollers, steps * 360.0 / rollers
    first = 0.5 * spacing if dwell_on == "rib" else 0.0

    def angle(c: float) -> float:
        def slow(q: float) -> float:
            return 1.0 / (c - math.cos(math.remainder(first + q, spacing)))

        kinks = [k * spacing / 2.0 for k in range(2 * steps + 1)]
        parts = (quad(slow, a, b, epsabs=1e-12)[0] for a, b in pairwise(kinks))
        return sum(parts) - math.radians(TURN) * SLOPE

    body = globoidal(LIMIT, rollers=rollers, dwell_on=dwell_on, lift=lift)
    expected = brentq(angle, 1.0 + 1e-6, 20.0, xtol=1e-12)
    assert phase_plane_bound(problem_of(body)) == pytest.approx(expected, rel=3e-6)
    assert phase_plane_bound(problem_of(body)) < expected


def test_with_many_rollers_it_is_the_least_peak_velocity_under_a_jerk_cap() -> None:
    """cos ψ is all but 1, so that C = ρ (1 + V Ψ/(β t)) with V(1 − 2 √(V/J)) = 1."""
    lift = 360.0 / 64
    cap = 32.0 * 1.9
    peak = brentq(lambda v: v * (1.0 - 2.0 * math.sqrt(v / cap)) - 1.0, 1.0, cap / 9.0)
    expected = 1.0 + peak * math.radians(lift) / (math.radians(TURN) * SLOPE)
    body = globoidal(LIMIT, jerk(1.9, lift), rollers=64, lift=lift, roller_radius_mm=1.0)
    assert expected - 2e-3 < phase_plane_bound(problem_of(body)) < expected


def capped(order: int, times: float) -> dict[str, Any]:
    """A cap on velocity or acceleration, so many times the mean velocity over β^k."""
    name = ("velocity", "acceleration")[order - 1]
    seconds = TURN / (6.0 * SPEED)
    return {"kind": name, f"max_deg_per_s{'2' if order == 2 else ''}": times * 60 / seconds**order}


LIMITS = {
    "jerk": (jerk(2.3),),
    "tight jerk": (jerk(1.02),),
    "acceleration": (capped(2, 6.1),),
    "all": (jerk(3.1), capped(2, 6.3), capped(1, 1.71)),
}


@pytest.fixture(scope="module", params=LIMITS)
def found(request: pytest.FixtureRequest) -> tuple[str, SolveState]:
    problem = problem_of(globoidal(LIMIT, *LIMITS[request.param]))
    return request.param, minimise_size(problem, 2e-3, math.inf, 1e-7)


def of_law(curve: Any) -> tuple[float, list[float]]:
    """Least C in lengths of the outer end with a law, and peaks of its derivatives."""
    x = np.linspace(0.0, 1.0, 1501)
    g = curve.derivatives(x, 3)
    q, q1 = math.pi / 3.0 * g[0], math.pi / 3.0 * np.abs(g[1]) / math.radians(TURN)
    psi = math.pi / 6.0 + q
    psi = psi - math.pi / 3.0 * np.round(psi * 3.0 / math.pi)
    return float(np.max(np.cos(psi) + q1 / SLOPE)), [float(np.max(np.abs(d))) for d in g[1:]]


def test_no_law_of_a_family_that_keeps_the_caps_is_better(found: tuple[str, SolveState]) -> None:
    name, search = found
    assert search.incumbent is not None
    caps = {"jerk": (9e9, 9e9, 2.3 * 32), "tight jerk": (9e9, 9e9, 1.02 * 32),
            "acceleration": (9e9, 6.1, 9e9), "all": (1.71, 6.3, 3.1 * 32)}[name]  # fmt: skip
    curves = [LAWS[law].curve("rise") for law in ("cycloidal", "modified_trapezoid")]
    shares = np.linspace(0.02, 0.9, 23)
    curves += [scca(b, 1.0 - b - d, d) for b, d in product(shares, shares) if b + d <= 1.0]
    tried = [of_law(curve) for curve in curves]
    kept = [c for c, peaks in tried if all(p <= cap for p, cap in zip(peaks, caps, strict=True))]
    mine, peaks = of_law(search.incumbent.laws[0].curve())
    assert mine == pytest.approx(search.incumbent.size[0] / OUTER, rel=1e-6)
    assert all(p <= cap * (1.0 + 1e-9) for p, cap in zip(peaks, caps, strict=True))
    assert mine < min(kept, default=9.0)
    assert search.lower / OUTER <= mine


def test_both_bounds_hold_and_meet(found: tuple[str, SolveState]) -> None:
    _, search = found
    assert search.incumbent is not None
    run = OUTER * phase_plane_bound(search.problem)
    grids = tuple(uniform_grid(segment, 96) for segment in search.problem.free)
    again = SolveState(search.problem, 1e-9, math.inf, 1e-7, grids=grids)
    _, duality = bound_by_chords(again, search.incumbent.size[0], 1)
    assert duality is not None
    value = search.incumbent.value
    assert search.is_good_enough
    assert 0.98 * value < run < value
    assert 0.9 * value < duality.value < value
