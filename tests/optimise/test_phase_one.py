"""The gentlest law: its share of the highest cap, by closed forms, and the bound over all laws.

Under caps V and A of velocity and acceleration a rise needs, in units of h/β^k, jerk of
A/(1 − V/A − 1/V): it goes up to A, stays, down to 0 at V, and back alike.
"""

from __future__ import annotations

from math import inf
from typing import Any

import pytest

from synthesis.numerics.solvers.highs import LinearRows
from synthesis.optimise.problem.grid import uniform_grid
from synthesis.optimise.strategy import phase_one
from synthesis.optimise.strategy.phase_one import (
    INTERVALS,
    MOST_KNOTS,
    least_excess,
    minimise_excess,
)
from tests.optimise.scenes import acceleration, dwell, fall, jerk, problem, rise, scene, velocity

UP, DOWN = 71.3, 113.7  # the slower return is held back by none of the limits
V, A = 1.6, 5.3
LEAST = A / (1.0 - V / A - 1.0 / V)
SHARES = (0.93, 1.0 / 1.0004, 1.0 - 3e-6, 1.0 + 3e-6, 1.004, 1.013, 1.3)


def limited(share: float) -> Any:
    """Caps of which the gentlest law takes this share of that on the jerk."""
    program = [rise(UP), dwell(37.9), fall(DOWN), dwell(137.1)]
    caps = [velocity(V, UP), acceleration(A, UP), jerk(LEAST / share, UP)]
    return problem(scene(program, *caps, base=300.0))


@pytest.mark.parametrize("share", SHARES)
def test_share_and_bound_meet_the_closed_form(share: float) -> None:
    asked = limited(share)
    found = minimise_excess(asked, [uniform_grid(s, 4 * INTERVALS) for s in asked.free], 0.0)
    assert found is not None
    assert found.fits == (share < 1.0)
    assert found.least <= share * (1.0 + 1e-12)
    if not found.fits:
        assert bool(found.impossible) == (share > 1.0)
        assert found.share == pytest.approx(share, rel=1e-6)
        assert found.share - found.least <= 1e-6


def test_the_simplex_method_gets_few_knots_however_many_a_mesh_has(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """On 909 knots HiGHS ended the process."""
    asked, columns, own = limited(1.004), list[int](), phase_one.minimise_each

    def measured(rows: LinearRows, *others: Any, **more: Any) -> Any:
        columns.append(rows.matrix.shape[1])
        assert columns[-1] <= len(asked.free) * (MOST_KNOTS + 4)
        return own(rows, *others, **more)

    monkeypatch.setattr(phase_one, "minimise_each", measured)
    assert minimise_excess(asked, [uniform_grid(s, 400) for s in asked.free], 0.0)
    assert columns


def test_a_law_of_many_switches_is_left_to_meshes(monkeypatch: pytest.MonkeyPatch) -> None:
    """A basis of as many rows has an inverse whose squares overflow."""
    asked = limited(1.004)
    fine = tuple(uniform_grid(s, MOST_KNOTS) for s in asked.free)
    monkeypatch.setattr(phase_one, "grids_on_switches", lambda *_: fine)
    monkeypatch.setattr(phase_one, "minimise_each", None)
    found = minimise_excess(asked, [uniform_grid(s, INTERVALS) for s in asked.free], 0.0)
    assert found is not None
    assert found.impossible


@pytest.mark.parametrize("late", [False, True])
def test_what_is_late_is_not_settled(late: bool) -> None:
    # the velocity leaves no law that keeps the jerk
    question = limited(1.02)
    grids, stop = [uniform_grid(s, INTERVALS) for s in question.free], 0.0 if late else inf
    found = minimise_excess(question, grids, 0.0, stop)
    assert (found is None) == late
    assert (least_excess(question, grids, 0.0, stop) is None) == late
    assert (phase_one.least_excess_program(question, stop) is None) == late
