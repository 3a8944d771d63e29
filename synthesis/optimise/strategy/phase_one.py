"""Where nothing fits on the first knots: the least that limits on the motion have to allow.

Limits that leave little room are met by laws that switch at places of their own: on knots that are
elsewhere nothing fits, though there are such laws. So the share of the limits on the highest
derivative that is needed is made small first, on knots that move to the switches of the ideal law.
If it comes below 1, there are the knots; if its bound over all laws lies above 1, there is no law.

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
from synthesis.numerics.solvers.clarabel import ConeProgram, solve
from synthesis.numerics.solvers.statuses import USABLE
from synthesis.optimise.conic.linear_rows import Tightening
from synthesis.optimise.conic.program import formulate
from synthesis.optimise.dual_bound.bound import dual_bound
from synthesis.optimise.problem.grid import CLOSEST_KNOTS, Grid
from synthesis.optimise.problem.problem import NoObjective, Problem
from synthesis.optimise.recovery.candidate import recover_cam
from synthesis.optimise.refinement.mesh import refine_mesh

ROUNDS = 8  # of moving knots to the switches of the ideal law
PROVEN = 1e-9  # what a bound has to lie above 1 by
SETTLED = 1e-6  # between share and bound: finer knots bring no more
GAIN = 1e-4  # of the share, by a round: less is not worth another where no law would do
STEERING = (3, 2)  # derivatives whose limits make laws switch


class LargestShare(Objective):
    """The largest share of some limits that the motion uses; 1 where it just meets them."""

    kind: Literal["share"] = "share"
    shared: tuple[Any, ...] = ()

    def rows(
        self, segment: PlacedSegment, machine: Machine, level: float
    ) -> tuple[LinearInequality, ...]:
        return tuple(
            replace(row, coefficients=_over(row), upper=0.0, level=-1.0)
            for limit in self.shared
            for row in limit.rows(segment, machine)
        )

    def to_wire(self, value: float, machine: Machine) -> float:
        return value

    def from_wire(self, value: float, machine: Machine) -> float:
        return value


def _over(row: LinearInequality) -> tuple[float, float, float, float]:
    s, v, a, j = (factor / row.upper for factor in row.coefficients)
    return s, v, a, j


@dataclass(frozen=True, eq=False)
class PhaseOneResult:
    """The knots of the gentlest law found, its share of the limits, and the least of any law.

    ``jumps``: whether the ideal law jumps in a derivative in which the laws asked for may not.
    """

    grids: tuple[Grid, ...]
    share: float
    least: float
    names: tuple[str, ...]
    jumps: bool = False

    @property
    def fits(self) -> bool:
        """Whether that law keeps the limits."""
        return self.share < 1.0

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
            f"with ramps no shorter than {CLOSEST_KNOTS:g} of a segment{remedy}"
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
    steering = _steering(problem)
    if not steering:
        return None
    others = tuple(limit for limit in problem.limits if limit not in steering)
    asked = replace(
        problem, limits=others, objective=LargestShare(shared=steering), objective_caps=()
    )
    names = tuple(dict.fromkeys(limit.kind for limit in steering))
    present, best = tuple(grids), None
    for _ in range(ROUNDS):
        model = formulate(asked, present, 0.0, Tightening(tighten))
        solution = solve(model.program, deadline - clock.now())
        if solution.stopped not in USABLE:
            break
        lower, found = dual_bound(model, solution), recover_cam(asked, *model.recover(solution.x))
        least = lower.value if lower.switching else -inf
        before = best or PhaseOneResult(present, inf, -inf, names, _jumps(problem, steering))
        best = replace(before, least=max(before.least, least))
        if found.value < before.share:
            best = replace(best, grids=present, share=found.value)
        gained = before.share - best.share > GAIN * best.share
        done = best.fits or best.share - best.least <= SETTLED or (best.impossible and not gained)
        if done or clock.now() >= deadline:
            break
        present = refine_mesh(asked, present, found, lower, [np.zeros(0)] * len(present))
    return best


def least_excess(problem: Problem, grids: Sequence[Grid], tighten: float) -> float | None:
    """The least by which limits must be exceeded on given grids, as one linear or cone program.

    Every inequality, and every cone, is relaxed by the same amount of its own natural size; both
    sides of an equality count as inequalities. For searches over the numbers of a problem.

    Args:
        problem: the problem. grids: one per free law. tighten: relative, of all limits.

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
        )
    )
    return float(max(solution.x[-1], 0.0)) if solution.stopped in USABLE else None


def _steering(problem: Problem) -> tuple[Limit, ...]:
    """The limits on the highest derivative that is limited all along free laws."""
    for order in STEERING:
        found = tuple(limit for limit in problem.limits if _limits(limit, order, problem))
        if found:
            return found
    return ()


def _jumps(problem: Problem, steering: Sequence[Limit]) -> bool:
    """Whether accelerations are limited, and laws may not jump in theirs."""
    bent = any(limit.rows(s, problem.machine) and _limits(limit, 2, problem)
               for limit in steering for s in problem.free)  # fmt: skip
    return bent and any(s.free is not None and s.free.smoothness > 1 for s in problem.free)


def _limits(limit: Limit, order: int, problem: Problem) -> bool:
    """Whether all that a limit says on free laws is of one derivative, bounded all along."""
    rows = [row for s in problem.free for row in limit.rows(s, problem.machine)]
    return bool(rows) and all(
        row.interval is None
        and not any(row.size)
        and row.upper > 0.0
        and [k for k, factor in enumerate(row.coefficients) if factor] == [order]
        for row in rows
    )
