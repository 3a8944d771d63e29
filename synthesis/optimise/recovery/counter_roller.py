"""The place of a counter roller that is left free: the nearest at which its cam keeps every limit.

The counter cam follows from the laws, the size and the place: the distance between two rollers on
a slide, the angle between two arms. It does not weigh on the main cam: the cam sought without the
counter cam stays the best one as long as some place in the range will do, and its lower bound
holds for every place.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from math import inf, isnan

import numpy as np
from scipy.optimize import brentq

from synthesis.catalogue.constraints import NormBounds
from synthesis.catalogue.fields import ends
from synthesis.numerics import clock
from synthesis.optimise.conic.linear_rows import row_excess
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.candidate import CLEARANCE, Candidate
from synthesis.optimise.recovery.smooth_limits import Samples, peaks, sample, violation
from synthesis.spec.design_spec import DesignSpec

DENSE, EVEN = 24, 36  # places tried, towards the nearest one and all over the range
MAX_ITERATIONS = 4  # of adding peaks to the samples


@dataclass(frozen=True)
class CounterRollerPlacement:
    """The spec with the counter roller's place.

    Attributes:
        spec: the specification, the place being a number.
        holds: whether the counter cam keeps its limits beside this main cam.
        farthest: where it does not, whether no other place would leave the main cam more slack.
    """

    spec: DesignSpec
    holds: bool
    farthest: bool = False


def place_counter_roller(
    spec: DesignSpec, cam: Candidate, deadline: float = inf
) -> CounterRollerPlacement:
    """Choose what the size leaves open, for a finished main cam.

    The nearest place that works; where none does, the one at which least is exceeded, but not
    farther than an outer radius allows; the spec itself where nothing is open. After ``deadline``
    (``clock.now()``) the nearest place is not sought any closer.
    """
    free = [
        (name, ends(value))
        for name, value in spec.follower.closure.counter_dimensions().values()
        if ends(value)[0] != ends(value)[1]
    ]
    if not free:
        return CounterRollerPlacement(spec, True)
    ((name, (low, high)),) = free
    counter_cam = _CounterCam(spec, cam, name, deadline)
    segments = cam.problem.segments
    highest = max(max(s.s_start, s.s_end) for s in segments)
    closure = spec.follower.closure
    helps = closure.eased_by_distance
    first, last = closure.counter_range(spec.follower, cam.size, highest)
    nearest, most = max(low, first), min(high, last)
    if most <= nearest:
        return CounterRollerPlacement(spec.with_deferred({name: most}), False, farthest=helps)
    least = counter_cam.nearest_feasible(nearest, most)
    value = least
    if (
        value is None
    ):  # the place at which the worst limit is exceeded least; the nearest of several
        samples = sample(cam.problem)
        places = _trial_places(nearest, most)
        value = min(places, key=lambda place: counter_cam.excess(place, samples))
    if counter_cam.size_excess(value) > 0.0 >= counter_cam.size_excess(nearest):
        value = float(brentq(counter_cam.size_excess, nearest, value, xtol=1e-300, rtol=1e-13))
        # too small or too large, with these laws
        return CounterRollerPlacement(spec.with_deferred({name: value}), False)
    farthest = helps and not any(counter_cam.cones(value))
    return CounterRollerPlacement(spec.with_deferred({name: value}), least is not None, farthest)


@dataclass(frozen=True, eq=False)
class _CounterCam:
    """The counter cam beside a finished main cam; ``name``: of the distance in the spec."""

    spec: DesignSpec
    cam: Candidate
    name: str
    deadline: float
    known: dict[float, float] = field(default_factory=dict)  # excess of the rows, by distance

    def at(self, distance: float) -> Problem:
        """The problem put to the counter cam alone."""
        problem, follower = self.cam.problem, self.spec.follower
        closure = follower.closure.counter_only({self.name: distance})
        machine = replace(problem.machine, follower=follower.with_closure(closure))
        return replace(problem, machine=machine, limits=self.spec.all_limits())

    def nearest_feasible(self, low: float, high: float) -> float | None:
        """The least distance between two ends that keeps every limit, None where none does."""
        samples, size = sample(self.cam.problem), self.cam.size
        for _ in range(MAX_ITERATIONS):
            # 1. The first place tried that does at the samples, and where its limit just holds.
            places = _trial_places(low, high)
            good = (k for k, place in enumerate(places) if self.excess(place, samples) <= 0.0)
            first = next(good, None)
            if first is None:
                return None
            result = places[first]
            if first and clock.now() < self.deadline:
                before = places[first - 1]
                root = brentq(self.excess, before, result, (samples,), xtol=1e-300, rtol=1e-13)
                result = min(float(root) * (1.0 + CLEARANCE), high)
            # 2. Once more with the peaks between the samples, until none is exceeded.
            problem = self.at(result)
            peak_samples = peaks(problem, samples, size)
            if violation(problem, peak_samples, size) <= 0.0:
                return result
            samples = [*samples, *peak_samples]
        return result

    def excess(self, distance: float, samples: list[Samples]) -> float:
        """By how much the worst limit is exceeded, relative."""
        problem = self.at(distance)
        if distance not in self.known:  # rows hold all along a segment, whatever the samples
            self.known[distance] = self._excess_of_rows(problem)
        worst = self.known[distance]
        with np.errstate(divide="ignore", invalid="ignore"):  # with the roller on the axis
            shape = violation(problem, samples, self.cam.size)
        value = max(worst, shape + CLEARANCE)
        return 1.0 if isnan(value) or value == inf else value

    def _excess_of_rows(self, problem: Problem) -> float:
        worst = -1.0
        for segment in problem.segments:
            for row in problem.rows_on(segment, self.cam.value):
                if row.size:
                    scale = max(map(abs, row.size)) * problem.length
                    worst = max(worst, row_excess(row, segment, self.cam.size) / scale)
        return worst

    def size_excess(self, distance: float) -> float:
        """By how much the counter cam is too large, relative; rises with the distance."""
        return max(
            (cone.norm.value(self.cam.size) / cone.upper - 1.0 for cone in self.cones(distance)),
            default=-1.0,
        )

    def cones(self, distance: float) -> Iterator[NormBounds]:
        """What an outer radius says of the size, the counter roller being there."""
        problem = self.at(distance)
        for limit in problem.limits:
            yield from limit.norm_bounds(problem.segments, problem.machine)


def _trial_places(low: float, high: float) -> list[float]:
    """Places to try: dense beside the nearest, and all over the range."""
    span = high - low
    dense, even = low + span * np.geomspace(1e-5, 1.0, DENSE), np.linspace(low, high, EVEN)
    result = np.unique(np.clip(np.concatenate([dense, even]), low, high))
    return [float(place) for place in result]
