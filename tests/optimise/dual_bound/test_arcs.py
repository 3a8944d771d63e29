"""Along an arc on which a limit binds ψ of the best multipliers vanishes: masses are moved so."""

from __future__ import annotations

import numpy as np
import pytest

from synthesis.numerics.piecewise import Array
from synthesis.optimise.dual_bound import arcs
from synthesis.optimise.dual_bound.bound import dual_bound
from synthesis.optimise.dual_bound.lagrangian import sums_at_start
from synthesis.optimise.dual_bound.row_functionals import row_functionals
from tests.optimise.scenes import (
    acceleration,
    angles,
    direct,
    dwell,
    even,
    fall,
    problem,
    rise,
    scene,
)

# The pressure angle binds along most of both laws, and the acceleration is what is capped.
PROGRAM = (rise(71.7, smoothness=1), dwell(23.9), fall(83.3, smoothness=1), dwell(181.1))
QUESTION = problem(scene(PROGRAM, angles(31.0, 43.0), acceleration(5.3, 71.7)))


def test_the_bound_gains_and_stays_below_the_optimum(monkeypatch: pytest.MonkeyPatch) -> None:
    best, coarse = (direct(QUESTION, even(QUESTION, n)) for n in (200, 40))
    flat = dual_bound(coarse.model, coarse.solution).value
    monkeypatch.setattr(arcs, "flatten", lambda _one, _nodes, mass, _psi: mass)
    plain = dual_bound(coarse.model, coarse.solution).value
    assert plain < flat < best.value
    assert best.value - flat < 0.5 * (best.value - plain)


def test_nothing_changes_before_an_arc_and_in_the_size() -> None:
    """Masses that alternate about a smooth density become smooth, and none is negative."""
    model = direct(QUESTION, even(QUESTION, 40)).model
    one = next(
        x for x in row_functionals(model, 2) if x.jumps and x.uniform and x.block.segment == 0
    )
    nodes, number = np.linspace(0.0, 1.0, 41), np.arange(41)
    density = np.where((number >= 10) & (number <= 31), 1.0 + nodes, 0.0)
    uneven = density * (1.0 + 0.3 * (-1.0) ** number)

    def psi(mass: Array, tau: Array) -> Array:
        ((rows, own),) = arcs.density_terms(one, nodes, mass)
        return rows.psi(tau) @ own

    smooth = arcs.flatten(one, nodes, uneven, lambda tau: psi(uneven - density, tau))
    assert np.min(smooth) >= 0.0
    np.testing.assert_array_equal(smooth[density == 0.0], 0.0)
    ((rows, own),) = arcs.density_terms(one, nodes, smooth - uneven)
    before = sums_at_start(rows.x, own[:, None] * rows.weights)
    np.testing.assert_allclose([*before, *(rows.size.T @ own)], 0.0, atol=1e-4)
    # what stays as it is takes up the ends of the arc
    np.testing.assert_allclose(smooth[15:27], density[15:27], atol=0.1)
    assert np.max(np.abs(uneven - density)[15:27]) > 0.4
