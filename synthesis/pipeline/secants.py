"""Secants of the excess of a question over one of its numbers: its slope, and its zero."""

from __future__ import annotations

from collections.abc import Collection, Mapping


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
