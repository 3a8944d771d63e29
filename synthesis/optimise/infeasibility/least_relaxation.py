"""The least value of one part, all others kept, that makes a scene possible.

It is the optimum of a program whose objective that part is. For a limit that is a ratio, the
pressure angle, it takes a sequence of programs, each with the exchange rate of the point before
(Dinkelbach); between the programs, points are added where rows were worst.
"""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np

from synthesis.numerics import clock
from synthesis.numerics.piecewise import Array
from synthesis.optimise.conic.linear_rows import applies_at, is_sampled, row_scale
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.infeasibility.relaxable import CEILING, RelaxableLimit
from synthesis.optimise.infeasibility.relaxable_problem import (
    NOTHING,
    ExchangeRate,
    OutOfTime,
    RelaxableProblem,
    solve_elastic,
)
from synthesis.optimise.problem.problem import Problem

ALLOWED, SETTLED, NEAR = 1e-9, 1e-7, 1e-2
ROUNDS = 16
STEP = 1e-4


def least_value(scene: RelaxableProblem, part: int) -> float | None:
    """The least relaxation of one part [wire]; None where it alone cannot help.

    Raises:
        OutOfTime: the scene's deadline has passed.
    """
    asked = scene.parts[part]
    value, rate = asked.requested, None
    for _ in range(ROUNDS):
        if clock.now() >= scene.deadline:
            raise OutOfTime
        model = scene.model(part, value)
        found = solve_elastic(scene, model, (part,), (), rate)
        ceiling = CEILING.get(asked.unit, inf)
        if found is None or (value >= ceiling and found.total > NOTHING):
            return None
        settled, size = _settled(model, found.x)
        reached = asked.least(settled, size)
        if reached is None and (value >= ceiling or ceiling == inf):
            return None
        new = ceiling if reached is None else reached
        scene, worst = _watched(scene, model, asked.loosened(settled, new), size)
        if worst <= ALLOWED and abs(new - value) <= SETTLED * abs(new):
            return new
        value = new
        if isinstance(asked, RelaxableLimit) and reached is not None:
            rate = ExchangeRate(found, scene.model(part, asked.eased(value, STEP)), STEP)
    return value


def _settled(model: ConicModel, x: Array) -> tuple[Problem, tuple[float, ...]]:
    laws, size = model.recover(x)
    problem = model.problem
    placed = [s.with_law(law.curve()) for s, law in zip(problem.free, laws, strict=True)]
    return problem.with_laws(placed), size


def _watched(
    scene: RelaxableProblem, model: ConicModel, settled: Problem, size: tuple[float, ...]
) -> tuple[RelaxableProblem, float]:
    """The scene with points wherever rows on free laws are worse between theirs than at them.

    Returns:
        the scene, and the largest excess of any row relative to its natural size.
    """
    worst, grids = 0.0, list(scene.grids)
    by_index = {segment.index: segment for segment in settled.segments}
    for k, (free, grid) in enumerate(zip(scene.problem.free, scene.grids, strict=True)):
        gaps = np.diff(grid.points)[:, None] * np.array([0.25, 0.5, 0.75])
        x = np.concatenate([grid.points, (grid.points[:-1, None] + gaps).ravel()])
        s = by_index[free.index].placed().derivatives(free.start + free.angle * x)
        more = [np.zeros(0)]
        for row in settled.limit_rows(free):
            if is_sampled(row, grid.space):
                value = np.array(row.coefficients) @ s - row.upper
                value += sum(a * v for a, v in zip(row.size, size, strict=False))
                excess = value / row_scale(row, free, model.scales)
                excess = np.where(applies_at(row, x), excess, -inf)
                at_points = float(np.max(excess[: len(grid.points)]))
                worst = max(worst, float(np.max(excess)))
                more.append(x[excess > max(at_points, -NEAR) + ALLOWED])
        grids[k] = grid.with_points(np.concatenate(more))
    return replace(scene, grids=tuple(grids)), worst
