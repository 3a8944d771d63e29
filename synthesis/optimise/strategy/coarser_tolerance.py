"""A second proof at a coarser tolerance, where the budget of the first ended early.

At a finer tolerance a proof over parts of the domain has to exclude more cams. Its rows are weaker,
and the same number of programs may end at a lower bound. So the same problem is solved again at a
coarser tolerance, with the same number of programs. The tolerance only says when to stop: each cam
of one run is a cam of the other, and each bound over all laws holds for both.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import inf

from synthesis.optimise.state import ProofBudget, SolveState

TOLERANCES = (1e-3, 5e-3)  # relative: a gap wider than one of these is tried again with it


def retry_at_coarser_tolerance(
    state: SolveState, proof: ProofBudget, optimise: Callable[..., SolveState]
) -> SolveState:
    """The state with the better cam and the better bound of both proofs.

    A second proof is made where the gap is wider than a tolerance of the list that is coarser than
    the one asked for. It is not made where a time is given in place of a number of programs, or
    where a dimension of the follower is searched: each of its values is a problem of its own.
    """
    problem = state.problem
    coarser = next((gap for gap in TOLERANCES if gap > state.tolerance), inf)
    wide = inf > state.gap_between(state.incumbent, state.lower) > coarser
    has_ended = 0.0 < proof.programs < inf and not state.thorough and state.time_left > 0.0
    searched = problem.machine.follower.fixable_dimension() is not None
    if not (wide and has_ended and problem.free) or searched or state.is_good_enough:
        return state
    found = optimise(
        problem, coarser, state.deadline, state.tighten, proof=proof,
        sufficient=state.sufficient, sufficient_bound=state.sufficient_bound,
    )  # fmt: skip
    state = replace(state, stages=(*state.stages, *found.stages))
    if found.incumbent is not None:
        state = state.with_incumbent(found.incumbent)
    if not (found.covers_all_laws and state.covers_all_laws) or found.lower <= state.lower:
        return state
    known = replace(state, modelled_kinds=found.modelled_kinds)
    return known.raise_bound(found.lower, found.valid_for)
