"""Which limits a lower bound leaves out, in words for the report."""

from __future__ import annotations

import numpy as np

from synthesis.catalogue.limits import Limit
from synthesis.optimise.propagation.improving_region import is_stated
from synthesis.optimise.recovery.candidate import Candidate
from synthesis.optimise.state import SolveState

SAMPLES = 200
"""Points of a segment."""
BINDS = -1e-2
"""Relative value of a smooth limit from which on it binds."""
ACCELERATION = 2  # order of the derivative
OPENING = "; not wholly in it: "
IN_PROOF = "which a thorough proof takes in where every free law has a limit on {}"


def unmodelled_limits(state: SolveState) -> str:
    """Name the limits that bind on the incumbent and that no row of the bound states wholly.

    Returns:
        the end of a sentence on what the bound covers; empty where nothing is left out.
    """
    best = state.incumbent
    if best is None or state.is_good_enough or not state.valid_for or OPENING in state.valid_for:
        return ""
    missing = [
        limit
        for limit in state.problem.limits
        if limit.kind not in state.modelled_kinds and _binds(best, limit)
    ]
    machine, segments = best.problem.machine, best.problem.segments
    by_remedy = dict[str, list[str]]()
    for limit in missing:
        bounds = [one for s in segments for one in limit.curvature_bounds(s, machine)]
        of_spans = all(is_stated(one, ACCELERATION) for one in bounds)
        remedy = IN_PROOF.format("jerk or acceleration" if of_spans else "jerk")
        remedy = remedy if bounds and state.problem.free else ""
        by_remedy.setdefault(remedy, []).append(limit.kind)
    parts = [
        ", ".join([" and ".join(names), *([remedy] if remedy else [])])
        for remedy, names in by_remedy.items()
    ]
    return OPENING + "; ".join(parts) if parts else ""


def _binds(cam: Candidate, limit: Limit) -> bool:
    """Whether a limit without rows or tangents of its own leaves a cam no more slack."""
    machine = cam.problem.machine
    for segment in cam.problem.segments:
        if limit.nonconvex(segment, machine):
            continue
        theta = np.linspace(segment.start, segment.end, SAMPLES + 1)
        s = segment.placed().derivatives(theta)
        values = limit.smooth_constraints(segment, machine, theta, s, cam.size)
        if any(np.max(value) > BINDS for value in values):
            return True
    return False
