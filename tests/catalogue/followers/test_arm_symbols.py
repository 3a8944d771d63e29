"""One formula of the arm's curvature serves numbers and CasADi's symbols alike."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

import synthesis.numerics.solvers.ipopt  # noqa: F401  (says how CasADi takes NumPy's names)
from synthesis.catalogue.followers import OscillatingRoller

S = np.array([[3.1, 17.9, 29.3], [41.7, 22.3, -9.7], [-87.1, 113.9, 31.3], [11.0, -7.0, 2.0]])


@pytest.mark.parametrize("sense", ["opposite", "same"])
@pytest.mark.parametrize("distance", [97.3, None])
@pytest.mark.parametrize("free", [True, False])
def test_symbols_give_what_numbers_give(sense: str, distance: float | None, free: bool) -> None:
    follower = OscillatingRoller(
        arm_mm=81.7, centre_distance_mm=distance, roller_radius_mm=12.3, sense=sense
    )
    z = (50.3, 71.1) if distance is None else (81.7 * 1.1,)
    size = [casadi.MX.sym(f"z{k}") for k in range(len(z))]
    motion = [casadi.MX.sym(f"s{k}", 3) for k in range(4)]
    # s is made of symbols where the law is free, and of columns of numbers where it is given
    columns = motion if free else [casadi.DM(row) for row in S]
    found = follower.curvature_terms(columns, size)
    curvature = found[0] / found[1] ** 1.5
    assert curvature.shape == (3, 1)
    values = casadi.Function("f", [*motion, *size], [curvature])(*S.tolist(), *z)
    N, W2 = follower.curvature_terms(S, z)
    np.testing.assert_allclose(np.array(values).ravel(), N / W2**1.5, rtol=1e-13)
