"""Rows that differ from point to point: a translating roller's own, written as a curved limit."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import pytest

from synthesis.catalogue.constraints import (
    LinearInequality,
    MotionSizeBox,
    NonconvexConstraint,
    PointInequalities,
    Vector,
)
from synthesis.catalogue.followers.translating_roller import TranslatingRoller
from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.clarabel import solve
from synthesis.optimise.conic.law_bounds import LawBounds
from synthesis.optimise.conic.program import formulate
from synthesis.optimise.driver import optimise
from synthesis.optimise.dual_bound.bound import dual_bound
from synthesis.optimise.problem.grid import uniform_grid
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.closed_form import closed_form_size
from tests.optimise.scenes import angles, dwell, fall, jerk, problem, rise, scene


@dataclass(frozen=True)
class Bent(NonconvexConstraint):
    """A fixed row in the words of a curved limit."""

    order: ClassVar[int] = 1
    row: LinearInequality

    def excess(self, s: Any, z: Any) -> tuple[Any, ...]:
        value = sum(a * v for a, v in zip(self.row.coefficients, s, strict=True))
        value += sum(a * v for a, v in zip(self.row.size, z, strict=True)) - self.row.upper
        return (value / 30.0,)

    def half_planes(self, s: Array) -> tuple[PointInequalities, ...]:
        size = np.tile(np.array(self.row.size)[:, None], s.shape[1])
        return (
            PointInequalities(
                np.zeros_like(s), size, self.row.upper - np.array(self.row.coefficients) @ s
            ),
        )

    def linear_relaxation(
        self, within: MotionSizeBox, about: tuple[Array, Vector] | None
    ) -> tuple[PointInequalities, ...]:
        one = np.ones((1, len(within.s_min)))
        size = np.array(self.row.size)[:, None] * one
        rows = np.array(self.row.coefficients)[:, None] * one
        return (PointInequalities(rows, size, self.row.upper * one[0]),)


class BentRoller(TranslatingRoller):
    """A translating roller that says its pressure angle as curved limits."""

    def pressure_angle_rows(self, slope: float) -> tuple[LinearInequality, ...]:
        return ()

    def pressure_angle_constraints(self, slope: float) -> tuple[NonconvexConstraint, ...]:
        return tuple(Bent("", row) for row in super().pressure_angle_rows(slope))


def bent(question: Problem) -> Problem:
    follower = BentRoller.model_validate(question.machine.follower.model_dump())
    return replace(question, machine=replace(question.machine, follower=follower))


PROGRAMS = {
    "free": (rise(71.7), dwell(23.9), fall(67.1), dwell(197.3)),
    "one law given": (rise(71.7), dwell(23.9), fall(67.1, law="cycloidal"), dwell(197.3)),
    "turning": (rise(131.7), fall(97.3), dwell(131.0)),
}
LIMITS = (angles(31.3, 43.9), jerk(55.0, 60.0))


@pytest.mark.parametrize("name", PROGRAMS)
def test_the_same_plan_and_the_same_bound(name: str) -> None:
    question = problem(scene(PROGRAMS[name], *LIMITS))
    grids = [uniform_grid(segment, 17 + 4 * k) for k, segment in enumerate(question.free)]
    plans = [formulate(one, grids) for one in (question, bent(question))]
    answers = [solve(model.program) for model in plans]
    values = [answer.x[model.epigraph] for model, answer in zip(plans, answers, strict=True)]
    # of a given law only sampled half-planes are written: less than its worst angle by a little
    near = {"abs": 0.0, "rel": 1e-3 if name == "one law given" else 1e-8}
    assert values[1] == pytest.approx(values[0], **near)
    bounds = [dual_bound(model, answer) for model, answer in zip(plans, answers, strict=True)]
    assert bounds[1].valid_for == bounds[0].valid_for
    assert bounds[1].value == pytest.approx(bounds[0].value, **near | {"rel": near["rel"] + 1e-7})


def test_half_planes_at_every_angle_come_to_the_worst_angle_of_a_row() -> None:
    given = scene(
        (rise(71.7, law="modified_sine"), dwell(23.9), fall(67.1, law="cycloidal"), dwell(197.3)),
        angles(31.3, 43.9, dwell_deg=40.0),
    )
    question = problem(given)
    assert closed_form_size(bent(question)) == pytest.approx(closed_form_size(question), rel=1e-11)


def test_a_search_ends_at_the_same_cam() -> None:
    question = problem(scene(PROGRAMS["free"], *LIMITS))
    one, other = optimise(question, 2e-3), optimise(bent(question), 2e-3)
    assert one.incumbent is not None
    assert other.incumbent is not None
    assert other.relaxation_gap <= 2e-3
    assert other.incumbent.value == pytest.approx(one.incumbent.value, rel=2e-3)
    assert max(one.lower, other.lower) <= min(one.incumbent.value, other.incumbent.value)


def test_a_tube_holds_between_its_nodes() -> None:
    """|g'''| ≤ cap: of a law with its nodes at the edge of the tube, nothing sticks out."""
    cap, nodes = 60.0, np.linspace(0.0, 1.0, 9)
    x = np.linspace(0.0, 1.0, 2001)

    def law(x: Array) -> tuple[Array, Array]:
        return 10 * x**3 - 15 * x**4 + 6 * x**5, 30 * x**2 * (1.0 - x) ** 2

    g, speed = law(nodes)
    for order, bend in ((3, cap), (2, 5.8)):
        tube = LawBounds(nodes, g, g, speed, speed, order, bend)
        low, high = tube.position_bounds(x)
        slow, fast = tube.speed_bounds(x)
        value, rate = law(x)
        assert np.all((low <= value + 1e-12) & (value <= high + 1e-12))
        assert np.all((slow <= rate + 1e-12) & (rate <= fast + 1e-12))
        assert np.max(fast - slow) < (0.3 if order == 3 else 0.8)
