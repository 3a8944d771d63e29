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

from synthesis import clock
from synthesis.formulations.cone.convex import Plan, formulate
from synthesis.formulations.cone.rows import Drawn
from synthesis.formulations.conflict.parts import Part, RangePart, limit_parts
from synthesis.formulations.conflict.size_parts import open_size, range_parts
from synthesis.formulations.conflict.yielding import Yielded, least_yield, state
from synthesis.formulations.question.grid import Grid
from synthesis.formulations.question.problem import Nothing, Problem
from synthesis.numerics.piecewise import Array
from synthesis.spec import DesignSpec

DRAWN = 1e-7  # limits are drawn in by as much as where cams are sought
NOTHING = 1e-8  # a relative violation that is solver noise
FAN = np.radians([0.0, 25.0, -25.0, 50.0, -50.0, 70.0, -70.0, 85.0, -85.0])
TURNS = 30
Towards = Callable[[Array | None], Yielded | None]


class OutOfTime(Exception):
    """The deadline of a scene has passed."""


@dataclass(frozen=True, eq=False)
class Scene:
    """The problem with its size open, and everything that may give way.

    ``drawn``: relative amount by which all limits are drawn in. ``deadline``: ``time.monotonic()``
    after which no second cone program is begun; ``OutOfTime`` then.
    """

    problem: Problem
    grids: tuple[Grid, ...]
    parts: tuple[Part, ...]
    drawn: float = DRAWN
    deadline: float = inf

    @classmethod
    def of(cls, spec: DesignSpec, problem: Problem, grids: Sequence[Grid]) -> Scene:
        """The scene of a spec."""
        idle = replace(open_size(spec, problem), objective=Nothing(), held=())
        parts = (*limit_parts(problem, len(spec.limits)), *range_parts(spec, problem))
        return cls(idle, tuple(grids), parts)

    def plan(self, part: int | None = None, value: float = 0.0) -> Plan:
        """The matrices, one part at another value than asked."""
        problem = self.problem
        if part is not None:
            problem = self.parts[part].loosened(problem, value)
        return formulate(problem, self.grids, 0.0, Drawn(self.drawn), paired=True)

    def ranges(self, dropped: Collection[int] = ()) -> list[RangePart]:
        """The ranges of its size."""
        parts = [part for k, part in enumerate(self.parts) if k not in dropped]
        return [part for part in parts if isinstance(part, RangePart)]


@dataclass(frozen=True, eq=False)
class Rate:
    """Exchange rate: what rows gain at a point where the part is looser by ``step``, relative."""

    at: Yielded
    looser: Plan
    step: float


def yielded(
    scene: Scene,
    plan: Plan,
    loose: Sequence[int],
    dropped: Collection[int] = (),
    rate: Rate | None = None,
    *,
    exact: bool = True,
) -> Yielded | None:
    """Least that the loose parts have to give way in all; None where that does not help.

    Args:
        scene: the scene. plan: its matrices. loose, dropped: parts that may give way, or are not
        there.
        rate: the exchange rate of the one loose part.
        exact: False where it is enough to know whether the least is nothing.

    Raises:
        OutOfTime: the scene's deadline has passed, and one cone program is not enough.
    """

    def towards(direction: Array | None) -> Yielded | None:
        if direction is not None and clock.now() >= scene.deadline:
            raise OutOfTime
        stated, floor = state(plan, scene.parts, direction, scene.drawn), 0.0
        if rate is not None:
            looser = state(rate.looser, scene.parts, direction, scene.drawn)
            stated = stated.giving(loose[0], looser, rate.step, rate.at.x)
            floor = -1.0  # relative: it may have been too loose before
        return least_yield(stated, loose, dropped, floor, direction)

    eased = towards(None)  # a large radius not asked for: never more
    large = [part for part in scene.ranges(dropped) if part.axis is None and part.low > -inf]
    if not large or eased is None or (eased.total > NOTHING and not exact):
        return eased
    starts = list(_starts(scene, plan, eased))
    if rate is not None and rate.at.direction is not None:
        starts = [rate.at.direction]
    return _best(towards, starts, plan, ring=large[0].high < inf)


def _starts(scene: Scene, plan: Plan, eased: Yielded) -> Iterator[Array]:
    """Unit vectors: towards the point found, towards the ends of the offset's range, all round."""
    size = eased.x[plan.size]
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


def _best(towards: Towards, starts: list[Array], plan: Plan, *, ring: bool) -> Yielded | None:
    """The best of the starts, turned until that changes nothing."""
    best: Yielded | None = None
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
    turned = _on_ring(towards, best.direction) if ring else _turned(towards, best, plan)
    return turned if turned is not None and turned.total < best.total else best


def _turned(towards: Towards, best: Yielded, plan: Plan) -> Yielded:
    """Again and again towards the point found."""
    for _ in range(TURNS):
        size = best.x[plan.size]
        found = towards(size / np.linalg.norm(size))
        if found is None or found.total > best.total - 1e-11:
            break
        best = found
    return best


def _on_ring(towards: Towards, direction: Array) -> Yielded | None:
    """Where the radius is fixed the point is bound to the direction: that is varied instead."""

    def total(angle: float) -> float:
        found = towards(np.array([np.sin(angle), np.cos(angle)]))
        return 1e3 if found is None else found.total

    middle, reach = float(np.arctan2(*direction)), 0.3
    bounds = (middle - reach, middle + reach)
    found = minimize_scalar(total, bounds=bounds, method="bounded", options={"xatol": 1e-9})
    return towards(np.array([np.sin(found.x), np.cos(found.x)]))
