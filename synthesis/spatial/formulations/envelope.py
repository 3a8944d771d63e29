"""Where every law of a cam no larger than a given one is, cam angle by cam angle.

No law is ahead of the fastest run from the start, nor behind the one that runs back from the end.
"""

from __future__ import annotations

from math import inf

import numpy as np

from synthesis.formulations.cone.convex import Plan
from synthesis.formulations.cone.tubing import Tube
from synthesis.spatial.formulations.fastest import Track

NODES = 128
SPARE = 1e-4  # of the lift: more than a run is out by between its nodes


def envelopes(plan: Plan, size: float) -> tuple[Tube, ...]:
    """The tube of every free law whose cam is no larger than ``size`` [mm]; some derivative capped.

    Returns:
        () where no cam of that size has such laws.
    """
    found = []
    for stretch, ends in zip(plan.problem.free, plan.settled, strict=True):
        tube = _envelope(Track.of(plan.problem, stretch, (ends.start, ends.end)), size)
        if tube is None:
            return ()
        found.append(tube)
    return tuple(found)


def _envelope(track: Track, size: float) -> Tube | None:
    run, stretch = track.run(size), track.stretch
    if run is None:
        return None
    lift, angle = abs(stretch.lift), stretch.angle
    nodes, spare = np.linspace(0.0, 1.0, NODES + 1), SPARE * lift
    high = np.interp(nodes * angle, run.ahead, run.p) + spare
    low = np.interp(nodes * angle, angle - run.behind, run.p) - spare
    assert stretch.free is not None
    if not stretch.free.overshoot:
        low, high = np.clip(low, 0.0, lift), np.clip(high, 0.0, lift)
    low[0] = high[0] = 0.0
    low[-1] = high[-1] = lift
    fast = np.full(NODES + 1, min(float(np.max(run.speed)) * angle / lift, 1e6))
    slow = -fast if stretch.free.overshoot else 0.0 * fast
    jerk = track.caps.jerk < inf
    cap = track.caps.jerk * angle**3 if jerk else track.caps.acceleration * angle**2
    return Tube(nodes, low / lift, high / lift, slow, fast, 3 if jerk else 2, cap / lift)
