"""Caps on lower derivatives that the best cam keeps by itself: the question without them.

Every cam of the problem is one of the problem without these caps: a bound of the latter is one of
the former, and a cam of the latter that keeps them answers both. Each of these caps is as many rows
as another law has, all along the turn. Where the gap takes a search and a proof over parts of the
domain, both are made without them as long as the cam found keeps them; so a limit that does not
bind costs neither cam nor bound.
"""

from __future__ import annotations

from dataclasses import replace

from synthesis.optimise.conic.linear_rows import row_excess
from synthesis.optimise.heuristics.local_search import local_search
from synthesis.optimise.problem.derivative_caps import without_lower_caps
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.candidate import Candidate
from synthesis.optimise.state import QUICK, Optimise, SolveState


def search_without_idle_caps(state: SolveState, optimise: Optimise) -> SolveState:
    """A local search: without the caps where the cam that it finds keeps them, else with them.

    A state without the caps is one of the problem without them: ``for_problem`` brings it back.
    A quick proof, which ends with this search, makes it with them at once.
    """
    problem, wider = state.problem, without_lower_caps(state.problem)
    if wider is not None and state.thorough and not any(x.needs_load for x in problem.limits):
        found = optimise(
            wider, state.tolerance, state.deadline, state.tighten, proof=QUICK,
            sufficient=state.sufficient, sufficient_bound=state.sufficient_bound,
        )  # fmt: skip
        if found.incumbent is not None and _keeps(found.incumbent, problem, state.tighten):
            known = state.covers_all_laws and found.covers_all_laws
            better = found.raise_bound(state.lower, state.valid_for) if known else found
            stages = (*state.stages, *better.with_exit("").stages)  # it goes on
            # The proof has the programs that it has where these caps are not asked at all.
            return replace(
                better, stages=stages, programs=state.programs,
                proof_deadline=state.proof_deadline,
            ).with_proof_begun()  # fmt: skip
    return local_search(replace(state, margin=0.0).with_proof_begun())


def for_problem(state: SolveState, problem: Problem) -> SolveState:
    """The same state of the problem with all caps, which its cams are known to keep."""
    if state.problem is problem:
        return state

    def at_home(cam: Candidate | None) -> Candidate | None:
        if cam is None:
            return None
        laws = [segment for segment in cam.problem.segments if segment.free is not None]
        return replace(cam, problem=problem.with_laws(laws))

    return replace(
        state, problem=problem, incumbent=at_home(state.incumbent), relaxed=at_home(state.relaxed),
        last=at_home(state.last),
    )  # fmt: skip


def _keeps(cam: Candidate, problem: Problem, spare: float) -> bool:
    """Whether a cam keeps all rows of a problem, with some room (relative) to spare."""
    return all(
        row_excess(row, segment, cam.size) <= -spare * abs(row.upper)
        for segment in cam.problem.segments
        for limit in problem.limits
        if limit not in cam.problem.limits
        for row in limit.rows(segment, problem.machine)
    )
