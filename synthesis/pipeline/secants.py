"""Secants of the excess of a question over one of its numbers: its slope, and its zero."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping

from scipy.optimize import brentq

WIDENING = 4.0  # factor from one distance to the next at which a value is tried for a proof
STEPS_BACK = 4  # from a point that proves nothing


def slope_of(excesses: Mapping[float, float], noise: float) -> float:
    """By how much the excess falls per unit, near its zero; 0 where that is not known.

    Args:
        excesses: by the values tried. noise: those that differ by no more say nothing of the slope,
            if others do.
    """
    if len(excesses) < 2:
        return 0.0
    (value, excess), *others = sorted(excesses.items(), key=lambda pair: abs(pair[1]))
    # The search for a cam that is small enough ends with the first: others' excesses say more.
    others.sort(key=lambda pair: (pair[1] < 0.0, abs(pair[1])))
    apart = (pair for pair in others if abs(pair[1] - excess) > noise)
    farthest = max(others, key=lambda pair: pair[1])
    other, further = next(apart, farthest if noise else others[0])
    return (further - excess) / (value - other)


def zero_of(
    excesses: Mapping[float, float], failed: Collection[float], good: float
) -> float | None:
    """Where the secant of the two least excesses of questions comes to zero.

    With one alone, that to the excess of the cam nearest to it: the search for it ended as soon as
    it was small enough, so the zero lies no nearer to that cam.

    Args:
        excesses: by the values tried. failed: values of questions whose excess is the least.
        good: the value of that cam.
    """
    known = [(excesses[value], value) for value in failed if value in excesses]
    known.sort(key=lambda pair: abs(pair[0]))
    if len(known) == 1 and good in excesses:
        known.append((excesses[good], good))
    if len(known) < 2 or known[0][0] == known[1][0]:
        return None
    (excess, near), (further, far) = known[:2]
    return near - excess * (far - near) / (further - excess)


def approach_zero(
    falling: Callable[[float], float], at: float, expected: float, step: float
) -> bool:
    """Evaluate a falling function ever nearer to its zero, on the side where it is positive.

    A bound by fixed multipliers is such a function, known best at one point. Where a limit binds
    along an arc it has a kink there: from a point where it is positive it leads nearly to the zero
    that the slope says; from one where it is not, a few steps back show whether it turns positive.

    Args:
        at: the point. expected: where its slope says that the zero is. step: the accuracy.

    Returns:
        whether the function was positive anywhere. Negative arguments are not tried.
    """
    low, high = min(at, expected), max(at, expected)
    if falling(at) <= 0.0:
        steps = (low - step * WIDENING**k for k in range(STEPS_BACK))
        tried = (one for one in steps if one > 0.0)
        low, high = next((one for one in tried if falling(one) > 0.0), 0.0), at
    if low <= 0.0:
        return False
    if falling(high) <= 0.0:
        root = float(brentq(falling, low, high, xtol=step))
        falling(root - step)
    return True
