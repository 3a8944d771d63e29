"""What the follower does in time, and how many walls hold it."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from synthesis.numerics.peaks import peak
from synthesis.numerics.piecewise import Piecewise
from synthesis.spatial.cam import SpatialCam
from synthesis.spatial.machine import LEFT, RIGHT
from synthesis.spatial.measuring.found import Bound, Found, Kind, leading
from synthesis.units import FULL_TURN, Travel

NAMES = ("velocity", "acceleration", "jerk")
EVIDENCE = "stationary points of every piece"
JUMP = 1e-9  # of a derivative's largest value: what is no jump


def in_time(cam: SpatialCam, travel: Travel, omega: float) -> Iterator[tuple[Kind, Found]]:
    """Largest speed, acceleration and jerk of the follower [units per rad^k of cam angle]."""
    curve = cam.motion.curve
    for order, name in enumerate(NAMES, start=1):
        rate = travel.rate(order, omega)
        kind = Kind(name, travel.told(order), True, times(rate))
        if order > 1 and (at := jump(curve, order - 1)) is not None:
            evidence = f"{NAMES[order - 2]} jumps there"
            yield kind, Found(np.inf, np.inf, evidence, at)
            continue
        both = [peak(curve, [0.0] * order + [sign]) for sign in (1.0, -1.0)]
        value, theta = max(both, key=lambda each: leading(each[0]))
        yield kind, Found(value, value, EVIDENCE, theta)


def times(rate: float) -> Callable[[float], float]:
    """What tells a value in other units."""
    return lambda value: value * rate


def jump(curve: Piecewise, order: int) -> float | None:
    """The first cam angle where a derivative jumps, over the end of the turn as well."""
    ends, pieces = curve.breaks, np.arange(curve.count)
    after = curve.at(ends[:-1], pieces, order)
    before = np.roll(curve.at(ends[1:], pieces, order), 1)
    size = max(float(np.abs(after).max()), float(np.abs(before).max()))
    jumps = np.flatnonzero(np.abs(after - before) > JUMP * size)
    return float(ends[jumps[0]]) if len(jumps) else None


def holding(cam: SpatialCam) -> Iterator[tuple[Kind, Found]]:
    """Contacts of all walls: fewest at a time on either side, which hold the follower; the mean."""
    marks = np.unique([0.0, FULL_TURN, *(t for w in cam.walls for span in w.spans for t in span)])
    middles = 0.5 * (marks[1:] + marks[:-1])
    wide = np.diff(marks)
    kept = wide > 1e-9
    counts = {
        side: sum(
            ((middles > a) & (middles < b)).astype(int)
            for wall in cam.walls if wall.side == side for a, b in wall.spans
        ) + np.zeros(len(middles), dtype=int)
        for side in (LEFT, RIGHT)
    }  # fmt: skip
    evidence = "counted between the angles where walls begin and end"
    for name, side in (("contacts_left", LEFT), ("contacts_right", RIGHT)):
        least = int(np.argmin(np.where(kept, counts[side], 1 << 30)))
        value = float(counts[side][least])
        kind = Kind(name, "1", largest=False, must=Bound(1.0))
        yield kind, Found(value, value, evidence, float(middles[least]))
    mean = float(((counts[LEFT] + counts[RIGHT]) * wide).sum() / FULL_TURN)
    yield Kind("contacts_mean", "1", largest=False), Found(mean, mean, evidence)
