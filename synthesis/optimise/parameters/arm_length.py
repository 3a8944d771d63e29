"""The length of a machine that is left free: all over its range, then closed in on.

What limits say of the size changes with it, and not in a convex way, so each length costs a whole
search. A given law's size is found exactly there, so that the length can be too; free laws leave
some noise. What else can be pinned, the pivot's distance, is often best at an end of its range.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, log

import numpy as np
from scipy.optimize import minimize_scalar

from synthesis.numerics.piecewise import Array
from synthesis.numerics.polytope import BundlePoint
from synthesis.optimise.parameters.value_function import ValueFunction, describe_parameters
from synthesis.optimise.recovery.candidate import Candidate

ROUGH, FINE = 2e-2, 4e-3  # tolerances of whole searches with free laws, first and last
FEW, MANY = 8, 33  # lengths tried first, evenly in their logarithm
ROUGHLY, CLOSELY = 5e-3, 1e-7  # relative: how closely the best one is sought
NOTHING = 1e30  # worth of a length at which nothing fits
NEAR = 0.1  # of a value: so near to an end of its range the end is tried too
ASIDE = 0.02  # of the way from an end of the range to the next length tried


@dataclass(frozen=True, eq=False)
class LengthTrial:
    """A point that was tried, what it is worth and the cam that it gave, if any."""

    found: BundlePoint
    cam: Candidate | None

    @property
    def value(self) -> float:
        """On the wire; more than any cam's where there is none."""
        return self.found.value


def search_length(worth: ValueFunction, start: Array, position: int) -> BundlePoint | None:
    """The best point along one number's range, the others as they are; None where nothing fits."""
    for count in (FEW, MANY):
        spread = worth.free_parameters.points_along(start, position, count)
        tried = [_at(worth, u, ROUGH) for u in spread]
        best = min(tried, key=_value)
        if best.cam is not None:
            break
    else:
        return None
    if best.cam.laws:
        return min([best, *_closer(worth, tried, position, ROUGHLY)], key=_value).found
    every = [best]
    for pin in _pins(best.cam):
        spread = worth.free_parameters.points_along(start, position, MANY)
        tried = [_at(worth, u, ROUGH, pin) for u in spread]
        every += [*tried, *_closer(worth, tried, position, CLOSELY, pin)]
    return min(every, key=_value).found


def _at(worth: ValueFunction, u: Array, tolerance: float, pin: float | None = None) -> LengthTrial:
    cam = worth.solved(u, tolerance, pin)
    return LengthTrial(
        BundlePoint(u, NOTHING if cam is None else describe_parameters(cam.problem, cam.value)), cam
    )


def _value(tried: LengthTrial) -> float:
    return tried.value


def _pins(cam: Candidate) -> list[float | None]:
    """Values at which to hold what can be pinned: the cam's, and the ends of its range."""
    pinning = cam.problem.machine.follower.fixable_dimension()
    if pinning is None:
        return [None]
    at = min(max(pinning.value_in(cam.size), pinning.low), pinning.high)
    ends = (end for end in (pinning.low, pinning.high) if abs(end - at) <= NEAR * at and end != at)
    return [at, *ends]


def _closer(
    worth: ValueFunction,
    tried: list[LengthTrial],
    position: int,
    close: float,
    pin: float | None = None,
) -> list[LengthTrial]:
    """Points between the neighbours of the best one, to a relative distance."""
    parameters, more, last = worth.free_parameters, list[LengthTrial](), len(tried) - 1
    at = int(np.argmin([one.value for one in tried]))
    if tried[at].cam is None:
        return []
    logarithms = [log(parameters.values_at(one.found.u)[position]) for one in tried]

    def value(logarithm: float) -> float:
        u = parameters.with_value(tried[at].found.u, position, exp(logarithm))
        more.append(_at(worth, u, FINE, pin))
        return more[-1].value

    low, high = logarithms[max(at - 1, 0)], logarithms[min(at + 1, last)]
    if at in (0, last):
        inwards = (high if at == 0 else low) - logarithms[at]
        if value(logarithms[at] + ASIDE * inwards) >= tried[at].value:
            return more  # the end of the range is best
    minimize_scalar(value, bounds=(low, high), method="bounded", options={"xatol": close})
    return more
