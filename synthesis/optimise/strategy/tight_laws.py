"""Limits that one law alone keeps: that law is fixed, and what else is free is optimised.

A cone program needs slack about its solution; where limits on the motion leave a law none, no
program finds it. Phase 1 does: its least share of these limits is then 1, and the law with that
share is the only one. With it given, the problem is as any other.
"""

from __future__ import annotations

import time
from dataclasses import replace

from synthesis.optimise.recovery.candidate import cam_at_size
from synthesis.optimise.state import Optimise, SolveState, Stage
from synthesis.optimise.strategy.phase_one import MET, PhaseOneResult

WIDER = 1e-6
"""Relative: by how much limits are wider for a bound where they leave no slack."""


def fix_tight_laws(state: SolveState, gentlest: PhaseOneResult, optimise: Optimise) -> SolveState:
    """The state with a cam whose laws that leave no slack are those of phase 1; without, if none.

    The bound is not touched.
    """
    problem, started = state.problem, time.perf_counter()
    # 1. Fix these laws. They end as much short of their lift as they exceed the limits, and that
    #    much again: a share of 1e-9 of the lift is what the certificate allows at a joint.
    short = 1.0 - 2.0 * MET
    fixed = {k: replace(gentlest.laws[k], coefficients=gentlest.laws[k].coefficients * short)
             for k in gentlest.tight}  # fmt: skip
    placed = [problem.free[k].with_law(law.curve()) for k, law in fixed.items()]
    # 2. Optimise the others, and the size.
    rest = optimise(problem.with_laws(placed), state.tolerance, state.deadline, state.tighten)
    best = rest.incumbent
    if best is None:
        return replace(state, undecided=gentlest.undecided)
    # 3. All laws in their order, with the size found.
    others = iter(best.laws)
    laws = [fixed[k] if k in fixed else next(others) for k in range(len(problem.free))]
    curves = [s.with_law(law.curve()) for s, law in zip(problem.free, laws, strict=True)]
    state = state.with_relaxed(cam_at_size(problem.with_laws(curves), laws, best.size))
    note = f"the limits on {' and '.join(gentlest.names)} leave no slack beside these laws"
    intervals = sum(len(law.space.breaks) - 1 for law in fixed.values())
    return state.with_stage(
        Stage(
            "limits just met", f"LP, {intervals} spline intervals", "HiGHS", 0, 0, 0,
            time.perf_counter() - started, "solved", note,
        )
    )  # fmt: skip
