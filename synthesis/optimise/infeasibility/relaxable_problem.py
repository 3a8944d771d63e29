"""A scene some of whose parts may give way: what they have to, in all.

All is one cone program, but for one thing: a prime radius that must be large is not convex. Each
direction y of y · z ≥ radius is, though, and together they say the same; so the best direction is
searched for.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf, sqrt

import numpy as np
from scipy.optimize import minimize_scalar

from synthesis.numerics import clock
from synthesis.numerics.piecewise import Array
from synthesis.optimise.conic.linear_rows import Tightening
from synthesis.optimise.conic.program import ConicModel, formulate
from synthesis.optimise.infeasibility.elastic_program import (
    ElasticSolution,
    solve_elastic_program,
    state,
)
from synthesis.optimise.infeasibility.relaxable import Relaxable, RelaxableRange, relaxable_limits
from synthesis.optimise.infeasibility.relaxable_sizes import open_size, relaxable_ranges
from synthesis.optimise.problem.grid import Grid
from synthesis.optimise.problem.problem import NoObjective, Problem
from synthesis.spec.design_spec import DesignSpec

DRAWN = 1e-7  # limits are drawn in by as much as where cams are sought
NOTHING = 1e-8  # a relative violation that is solver noise
FAN = np.radians([0.0, 25.0, -25.0, 50.0, -50.0, 70.0, -70.0, 85.0, -85.0])
TURNS = 30
Towards = Callable[[Array | None], ElasticSolution | None]


class OutOfTime(Exception):
    """The deadline of a scene has passed."""


@dataclass(frozen=True, eq=False)
class RelaxableProblem:
    """The problem with its size open, and everything that may give way.

    ``drawn``: relative amount by which all limits are drawn in. ``deadline``: ``time.monotonic()``
    after which no second cone program is begun; ``OutOfTime`` then.
    """

    problem: Problem
    grids: tuple[Grid, ...]
    parts: tuple[Relaxable, ...]
    drawn: float = DRAWN
    deadline: float = inf

    @classmethod
    def of(cls, spec: DesignSpec, problem: Problem, grids: Sequence[Grid]) -> RelaxableProblem:
        """The scene of a spec."""
        idle = replace(open_size(spec, problem), objective=NoObjective(), objective_caps=())
        parts = (*relaxable_limits(problem, len(spec.limits)), *relaxable_ranges(spec, problem))
        return cls(idle, tuple(grids), parts)

    def model(self, part: int | None = None, value: float = 0.0) -> ConicModel:
        """The matrices, one part at another value than asked."""
        problem = self.problem
        if part is not None:
            problem = self.parts[part].loosened(problem, value)
        return formulate(problem, self.grids, 0.0, Tightening(self.drawn), paired=True)

    def ranges(self, dropped: Collection[int] = ()) -> list[RelaxableRange]:
        """The ranges of its size."""
        parts = [part for k, part in enumerate(self.parts) if k not in dropped]
        return [part for part in parts if isinstance(part, RelaxableRange)]


@dataclass(frozen=True, eq=False)
class ExchangeRate:
    """Exchange rate: what rows gain at a point where the part is looser by ``step``, relative."""

    at: ElasticSolution
    looser: ConicModel
    step: float


def solve_elastic(
    scene: RelaxableProblem,
    model: ConicModel,
    loose: Sequence[int],
    dropped: Collection[int] = (),
    rate: ExchangeRate | None = None,
    *,
    exact: bool = True,
) -> ElasticSolution | None:
    """Least that the loose parts have to give way in all; None where that does not help.

    Args:
        scene: the scene. model: its matrices. loose, dropped: parts that may give way, or are not
        there.
        rate: the exchange rate of the one loose part.
        exact: False where it is enough to know whether the least is nothing.

    Raises:
        OutOfTime: the scene's deadline has passed, and one cone program is not enough.
    """

    def towards(direction: Array | None) -> ElasticSolution | None:
        if direction is not None and clock.now() >= scene.deadline:
            raise OutOfTime
        stated, floor = state(model, scene.parts, direction, scene.drawn), 0.0
        if rate is not None:
            looser = state(rate.looser, scene.parts, direction, scene.drawn)
            stated = stated.giving(loose[0], looser, rate.step, rate.at.x)
            floor = -1.0  # relative: it may have been too loose before
        return solve_elastic_program(stated, loose, dropped, floor, direction)

    eased = towards(None)  # a large radius not asked for: never more
    large = [part for part in scene.ranges(dropped) if part.axis is None and part.low > -inf]
    if not large or eased is None or (eased.total > NOTHING and not exact):
        return eased
    starts = list(_starts(scene, model, eased))
    if rate is not None and rate.at.direction is not None:
        starts = [rate.at.direction]
    return _best(towards, starts, model, ring=large[0].high < inf)


def _starts(scene: RelaxableProblem, model: ConicModel, eased: ElasticSolution) -> Iterator[Array]:
    """Unit vectors: towards the point found, towards the ends of the offset's range, all round."""
    size = eased.x[model.size]
    if len(size) == 1:
        yield np.ones(1)
        return
    yield size / max(float(np.linalg.norm(size)), 1e-300)
    radius = max(part.low for part in scene.ranges() if part.axis is None)
    for part in scene.ranges():
        for end in {part.low, part.high} if part.axis is not None else ():
            if abs(end) < radius:
                other = sqrt(1.0 - (end / radius) ** 2)
                yield np.array([end / radius, other])
    for angle in FAN:
        yield np.array([np.sin(angle), np.cos(angle)])


def _best(
    towards: Towards, starts: list[Array], model: ConicModel, *, ring: bool
) -> ElasticSolution | None:
    """The best of the starts, turned until that changes nothing."""
    best: ElasticSolution | None = None
    for direction in starts:
        found = towards(direction)
        if found is not None and (best is None or found.total < best.total):
            best = found
        if best is not None and abs(best.total) <= NOTHING:
            return best
    if best is None or best.direction is None:
        return None
    if len(best.direction) == 1:
        return best
    turned = _on_ring(towards, best.direction) if ring else _turned(towards, best, model)
    return turned if turned is not None and turned.total < best.total else best


def _turned(towards: Towards, best: ElasticSolution, model: ConicModel) -> ElasticSolution:
    """Again and again towards the point found."""
    for _ in range(TURNS):
        size = best.x[model.size]
        found = towards(size / np.linalg.norm(size))
        if found is None or found.total > best.total - 1e-11:
            break
        best = found
    return best


def _on_ring(towards: Towards, direction: Array) -> ElasticSolution | None:
    """Where the radius is fixed the point is bound to the direction: that is varied instead."""

    def total(angle: float) -> float:
        found = towards(np.array([np.sin(angle), np.cos(angle)]))
        return 1e3 if found is None else found.total

    middle, reach = float(np.arctan2(*direction)), 0.3
    bounds = (middle - reach, middle + reach)
    found = minimize_scalar(total, bounds=bounds, method="bounded", options={"xatol": 1e-9})
    return towards(np.array([np.sin(found.x), np.cos(found.x)]))
