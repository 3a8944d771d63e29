"""What a bound leaves out, in words: limits that bind and that no row of it says wholly."""

from __future__ import annotations

import numpy as np

from synthesis.formulations.cams.candidate import Candidate
from synthesis.formulations.rounds.search import Search
from synthesis.limits import Limit

SAMPLES = 200  # of a stretch
BINDS = -1e-2  # a smooth limit above this, relative, binds
OPENING = "; not wholly in it: "
IN_PROOF = "which a thorough proof takes in where every free law has a jerk limit"


def left_out(state: Search) -> str:
    """The end of a sentence on what the bound covers; empty where nothing is missing."""
    best = state.best
    if best is None or state.close(best) or not state.over or OPENING in state.over:
        return ""
    missing = [
        limit
        for limit in state.problem.limits
        if limit.kind not in state.taken_in and _binds(best, limit)
    ]
    machine, stretches = best.problem.machine, best.problem.stretches
    groups = dict[str, list[str]]()
    for limit in missing:
        known = any(limit.traced(stretch, machine) for stretch in stretches)
        word = IN_PROOF if known and state.problem.free else ""
        groups.setdefault(word, []).append(limit.kind)
    parts = [
        ", ".join([" and ".join(names), *([word] if word else [])])
        for word, names in groups.items()
    ]
    return OPENING + "; ".join(parts) if parts else ""


def _binds(cam: Candidate, limit: Limit) -> bool:
    """Whether a limit that neither rows nor tangents say leaves a cam no more room."""
    machine = cam.problem.machine
    for stretch in cam.problem.stretches:
        if limit.curved(stretch, machine):
            continue
        theta = np.linspace(stretch.start, stretch.end, SAMPLES + 1)
        s = stretch.placed().derivatives(theta)
        found = limit.smooth(stretch, machine, theta, s, cam.size)
        if any(np.max(value) > BINDS for value in found):
            return True
    return False
