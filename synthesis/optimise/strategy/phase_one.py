"""Where nothing fits on the first knots: the least that limits on the motion have to allow.

Limits that leave little slack are met by laws that switch at places of their own: on knots that are
elsewhere nothing fits, though there are such laws. So the share of the limits on the highest
derivative that a law needs is minimised first, on knots that move to the switches of the ideal law.
The law with the least share is the gentlest law. If its share lies below 1, its knots serve; if the
bound of the share over all laws lies above 1, no law keeps the limits.

The loop is not the driver's: moving all knots to the switches finds these laws in a tenth of the
time that refining the driver's meshes takes, and where the size is tight it finds them at all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Any, Literal

import numpy as np
from scipy import sparse

from synthesis.catalogue.constraints import LinearInequality
from synthesis.catalogue.limits import Limit, Machine
from synthesis.catalogue.motion import PlacedSegment
from synthesis.catalogue.objectives import Objective
from synthesis.numerics import clock
from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.clarabel import ConeProgram, ConeSolution, solve
from synthesis.numerics.solvers.highs import LinearRows, minimise_each
from synthesis.numerics.solvers.statuses import USABLE, StopReason
from synthesis.optimise.conic.linear_rows import Tightening
from synthesis.optimise.conic.program import ConicModel, formulate
from synthesis.optimise.dual_bound.bound import Bound, dual_bound
from synthesis.optimise.dual_bound.dual_ascent import improve_multipliers
from synthesis.optimise.problem.derivative_caps import caps_derivative, highest_caps
from synthesis.optimise.problem.grid import RAMP_STEP, Grid, SplineLaw, uniform_grid
from synthesis.optimise.problem.problem import NoObjective, Problem
from synthesis.optimise.recovery.candidate import Candidate, recover_cam
from synthesis.optimise.refinement.mesh import is_same_mesh, refine_mesh
from synthesis.optimise.refinement.polish import grids_on_switches

MAX_ITERATIONS = 8  # of moving knots to the switches of the ideal law
PROOF_ITERATIONS = 12  # of finer knots in a proof that limits exclude each other
PROVEN = 1e-9  # what a bound has to lie above 1, or an excess above 0, by
SETTLED = 1e-6  # between share and bound: finer knots bring no more
GAIN = 1e-4  # of the share, by an iteration: less is not worth another where no law would do
INTERVALS = 24  # of a mesh where none is known
NEAR = 1e-2  # of 1: a share from which on the gentlest law is sought to the last digits
LOCATIONS = 24  # of the switches, each from the law before
MOST_KNOTS = 60
"""Of a law whose vertex is sought. Rows at consecutive knots determine a spline by a recursion that
grows by up to 4 (degree 3) or 110 (degree 7) from one to the next: a simplex basis of n such rows
has an inverse of up to 110ⁿ. On 909 knots squares of it overflowed, and HiGHS's choice of a row
called itself until the process ended. 110⁶⁰ is 3e122."""
IDLE = 4  # vertices in a row whose share changes by more than it has changed before
LITTLE = 0.1  # of what a share differs from 1 by: a smaller change brings it no nearer
VERTEX_ACCURACY = 1e-10  # of the rows of a vertex
MULTIPLIER = 1e-6  # of the objective's: rows with a smaller one hold nothing back
SPARE = 1e-6  # of 1: a share as far below it leaves a solver slack
MET = 3e-10
"""Of 1: a share that exceeds it by no more is that of a law that just meets the limits: one that
ends as much short of its lift keeps them; the certificate allows three times that at a joint."""


class LargestShare(Objective):
    """The largest share of some limits that the motion uses; 1 where it just meets them."""

    kind: Literal["share"] = "share"
    shared: tuple[Any, ...] = ()

    def rows(
        self, segment: PlacedSegment, machine: Machine, level: float
    ) -> tuple[LinearInequality, ...]:
        return tuple(self._share(row) for limit in self.shared
                     for row in limit.rows(segment, machine))  # fmt: skip

    def _share(self, row: LinearInequality) -> LinearInequality:
        return replace(row, coefficients=_over(row, row.upper), upper=0.0, level=-1.0)

    def to_wire(self, value: float, machine: Machine) -> float:
        return value

    def from_wire(self, value: float, machine: Machine) -> float:
        return value


class LargestExcess(LargestShare):
    """By how much the rows of some limits are exceeded at most, over their largest coefficient.

    Limits that make no linear rows are left out, and rows on the size where ``size_free`` is set:
    what is then shown to be above 0 is so for every size.
    """

    kind: Literal["excess"] = "excess"  # type: ignore[assignment]
    size_free: bool = False

    def rows(
        self, segment: PlacedSegment, machine: Machine, level: float
    ) -> tuple[LinearInequality, ...]:
        each = (row for limit in self.shared for row in limit.rows(segment, machine))
        kept = (row for row in each if not row.is_constant and not row.equality)
        return tuple(self._share(row) for row in kept if not (self.size_free and any(row.size)))

    def _share(self, row: LinearInequality) -> LinearInequality:
        unit = max(map(abs, (*row.coefficients, *row.size)))
        size = tuple(factor / unit for factor in row.size)
        return replace(
            row, coefficients=_over(row, unit), size=size, upper=row.upper / unit, level=-1.0
        )


def _over(row: LinearInequality, unit: float) -> tuple[float, float, float, float]:
    s, v, a, j = (factor / unit for factor in row.coefficients)
    return s, v, a, j


@dataclass(frozen=True, eq=False)
class PhaseOneResult:
    """The knots of the gentlest law found, its share of the limits, and the least of any law.

    Attributes:
        jumps: whether the ideal law jumps in a derivative in which the laws asked for may not.
        laws: those with this share, one per grid. tight: positions of those that leave no slack.
    """

    grids: tuple[Grid, ...]
    share: float
    least: float
    names: tuple[str, ...]
    jumps: bool = False
    laws: tuple[SplineLaw, ...] = ()
    tight: tuple[int, ...] = ()

    @property
    def fits(self) -> bool:
        """Whether that law keeps the limits."""
        return self.share < 1.0

    @property
    def just_meets(self) -> bool:
        """Whether that law meets the limits, and no other leaves a solver slack."""
        return bool(self.tight) and 1.0 - SPARE <= self.share <= 1.0 + MET

    @property
    def impossible(self) -> str:
        """Why no law at all keeps them; empty where that is not proven."""
        if self.least <= 1.0 + PROVEN:
            return ""
        limits = " and ".join(self.names)
        return (
            f"no motion law at all keeps these limits: every one exceeds that on {limits} by "
            f"{self.least - 1.0:.3g} of its value or more, or breaks another"
        )

    @property
    def undecided(self) -> str:
        """What is known where no law was found and none is excluded; empty elsewhere."""
        if self.fits or self.impossible:
            return ""
        limits = " and ".join(self.names)
        remedy = "; a spline of smoothness 1 needs no ramps" if self.jumps else ""
        return (
            f"whether a law keeps these limits is not known, and that none does is not proven: the "
            f"gentlest one found exceeds that on {limits} by {self.share - 1.0:.3g} of its value, "
            f"with ramps no shorter than {RAMP_STEP:g} of a segment{remedy}"
        )


def minimise_excess(
    problem: Problem, grids: Sequence[Grid], tighten: float, deadline: float = inf
) -> PhaseOneResult | None:
    """The gentlest motion under the other limits; None where no such limit is known.

    Args:
        problem: the question. grids: the knots to begin with, one per free law.
        tighten: relative amount by which rows are drawn in for the solver's sake.
        deadline: ``time.monotonic()`` at which to stop.
    """
    steering = highest_caps(problem)
    if not steering:
        return None
    others = tuple(limit for limit in problem.limits if limit not in steering)
    if problem.open_above:  # the end of the search is ours: what is shown is to hold for every size
        others = tuple(limit for limit in others if not _speaks_of_size(limit, problem))
    auxiliary = replace(
        problem, limits=others, objective=LargestShare(shared=steering), objective_caps=()
    )
    names = tuple(dict.fromkeys(limit.kind for limit in steering))
    present, best = tuple(grids), None
    for number in range(MAX_ITERATIONS):
        model = formulate(auxiliary, present, 0.0, Tightening(tighten))
        solution = solve(model.program, deadline - clock.now())
        if solution.stopped not in USABLE:
            break
        lower = dual_bound(model, solution)
        found = recover_cam(auxiliary, *model.recover(solution.x))
        least = lower.value if lower.switching else -inf
        before = best or PhaseOneResult(present, inf, -inf, names, _jumps(problem, steering))
        best = replace(before, least=max(before.least, least))
        if found.value < before.share:
            best = replace(best, grids=present, share=found.value)
        if number == 0 and best.share > 1.0 - NEAR:
            best = _to_last_digits(auxiliary, best, found, deadline)
        gained = before.share - best.share > GAIN * best.share
        done = best.fits or best.share - best.least <= SETTLED or (best.impossible and not gained)
        if done:
            break
        last, nothing = present, [np.zeros(0)] * len(present)
        present = refine_mesh(auxiliary, present, found, lower, nothing)
        if is_same_mesh(present, last):
            break
    return best


def _to_last_digits(
    auxiliary: Problem, near: PhaseOneResult, law: Candidate, deadline: float
) -> PhaseOneResult:
    """The gentlest law to rounding, on knots at its own switches, where it is found, and its bound.

    The share's least value is a vertex of the linear program: the simplex method solves the rows
    that bind there to rounding. From vertex to vertex the knots move onto the switches; how far the
    share is from its least falls with their distance. Sizes are left out, as any law may have them.
    With knots on the switches few are enough, also for the best multipliers of all laws.
    """
    grids = grids_on_switches(auxiliary, law, INTERVALS)
    share, least_change, idle = inf, inf, 0
    for _ in range(LOCATIONS):
        if not grids or max(len(grid.space.breaks) for grid in grids) > MOST_KNOTS:
            break
        model = formulate(auxiliary, grids, 0.0)
        rows, end = model.program, model.program.equalities + model.program.inequalities
        unlimited = np.full(rows.matrix.shape[1], inf)
        linear = LinearRows(
            rows.matrix[:end], rows.rhs[:end], rows.equalities, -unlimited, unlimited
        )
        (vertex,) = minimise_each(
            linear, [rows.linear], deadline - clock.now(), accuracy=VERTEX_ACCURACY
        )
        if vertex.stopped is not StopReason.SOLVED:
            break
        cam = recover_cam(auxiliary, *model.recover(vertex.x))
        if cam.value < near.least - NEAR:
            break  # cones, which are not among the rows, hold the share up
        little = max(0.1 * MET, LITTLE * min(abs(cam.value - 1.0) - SPARE, SETTLED))
        change = abs(cam.value - share)
        if change <= (MET if abs(cam.value - 1.0) <= MET else little):
            tight = _held_back(model, vertex.multipliers)
            last = replace(near, grids=grids, share=cam.value, laws=cam.laws, tight=tight)
            # Rows between points may have flattered the law that it began with.
            known = last if last.just_meets or last.share < near.share else near
            return replace(known, least=max(known.least, _least_of_all_laws(model, cam, deadline)))
        grids, share = grids_on_switches(auxiliary, cam, INTERVALS), cam.value
        idle = 0 if change < least_change else idle + 1
        least_change = min(least_change, change)
        if idle == IDLE or clock.now() >= deadline:
            break  # the knots wander, and come no nearer to the switches
    return near


def _least_of_all_laws(model: ConicModel, cam: Candidate, deadline: float) -> float:
    """The bound over all laws by the best multipliers of a model's rows; −∞ where there is none.

    Any multipliers give a valid bound: the solution of the model says only which rows bind.
    """
    solution = solve(model.program, deadline - clock.now())
    if solution.stopped not in USABLE:
        return -inf
    bound = improve_multipliers(
        model, solution, dual_bound(model, solution),
        lambda each: cam.value - each.value <= LITTLE * SETTLED, deadline - clock.now(),
    )  # fmt: skip
    return bound.value if bound.switching else -inf


def _held_back(model: ConicModel, multipliers: Array) -> tuple[int, ...]:
    """Positions of the laws whose rows hold the level up, those with positive multipliers."""
    held = (
        block.segment for first, block in model.numbered_blocks
        if block.level and np.any(multipliers[first : first + len(block.rhs)] > MULTIPLIER)
    )  # fmt: skip
    return tuple(sorted({k for k in held if k is not None}))


def excess_proof(problem: Problem, deadline: float = inf) -> str:
    """Why no motion law and no size keep the linear rows of all limits; empty without a proof."""
    found = least_excess_program(problem, deadline)
    if found is None or found[2].value <= PROVEN:
        return ""
    return "proven for every motion law and size: the limits exclude each other"


def least_excess_program(
    problem: Problem, deadline: float = inf
) -> tuple[ConicModel, ConeSolution, Bound] | None:
    """The program of the least largest excess of a row, with its bound over all laws and sizes.

    A bound above 0 is a proof that the limits exclude each other: by weak duality it holds
    for every law whose highest limited derivative is bounded so, and for every size. Where the base
    radius is open above, its end in the search is ours: only rows without the size are looked at.
    None where there is no such bound, or no time: ``clock.now()`` at the deadline.
    """
    # What caps the control stays a limit: the bound over all laws rests on it.
    caps = highest_caps(problem)
    others = tuple(limit for limit in problem.limits if limit not in caps)
    objective = LargestExcess(shared=others, size_free=problem.open_above)
    auxiliary = replace(
        problem, limits=caps, objective=objective, objective_caps=(),
        segments=tuple(_roughest(segment, caps, problem) for segment in problem.segments),
    )  # fmt: skip
    if not any(objective.rows(s, problem.machine, 0.0) for s in problem.segments):
        return None
    best, grids = None, tuple(uniform_grid(segment, INTERVALS) for segment in auxiliary.free)
    for _ in range(PROOF_ITERATIONS):
        model = formulate(auxiliary, grids, 0.0)
        solution = solve(model.program, deadline - clock.now())
        if solution.stopped not in USABLE:
            break
        bound = dual_bound(model, solution)
        found = recover_cam(auxiliary, *model.recover(solution.x))
        if problem.free and not bound.switching:
            break
        improved = best is None or bound.value > best[2].value
        best = (model, solution, bound) if improved else best
        # Finer knots bring the bound nearer to what the best law exceeds, if that is above 0.
        if bound.value > PROVEN or found.value <= PROVEN or not improved:
            break
        grids = refine_mesh(auxiliary, grids, found, bound, [np.zeros(0)] * len(grids))
    return best


def _roughest(segment: PlacedSegment, caps: Sequence[Limit], problem: Problem) -> PlacedSegment:
    """A free law whose capped derivative may jump everywhere: the bound covers such laws too.

    The ideal law switches from one end of the cap to the other; smoother splines come near it
    slowly, and their multipliers give a bound as far below.
    """
    law = segment.free
    if law is None or segment.law is not None or not caps:
        return segment
    roughest = 2 if caps_derivative(caps[0], 3, problem) else 1
    start, end = (min(each, roughest) for each in law.end_continuity)
    smoothness = min(law.smoothness, roughest)
    return replace(segment, free=replace(law, smoothness=smoothness, end_continuity=(start, end)))


def least_excess(
    problem: Problem, grids: Sequence[Grid], tighten: float, deadline: float
) -> float | None:
    """The least by which limits must be exceeded on given grids, as one linear or cone program.

    Every inequality, and every cone, is relaxed by the same amount of its own natural size; both
    sides of an equality count as inequalities. For searches over the numbers of a problem.

    Args:
        problem: the problem. grids: one per free law. tighten: relative, of all limits.
        deadline: ``clock.now()`` at which the solver stops.

    Returns:
        the amount, 0 where all limits can hold together; None where the solver fails.
    """
    bare = replace(problem, objective=NoObjective(), objective_caps=())
    program = formulate(bare, grids, 0.0, Tightening(tighten), paired=True).program
    rows, unknowns = program.matrix.shape
    relaxed = np.zeros(rows)
    first = program.equalities + program.inequalities
    relaxed[program.equalities : first] = 1.0
    relaxed[first + np.cumsum((0, *program.cones))[:-1]] = 1.0
    least = sparse.csc_matrix(([-1.0], ([0], [unknowns])), shape=(1, unknowns + 1))
    matrix = sparse.hstack([program.matrix, sparse.csc_matrix(-relaxed[:, None])], format="csr")
    solution = solve(
        ConeProgram(
            sparse.csc_matrix((unknowns + 1, unknowns + 1)),
            np.append(np.zeros(unknowns), 1.0),
            sparse.csc_matrix(sparse.vstack([matrix[:first], least, matrix[first:]])),
            np.concatenate([program.rhs[:first], [0.0], program.rhs[first:]]),
            program.equalities,
            program.inequalities + 1,
            program.cones,
        ),
        deadline - clock.now(),
    )
    return float(max(solution.x[-1], 0.0)) if solution.stopped in USABLE else None


def _jumps(problem: Problem, steering: Sequence[Limit]) -> bool:
    """Whether accelerations are limited, and laws may not jump in theirs."""
    bent = any(limit.rows(s, problem.machine) and caps_derivative(limit, 2, problem)
               for limit in steering for s in problem.free)  # fmt: skip
    return bent and any(s.free is not None and s.free.smoothness > 1 for s in problem.free)


def _speaks_of_size(limit: Limit, problem: Problem) -> bool:
    rows = (row for s in problem.free for row in limit.rows(s, problem.machine))
    return any(any(row.size) for row in rows)
