"""What a search is for: when it may stop, where it begins, and what may be spent on its proof."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf

from synthesis.numerics.piecewise import Array
from synthesis.optimise.state import CAM_ONLY, QUICK, THOROUGH, ProofBudget, WarmStart
from synthesis.spec.design_spec import SMALLEST, DesignSpec

AUTO_PROGRAMS = 100
"""Cone programs and batches of linear programs that a proof with ``auto`` may solve. Each takes
0.02 to 0.04 s in every family, with all that is computed around it: 2 to 4 s in all."""
THOROUGH_PROGRAMS = 600  # the same of a thorough proof whose spec gives no time: 12 to 24 s
AUTO_SHARE = 0.5  # of the time: such a proof leaves the rest to later objectives and trials


@dataclass(frozen=True, eq=False)
class Goal:
    """When to stop, and where to begin.

    Attributes:
        stop: ``clock.now()`` at which to stop with the best so far.
        warm_start: where a neighbouring question's local search ended.
        sufficient, sufficient_bound: a value, and a lower bound, of the first objective [wire] that
            are good enough, whatever the gap.
        smallest: base radius from which on cams are sought where it is open below [strokes].
        mesh: knots of every free law to begin with, those of a neighbouring question.
        cam_only: whether nobody asks for a lower bound.
        excluding_bound: of the first objective [wire]: where its lower bound is as large, there is
            no cam as asked, and no later objective is sought.
    """

    stop: float
    warm_start: WarmStart | None = None
    sufficient: float = -inf
    sufficient_bound: float = inf
    smallest: float = SMALLEST
    mesh: tuple[Array, ...] = ()
    cam_only: bool = False
    excluding_bound: float = inf


def proof_budget(spec: DesignSpec, goal: Goal, *, is_last: bool) -> ProofBudget:
    """What may be spent on a proof; of an objective with others after it no more than their share.

    ``thorough`` spends the time that the spec gives, ``auto`` part of it; where it gives none, a
    number of programs, so that the answer depends on no machine's speed.
    """
    if goal.cam_only:
        return CAM_ONLY
    most = (AUTO_PROGRAMS, THOROUGH_PROGRAMS) if spec.time_budget_s is None else (inf, inf)
    auto, thorough = ProofBudget(most[0], AUTO_SHARE), replace(THOROUGH, programs=most[1])
    budget = {"quick": QUICK, "auto": auto, "thorough": thorough}[spec.proof]
    return budget if is_last else replace(budget, share=min(budget.share, AUTO_SHARE))
