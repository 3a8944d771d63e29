"""The place of a counter roller that is left free: the nearest at which its cam keeps every limit.

The counter cam follows from the laws, the size and the place: the distance between two rollers on
a slide, the angle between two arms. It does not weigh on the main cam: the cam sought without the
counter cam stays the best one as long as some place in the range will do, and its lower bound
holds for every place.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import inf, isnan

import numpy as np
from scipy.optimize import brentq

from synthesis import clock
from synthesis.formulations.cams.candidate import Candidate
from synthesis.formulations.cams.smooth import Samples, peaks, sample, violation
from synthesis.formulations.cone.rows import exceeded
from synthesis.formulations.question.problem import Problem
from synthesis.ranges import ends
from synthesis.spec import DesignSpec
from synthesis.terms import Cone

CLEARANCE = 1e-8  # relative: how far the distance stays off what binds it
DENSE, EVEN = 24, 36  # places tried, towards the nearest one and all over the range
ROUNDS = 4


@dataclass(frozen=True)
class Settled:
    """The spec with the counter roller's place.

    Attributes:
        spec: what was asked, the place being a number.
        holds: whether the counter cam keeps its limits beside this main cam.
        farthest: where it does not, whether no other place would leave the main cam more room.
    """

    spec: DesignSpec
    holds: bool
    farthest: bool = False


def settled(spec: DesignSpec, found: Candidate, deadline: float = inf) -> Settled:
    """Settle what the size leaves open, for a finished main cam.

    Args:
        spec: what was asked.
        found: the main cam: laws settled, size known.
        deadline: ``clock.now()`` after which the nearest place is not sought any closer.

    Returns:
        the nearest place that works; where none does, the one at which least is exceeded, but not
        farther than an outer radius allows; the spec itself where nothing is open.
    """
    free = [
        (name, ends(value))
        for name, value in spec.follower.companion_ranges().values()
        if ends(value)[0] != ends(value)[1]
    ]
    if not free:
        return Settled(spec, True)
    ((name, (low, high)),) = free
    scene = _Scene(spec, found, name, deadline)
    stretches = found.problem.stretches
    highest = max(max(s.s_start, s.s_end) for s in stretches)
    places = spec.follower.places(found.size, highest)
    nearest, most = max(low, places.nearest), min(high, places.farthest)
    if most <= nearest:
        return Settled(spec.built({name: most}), False, farthest=places.easier_farther)
    least = scene.least(nearest, most)
    value = scene.mildest(nearest, most) if least is None else least
    if scene.outgrown(value) > 0.0 >= scene.outgrown(nearest):
        value = float(brentq(scene.outgrown, nearest, value, xtol=1e-300, rtol=1e-13))
        return Settled(spec.built({name: value}), False)  # too small or too large, with these laws
    alone = not any(True for _ in scene.cones(value))
    farthest = places.easier_farther and alone
    return Settled(spec.built({name: value}), least is not None, farthest)


@dataclass(frozen=True, eq=False)
class _Scene:
    """The counter cam beside a finished main cam.

    Attributes:
        spec: what was asked. found: the main cam. name: of the distance among the dimensions.
        deadline: after which places are no longer closed in on.
    """

    spec: DesignSpec
    found: Candidate
    name: str
    deadline: float

    def at(self, distance: float) -> Problem:
        """The question put to the counter cam alone."""
        machine = self.found.problem.machine
        follower = self.spec.follower.companion({self.name: distance})
        return replace(
            self.found.problem,
            machine=replace(machine, follower=follower),
            limits=self.spec.all_limits(),
        )

    def least(self, low: float, high: float) -> float | None:
        """The least distance between two ends that keeps every limit, None where none does."""
        samples = sample(self.found.problem)
        for _ in range(ROUNDS):
            found = self._least(samples, low, high)
            if found is None:
                return None
            missed = peaks(self.at(found), samples, self.found.size)
            if violation(self.at(found), missed, self.found.size) <= 0.0:
                return found
            samples = [*samples, *missed]
        return found

    def _least(self, samples: list[Samples], low: float, high: float) -> float | None:
        before = low
        for place in _spread(low, high):
            if self.excess(place, samples) > 0.0:
                before = place
            elif place == low or clock.now() >= self.deadline:
                return place
            else:
                root = brentq(self.excess, before, place, args=(samples,), xtol=1e-300, rtol=1e-13)
                return min(float(root) * (1.0 + CLEARANCE), high)
        return None

    def mildest(self, low: float, high: float) -> float:
        """The place at which the worst limit is exceeded least; the nearest of several."""
        samples = sample(self.found.problem)
        return min(_spread(low, high), key=lambda place: self.excess(place, samples))

    def excess(self, distance: float, samples: list[Samples]) -> float:
        """By how much the worst limit is exceeded, relative."""
        problem = self.at(distance)
        worst = max(self._rows(problem), default=-1.0)
        with np.errstate(divide="ignore", invalid="ignore"):  # with the roller on the axis
            shape = violation(problem, samples, self.found.size)
        value = max(worst, shape + CLEARANCE)
        return 1.0 if isnan(value) or value == inf else value

    def outgrown(self, distance: float) -> float:
        """By how much the counter cam is too large, relative; rises with the distance."""
        return max(
            (cone.norm.value(self.found.size) / cone.radius - 1.0 for cone in self.cones(distance)),
            default=-1.0,
        )

    def cones(self, distance: float) -> Iterator[Cone]:
        """What an outer radius says of the size, the counter roller being there."""
        problem = self.at(distance)
        for limit in problem.limits:
            yield from limit.cones(problem.stretches, problem.machine)

    def _rows(self, problem: Problem) -> Iterator[float]:
        """Excess of every row that speaks of the size, over the stroke."""
        for stretch in problem.stretches:
            for row in problem.rows_on(stretch, self.found.value):
                if row.size:
                    scale = max(map(abs, row.size)) * problem.length
                    yield exceeded(row, stretch, self.found.size) / scale


def _spread(low: float, high: float) -> list[float]:
    """Places to try: dense beside the nearest, and all over the range."""
    span = high - low
    dense, even = low + span * np.geomspace(1e-5, 1.0, DENSE), np.linspace(low, high, EVEN)
    found = np.unique(np.clip(np.concatenate([dense, even]), low, high))
    return [float(place) for place in found]
