"""Rows that differ from point to point: a translating roller's own, written as a curved limit."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import pytest

from synthesis.followers.translating_roller import TranslatingRoller
from synthesis.formulations.bounds.bound import bound
from synthesis.formulations.cams.closed_form import nearest
from synthesis.formulations.cone.convex import formulate
from synthesis.formulations.cone.tubing import Tube
from synthesis.formulations.ladder.refine import search
from synthesis.formulations.question.grid import uniform
from synthesis.formulations.question.problem import Problem
from synthesis.numerics.piecewise import Array
from synthesis.solvers.clarabel import solve
from synthesis.terms import Curved, Cuts, Row, Vector, Within
from tests.formulations.scenes import angles, dwell, fall, jerk, problem, rise, scene


@dataclass(frozen=True)
class Bent(Curved):
    """A fixed row in the words of a curved limit."""

    order: ClassVar[int] = 1
    row: Row

    def excess(self, s: Any, z: Any) -> tuple[Any, ...]:
        value = sum(a * v for a, v in zip(self.row.coefficients, s, strict=True))
        value += sum(a * v for a, v in zip(self.row.size, z, strict=True)) - self.row.upper
        return (value / 30.0,)

    def half_planes(self, s: Array) -> tuple[Cuts, ...]:
        size = np.tile(np.array(self.row.size)[:, None], s.shape[1])
        return (Cuts(np.zeros_like(s), size, self.row.upper - np.array(self.row.coefficients) @ s),)

    def cuts(self, within: Within, about: tuple[Array, Vector] | None) -> tuple[Cuts, ...]:
        one = np.ones((1, len(within.low)))
        size = np.array(self.row.size)[:, None] * one
        rows = np.array(self.row.coefficients)[:, None] * one
        return (Cuts(rows, size, self.row.upper * one[0]),)


class BentRoller(TranslatingRoller):
    """A translating roller that says its pressure angle as curved limits."""

    def pressure_angle_rows(self, slope: float) -> tuple[Row, ...]:
        return ()

    def pressure_angle_curves(self, slope: float) -> tuple[Curved, ...]:
        return tuple(Bent("", row) for row in super().pressure_angle_rows(slope))


def bent(asked: Problem) -> Problem:
    follower = BentRoller.model_validate(asked.machine.follower.model_dump())
    return replace(asked, machine=replace(asked.machine, follower=follower))


PROGRAMS = {
    "free": (rise(71.7), dwell(23.9), fall(67.1), dwell(197.3)),
    "one law given": (rise(71.7), dwell(23.9), fall(67.1, law="cycloidal"), dwell(197.3)),
    "turning": (rise(131.7), fall(97.3), dwell(131.0)),
}
LIMITS = (angles(31.3, 43.9), jerk(55.0, 60.0))


@pytest.mark.parametrize("name", PROGRAMS)
def test_the_same_plan_and_the_same_bound(name: str) -> None:
    asked = problem(scene(PROGRAMS[name], *LIMITS))
    grids = [uniform(stretch, 17 + 4 * k) for k, stretch in enumerate(asked.free)]
    plans = [formulate(one, grids) for one in (asked, bent(asked))]
    answers = [solve(plan.program) for plan in plans]
    values = [answer.x[plan.extra] for plan, answer in zip(plans, answers, strict=True)]
    # of a given law only sampled half-planes are written: less than its worst angle by a little
    near = {"abs": 0.0, "rel": 1e-3 if name == "one law given" else 1e-8}
    assert values[1] == pytest.approx(values[0], **near)
    bounds = [bound(plan, answer) for plan, answer in zip(plans, answers, strict=True)]
    assert bounds[1].over == bounds[0].over
    assert bounds[1].value == pytest.approx(bounds[0].value, **near | {"rel": near["rel"] + 1e-7})


def test_half_planes_at_every_angle_come_to_the_worst_angle_of_a_row() -> None:
    given = scene(
        (rise(71.7, law="modified_sine"), dwell(23.9), fall(67.1, law="cycloidal"), dwell(197.3)),
        angles(31.3, 43.9, dwell_deg=40.0),
    )
    asked = problem(given)
    assert nearest(bent(asked)) == pytest.approx(nearest(asked), rel=1e-11)


def test_a_search_ends_at_the_same_cam() -> None:
    asked = problem(scene(PROGRAMS["free"], *LIMITS))
    one, other = search(asked, 2e-3), search(bent(asked), 2e-3)
    assert one.best is not None
    assert other.best is not None
    assert other.gap <= 2e-3
    assert other.best.value == pytest.approx(one.best.value, rel=2e-3)
    assert max(one.lower, other.lower) <= min(one.best.value, other.best.value)


def test_a_tube_holds_between_its_nodes() -> None:
    """|g'''| ≤ cap: of a law with its nodes at the edge of the tube, nothing sticks out."""
    cap, nodes = 60.0, np.linspace(0.0, 1.0, 9)
    x = np.linspace(0.0, 1.0, 2001)

    def law(x: Array) -> tuple[Array, Array]:
        return 10 * x**3 - 15 * x**4 + 6 * x**5, 30 * x**2 * (1.0 - x) ** 2

    g, speed = law(nodes)
    for order, bend in ((3, cap), (2, 5.8)):
        tube = Tube(nodes, g, g, speed, speed, order, bend)
        low, high = tube.positions(x)
        slow, fast = tube.speeds(x)
        value, rate = law(x)
        assert np.all((low <= value + 1e-12) & (value <= high + 1e-12))
        assert np.all((slow <= rate + 1e-12) & (rate <= fast + 1e-12))
        assert np.max(fast - slow) < (0.3 if order == 3 else 0.8)
