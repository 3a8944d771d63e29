"""A rough proof where a fine one has not come so far: who asks for more gets as much at least.

The finer the tolerance, the more cams a proof over parts of the domain has to exclude, so that its
rows are weaker, and the same budget may end at a lower bound. Where a proof has ended so, the same
problem is solved to a rougher tolerance, with the budget that it has alone. Both speak of the same
cams: each incumbent is one of the other, and each bound over all laws holds for both.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import inf

from synthesis.optimise.state import ProofBudget, SolveState

TOLERANCES = (1e-3, 5e-3)  # relative: a gap wider than one of these is tried again with it


def prove_roughly(
    state: SolveState, proof: ProofBudget, optimise: Callable[..., SolveState]
) -> SolveState:
    """The state with cam and bound of a rougher question, where the budget of its proof has ended.

    Between the tolerances of the list a finer one may still come to less; and where a time is given
    in place of a number of programs, whose rest is others'. Where a dimension is searched, its
    values are problems for themselves.
    """
    problem = state.problem
    rough = next((gap for gap in TOLERANCES if gap > state.tolerance), inf)
    wide = inf > state.gap_between(state.incumbent, state.lower) > rough
    has_ended = 0.0 < proof.programs < inf and not state.thorough and state.time_left > 0.0
    searched = problem.machine.follower.fixable_dimension() is not None
    if not (wide and has_ended and problem.free) or searched or state.suffices:
        return state
    found = optimise(
        problem, rough, state.deadline, state.tighten, proof=proof, sufficient=state.sufficient
    )
    state = replace(state, stages=(*state.stages, *found.stages))
    if found.incumbent is not None:
        state = state.with_incumbent(found.incumbent)
    if not (found.covers_all_laws and state.covers_all_laws) or found.lower <= state.lower:
        return state
    known = replace(state, modelled_kinds=found.modelled_kinds)
    return known.raise_bound(found.lower, found.valid_for)
