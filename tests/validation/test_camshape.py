"""Public benchmark camshape: feasible as stated, and no feasible radius anywhere is larger.

Source: COPS, CUTEst and MINLPLib (camshape100 … camshape800); the argument is in
docs/reference/camshape.md.
"""

import runpy
from math import cos, pi
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.optimize import linprog

from benchmarks.camshape import ALPHA, LARGEST, LEAST, PUBLISHED, SIZES, bound, shape, value

DOCS = Path(__file__).resolve().parents[2] / "docs" / "reference"
OTHERS = (41, 137, 1013)  # nothing special

every_size = pytest.mark.parametrize("n", [*SIZES, *OTHERS])


@pytest.mark.parametrize("n", PUBLISHED)
def test_the_published_optimum_to_its_last_digit(n: int) -> None:
    assert f"{value(shape(n)):.9f}" == f"{PUBLISHED[n]:.9f}"


@every_size
def test_every_constraint_as_stated(n: int) -> None:
    radii = shape(n)
    r = dict(zip(range(-1, n + 3), radii.tolist(), strict=True))
    theta = 2.0 * pi / (5 * (n + 1))
    assert (r[-1], r[0]) == pytest.approx((1.0, 1.0), rel=1e-15)
    assert (r[n + 1], r[n + 2]) == (2.0, 2.0)
    assert radii.min() >= LEAST - 1e-15
    assert radii.max() <= LARGEST
    for i in range(n + 2):
        assert 2.0 * r[i - 1] * r[i + 1] * cos(theta) <= r[i] * (r[i - 1] + r[i + 1]) + 1e-14
    for i in range(n + 1):
        assert abs(r[i + 1] - r[i]) <= ALPHA * theta + 1e-14
    assert value(radii) == pytest.approx(pi / n * sum(r[i] for i in range(1, n + 1)), rel=1e-13)


@every_size
def test_no_feasible_radius_is_larger(n: int) -> None:
    proof, radii = bound(n), shape(n)[2:-2]
    excess = proof.radii - radii
    assert excess.min() >= -1e-14
    assert excess.max() <= 1e-8
    assert 0.0 <= proof.value - value(shape(n)) <= 1e-8


@pytest.mark.parametrize("n", [41, 137])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_solver_ends_at_the_same_radii(n: int, seed: int) -> None:
    """An LP in u = 1/r: growth by its tangent, which allows less, and random positive weights."""
    best = 1.0 / shape(n)[2:-2]
    theta = 2.0 * pi / (5 * (n + 1))
    growth = ALPHA * theta
    convex = sp.diags_array([1.0, -2.0 * cos(theta), 1.0], offsets=[0, 1, 2], shape=(n + 2, n + 4))
    # u_{i+1} >= f(u_i), f(u) = u/(1 + αθ u), concave: its tangent at the point lies above it
    u = np.concatenate([[1.0], best, [0.5]])
    slope = 1.0 / (1.0 + growth * u[:-1]) ** 2
    start = u[:-1] / (1.0 + growth * u[:-1]) - slope * u[:-1]
    grown = sp.csr_array(
        (
            np.concatenate([-slope, np.ones(n + 1)]),
            (np.tile(np.arange(n + 1), 2), np.concatenate([np.arange(n + 1), np.arange(1, n + 2)])),
        ),
        shape=(n + 1, n + 2),
    )
    edge = sp.csr_array((n + 1, 1))
    rows = sp.vstack([convex, sp.hstack([edge, grown, edge])])
    least = np.concatenate([np.zeros(n + 2), start])
    bounds = [(1.0, 1.0)] * 2 + [(0.5, 1.0)] * n + [(0.5, 0.5)] * 2
    weights = np.random.default_rng(seed).uniform(0.1, 1.0, n + 4)
    found = linprog(weights, A_ub=-rows, b_ub=1e-13 - least, bounds=bounds, method="highs")
    assert found.status == 0
    np.testing.assert_allclose(found.x[2:-2], best, rtol=0, atol=1e-6)


def test_random_feasible_cams_are_nowhere_larger() -> None:
    """Radius after radius, each a random part of what convexity and growth allow."""
    n, rng = 137, np.random.default_rng(7)
    theta = 2.0 * pi / (5 * (n + 1))
    best, tried = shape(n), 0
    for eagerness in rng.uniform(0.0, 1.0, 200):
        u = [1.0, 1.0]
        for _ in range(n):
            least = max(2.0 * cos(theta) * u[-1] - u[-2], 1.0 / (1.0 / u[-1] + ALPHA * theta), 0.5)
            slack = rng.uniform(0.0, 1.0) * eagerness**4
            u.append(least + slack * max(u[-1] - least, 0.0))
        if 2.0 - 1.0 / u[-1] <= ALPHA * theta:
            tried += 1
            assert np.all(1.0 / np.array(u) <= best[:-2] + 1e-13)
    assert tried >= 50


def test_the_documented_table_is_what_the_command_prints(
    capsys: pytest.CaptureFixture[str],
) -> None:
    runpy.run_path(str(DOCS / "camshape.py"), run_name="__main__")
    assert capsys.readouterr().out.strip() in (DOCS / "camshape.md").read_text(encoding="utf-8")
