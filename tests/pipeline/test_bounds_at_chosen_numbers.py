"""Bounds at numbers that were chosen are none over all, those of other objectives none at all."""

from __future__ import annotations

from math import inf
from types import SimpleNamespace
from typing import Any, cast

import pytest

from synthesis import DesignSpec, synthesise
from synthesis.catalogue.objectives import BaseRadius, Objective, PeakAcceleration
from synthesis.pipeline import conflict, largest_radius
from synthesis.pipeline.assembly import Bounded
from synthesis.pipeline.attempt import Attempt, with_bound_of
from synthesis.pipeline.boundary import Boundary
from synthesis.pipeline.goal import Goal
from synthesis.pipeline.largest_radius import Smallest
from synthesis.pipeline.oracle import Oracle, Trial
from synthesis.pipeline.relaxable import Relaxable
from tests.optimise.arms import angles, body
from tests.pipeline.test_largest_radius import CONVEX


def with_free_arm(base: dict[str, float]) -> DesignSpec:
    """Given laws, and a length of the arm that is chosen: no bound covers all lengths."""
    spec = body(angles(), law="cycloidal", distance=101.9)
    spec["follower"]["arm_mm"] = {"min": 40.7, "max": 161.3}
    more = {"objective": {"kind": "base_radius"}, "base_radius_mm": base, "proof": "quick"}
    return DesignSpec.model_validate(spec | more)


@pytest.mark.usefixtures("unexplained")
def test_a_least_radius_makes_no_bound_one_over_all_numbers() -> None:
    smallest = float(synthesise(with_free_arm({"max": 200.0})).certificate.value)
    for least in ({}, {"min": 1.0}):
        found = synthesise(with_free_arm({**least, "max": 0.97 * smallest}))
        assert found.status == "unsolved"
    assert synthesise(with_free_arm({"min": 1.0, "max": 1.001 * smallest})).motion


def attempt(objective: Objective, lower: float, *, chosen: bool, over_all: float = -inf) -> Attempt:
    nothing = cast(Any, None)
    bounds = [Bounded(objective, lower, "these numbers")]
    covered = Bounded(objective, over_all, "all numbers") if over_all > -inf else None
    search = SimpleNamespace(
        covers_all_laws=True, problem=SimpleNamespace(objective=objective), lower=lower,
        valid_for="these laws", infeasible=False,
    )  # fmt: skip
    return Attempt(
        nothing, [1.0] if chosen else [], nothing, nothing, nothing, bounds=bounds,
        number_bound=covered, searches=cast(Any, [search]),
    )  # fmt: skip


def smallest(radius: float, lower: float, **known: Any) -> Smallest:
    return Smallest(attempt(BaseRadius(), lower, **known), radius, 9.0, lower, "")


def test_a_bound_of_another_cam_is_taken_only_where_it_covers_both() -> None:
    known = smallest(9.5, 8.0, chosen=True, over_all=8.0)
    assert largest_radius._smaller(known, None) is known
    larger = smallest(9.6, 9.4, chosen=True)  # at its own numbers alone
    assert largest_radius._smaller(known, larger) is known
    both = largest_radius._smaller(known, smallest(9.6, 9.2, chosen=True, over_all=9.2))
    assert (both.radius, both.lower, both.is_bounded) == (9.5, 9.2, True)
    assert both.attempt.number_bound is not None
    assert both.attempt.number_bound.lower == 9.2
    smaller = smallest(9.3, 7.0, chosen=True, over_all=7.0)
    assert largest_radius._smaller(known, smaller).lower == 8.0
    assert largest_radius._smaller(known, smaller).radius == 9.3


def test_a_bound_of_given_numbers_is_that_of_the_better_cam_too() -> None:
    known, finer = smallest(9.5, 9.1, chosen=False), smallest(9.4, 8.9, chosen=False)
    both = largest_radius._smaller(known, finer)
    assert (both.radius, both.lower, both.attempt.bounds[0].lower) == (9.4, 9.1, 9.1)


def test_a_bound_of_the_size_is_none_of_the_acceleration() -> None:
    of_size = attempt(BaseRadius(), 3.0, chosen=False)
    other = attempt(PeakAcceleration(), 1.0, chosen=False)
    assert with_bound_of(of_size, other) is other
    higher = attempt(BaseRadius(), 4.0, chosen=False)
    assert with_bound_of(higher, of_size).bounds[0].lower == 4.0


def test_a_number_that_is_relaxed_downwards_stays_so_with_numbers_free() -> None:
    number = Relaxable("offset", ("follower/offset_mm",), (0.0,), "mm", "=")
    excess = SimpleNamespace(
        excess=0.1, bound_excess=None, proof="proven", attempt=None, smallest=None
    )
    oracle = cast(Oracle, SimpleNamespace(open_gap=0.0, spec=SimpleNamespace(tolerance=5e-3)))
    known = Boundary(oracle, number, cast(Trial, excess))
    known.direction = -1.0
    known.nearest = -0.8, cast(Trial, excess)
    free = conflict._with_numbers_free_again(known, oracle)
    assert free.direction == -1.0
    assert free.nearest == known.nearest
    assert free.excluded == 0.0
    assert free.way_to(-0.8) == pytest.approx(0.8)


def test_the_first_of_the_wider_questions_that_excludes_the_maximum_ends_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The next one, with the least radius, would put another cam in its place, or none."""
    asked, solve = list[Any](), largest_radius.solve_spec

    def noted(spec: DesignSpec, goal: Goal, stages: list[Any]) -> Attempt:
        asked.append(spec.base_radius_mm)
        return solve(spec, goal, stages)

    monkeypatch.setattr(largest_radius, "solve_spec", noted)
    monkeypatch.setattr(largest_radius, "infeasibility_proof", lambda _: "")  # which comes before
    ranges = {"base_radius_mm": {"min": 5.0, "max": 9.0}}
    more = {"proof": "quick", "objective": {"kind": "peak_acceleration"}}
    spec = DesignSpec.model_validate({**CONVEX, **ranges, **more})
    _, found = largest_radius.solve_with_maximum(spec, Goal(inf), [])
    assert found is not None
    assert found.excludes
    assert asked == [None]
