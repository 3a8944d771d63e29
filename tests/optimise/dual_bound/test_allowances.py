"""What a bound pays for rounding, and bounds over splines alone, whatever the multipliers are."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest

from synthesis.optimise.conic.control import law_controls
from synthesis.optimise.dual_bound.bound import ROUNDING, bound_from_lagrangian, dual_bound
from synthesis.optimise.dual_bound.lagrangian import Lagrangian
from synthesis.optimise.problem.grid import uniform_grid
from synthesis.spec.design_spec import DesignSpec
from tests.optimise.dual_bound.test_bound import CASES, FAMILY, SYMMETRIC
from tests.optimise.scenes import angles, direct, jerk, problem, scene, velocity

SIZED = scene(
    SYMMETRIC, angles(33.0, 44.0), jerk(51.0, 71.7), objective="peak_acceleration",
    base={"min": 5.0, "max": 60.0}, offset={"min": -7.0, "max": 4.0},
)  # fmt: skip
KINDS: dict[str, tuple[DesignSpec, tuple[str, ...]]] = {
    "norm": (CASES["size, every motion limit"], ("magnitude", "size_magnitude", "psi_magnitude")),
    "level": (SIZED, ("magnitude", "size_magnitude", "psi_magnitude")),
    "mean square": (CASES["rms jerk, capped"], ("magnitude", "psi_magnitude")),
}


@pytest.mark.parametrize("kind", KINDS)
def test_rounding_of_every_sum_lowers_the_bound(kind: str) -> None:
    """Terms that cancel, of a size of 1e9 in one of the sums: they may be off by 1e-3."""
    spec, sums = KINDS[kind]
    question = problem(spec)
    answer = direct(question, [uniform_grid(segment, 8) for segment in question.free])
    controls = law_controls(answer.model)
    assert controls

    def bound(**more: float) -> float:
        lagrangian = Lagrangian(answer.model, controls[0].order)
        lagrangian.constant += 1.0
        lagrangian.level -= 1.0
        for name, amount in more.items():
            getattr(lagrangian, name)[...] += amount
        return bound_from_lagrangian(answer.solution, lagrangian, controls).value

    for name in sums:
        lost = bound() ** 2 - bound(**{name: 1e9}) ** 2
        assert lost > 1e-5 * bound() ** 2, name
        assert bound(**{name: 1e9}) < bound(**{name: 1e6}) < bound(), name
        assert bound(**{name: 1e6}) > (1.0 - 1e6 * ROUNDING * 1e4) * bound(), name


def test_over_every_size_there_is_no_bound_that_sizes_enter() -> None:
    question = problem(CASES["peak jerk"])
    assert question.for_every_size
    answer = direct(question, [uniform_grid(segment, 8) for segment in question.free])
    controls = law_controls(answer.model)
    assert controls
    for share, known in ((0.0, True), (1e-9, False)):
        lagrangian = Lagrangian(answer.model, controls[0].order)
        lagrangian.level -= 1.0
        lagrangian.size[...] += share
        value = bound_from_lagrangian(answer.solution, lagrangian, controls).value
        assert np.isfinite(value) == known
        assert known or value < 0.0


# two cones: the least size under a largest one, and its square on the way
CONES: dict[str, Any] = {
    "two cones": scene(
        SYMMETRIC, angles(33.0, 44.0), velocity(2.1, 71.7),
        {"kind": "outer_radius", "max_mm": 90.0}, base={"min": 5.0, "max": 60.0},
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", [*sorted(FAMILY), *CONES])
@pytest.mark.parametrize("seed", range(3))
def test_any_multipliers_bound_the_splines_of_their_mesh(name: str, seed: int) -> None:
    question = problem({**CASES, **CONES}[name])
    answer = direct(question, [uniform_grid(segment, 8) for segment in question.free])
    good = dual_bound(answer.model, answer.solution)
    assert not good.switching
    assert answer.value * (1.0 - 1e-4) <= good.value <= answer.value * (1.0 + 1e-9)
    rng, z = np.random.default_rng(seed), answer.solution.multipliers
    for size in (1e-6, 1e-3, 0.1):
        noise = rng.standard_normal(len(z)) * size
        for wrong in (z * np.exp(noise), z + noise, z * rng.uniform(0.0, 2.0, len(z))):
            lower = dual_bound(answer.model, replace(answer.solution, multipliers=wrong))
            assert lower.value <= answer.value * (1.0 + 1e-9)


def test_multipliers_outside_of_their_cones_bound_nothing_falsely() -> None:
    """Of each cone alone, with its head left out: its rows by themselves may be exceeded."""
    question = problem(scene(
        SYMMETRIC, angles(45.0, 55.0), velocity(2.1, 71.7),
        {"kind": "outer_radius", "max_mm": 90.0}, base={"min": 5.0, "max": 16.0},
    ))  # fmt: skip
    answer = direct(question, [uniform_grid(segment, 8) for segment in question.free])
    model, z = answer.model, np.zeros(len(answer.solution.multipliers))
    at = model.program.equalities + model.program.inequalities
    assert len(model.cone_blocks) == 3
    for cone in model.cone_blocks:
        for axis, size in product(range(len(cone.shift)), (1.0, -1.0, 100.0, -100.0)):
            wrong = z.copy()
            wrong[at + 1 + axis] = size
            lower = dual_bound(model, replace(answer.solution, multipliers=wrong))
            assert lower.value <= answer.value
        at += 1 + len(cone.shift)
