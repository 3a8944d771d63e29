"""What a branch and bound over traced limits has to prove, and where its limits may bind."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from synthesis.catalogue.limits import Limit
from synthesis.catalogue.motion import PlacedSegment
from synthesis.optimise.conic.control import Control, law_controls
from synthesis.optimise.conic.program import formulate
from synthesis.optimise.problem.grid import round_knots, uniform_grid
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.propagation.improving_region import Parts
from synthesis.optimise.propagation.law_tightening import with_value_cap
from synthesis.optimise.recovery.candidate import Candidate
from synthesis.optimise.relaxation import size_rows
from synthesis.optimise.state.solve_state import SolveState

INTERVALS = 20  # of the mesh on which the caps of the laws are read
SAMPLES = 200  # points of a segment at which limits are looked at
JOINED = 0.08  # share of a segment: parts with binding limits that are no farther apart are one
AIM = 0.985  # share of the tolerance: the gap that is to be proven


@dataclass(frozen=True, eq=False)
class BoundTask:
    """What is to be proven: no cam has a value below ``target`` [core units].

    Attributes:
        problem: the problem, its laws free to jump in their third derivative: all laws are.
        incumbent: the best cam. controls: caps of the free laws' third derivatives.
        deadline: ``time.monotonic()`` at which to stop.
    """

    problem: Problem
    incumbent: Candidate
    target: float
    controls: tuple[Control, ...]
    deadline: float
    thorough: bool

    @classmethod
    def of(cls, state: SolveState, incumbent: Candidate, deadline: float) -> Self | None:
        """The task about an incumbent; None where nothing caps the jerk of every free law."""
        free = {
            s.index: replace(s, free=replace(s.free, smoothness=2))
            for s in state.problem.free
            if s.free is not None
        }
        segments = tuple(free.get(s.index, s) for s in state.problem.segments)
        problem = replace(state.problem, segments=segments)
        objective, machine = problem.objective, problem.machine
        value = objective.to_wire(incumbent.value, machine)
        target = objective.from_wire(value - AIM * state.tolerance * abs(value), machine)
        coarse = [uniform_grid(segment, INTERVALS) for segment in problem.free]
        capped = law_controls(formulate(with_value_cap(problem, target), coarse))
        if capped is None or not all(c.order == 3 and np.isfinite(c.cap) for c in capped):
            return None
        return cls(problem, incumbent, target, tuple(capped), deadline, state.thorough)


def binding_parts(state: SolveState, free: PlacedSegment) -> Parts:
    """Parts of a free law on which traced limits are nearly binding or exceeded.

    In the incumbent, or in the best cam of the relaxation.
    """
    x = np.linspace(0.0, 1.0, SAMPLES + 1)
    worst = np.full(len(x), -np.inf)
    for cam in (state.incumbent, state.relaxed):
        if cam is not None:
            (segment,) = (s for s in cam.problem.segments if s.index == free.index)
            theta = segment.start + segment.angle * x
            excess = size_rows.relative_excess(cam.problem, segment, theta, cam.size)
            worst = np.maximum(worst, excess)
    where = np.flatnonzero(worst > size_rows.NEAR)
    if not len(where):
        return ()
    runs = np.split(where, np.flatnonzero(np.diff(where) > JOINED * SAMPLES) + 1)
    ends = np.array([[x[run[0]] - 2.0 / SAMPLES, x[run[-1]] + 2.0 / SAMPLES] for run in runs])
    places = round_knots(np.clip(ends, 0.0, 1.0))  # there will be knots
    return tuple((float(low), float(high)) for low, high in places)


def is_traced(state: SolveState, limit: Limit) -> bool:
    """Whether a limit implies rows where a traced point is nearly known."""
    return any(limit.curvature_bounds(s, state.problem.machine) for s in state.problem.segments)
