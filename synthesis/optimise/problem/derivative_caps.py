"""The caps on the highest derivative of the laws: with them wider, tighter or left out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import inf

from synthesis.catalogue.limits import Limit
from synthesis.catalogue.limits.motion import DerivativeLimit
from synthesis.catalogue.motion import PlacedSegment
from synthesis.optimise.problem.problem import Problem

CAPPED = (3, 2)  # derivatives whose caps make the ideal laws switch, the highest first
SWIFT = 0.015
"""Of a law's angle: a swing of the acceleration that takes less hardly changes what a law can do,
while a bound that knows the jerk's cap takes knots as close as that."""


def highest_caps(problem: Problem) -> tuple[Limit, ...]:
    """The limits on the highest derivative that is limited all along free laws."""
    for order in CAPPED:
        found = tuple(limit for limit in problem.limits if caps_derivative(limit, order, problem))
        if found:
            return found
    return ()


def control_order(problem: Problem) -> int:
    """The derivative that switches in the ideal laws.

    The acceleration where rows bound it alone and nothing speaks of the jerk; else the jerk.
    """
    jerk, acceleration = CAPPED
    objectives = (problem.objective, *(cap.objective for cap in problem.objective_caps))
    rows = [row.orders for s in problem.free for row in problem.rows_on(s, 1.0)]
    weighs_jerk = any(each.energy_order() == jerk for each in objectives)
    if weighs_jerk or any(jerk in orders for orders in rows):
        return jerk
    return acceleration if (acceleration,) in rows else jerk


def without_highest_caps(problem: Problem) -> Problem | None:
    """The problem without the caps of the highest capped derivative; None if no lower has one."""
    caps = highest_caps(problem)
    remaining = replace(problem, limits=tuple(one for one in problem.limits if one not in caps))
    return remaining if caps and highest_caps(remaining) else None


def without_lower_caps(problem: Problem) -> Problem | None:
    """The problem without caps of derivatives lower than the highest capped one; None without any.

    These are limits that linear rows state in full: whether a cam keeps them its rows tell.
    """
    kept = highest_caps(problem)
    lower = [x for x in problem.limits if isinstance(x, DerivativeLimit) and x not in kept]
    remaining = tuple(limit for limit in problem.limits if limit not in lower)
    return replace(problem, limits=remaining) if kept and lower else None


def without_swift_caps(problem: Problem) -> Problem | None:
    """The problem without jerk caps under which every law changes its acceleration at once.

    None where there are none, or where the acceleration takes more than ``SWIFT`` of a law to swing
    from one end of its range to the other.
    """
    jerk, remaining = highest_caps(problem), without_highest_caps(problem)
    if remaining is None:
        return None
    acceleration = highest_caps(remaining)
    for segment in problem.free:
        highest, lower = (_cap(segment, caps, problem) for caps in (jerk, acceleration))
        if not 2.0 * lower < SWIFT * segment.angle * highest:
            return None
    return remaining


def _cap(segment: PlacedSegment, caps: Sequence[Limit], problem: Problem) -> float:
    """What caps of one derivative come to on a law, by the angle; ∞ where they leave it free."""
    rows = [row for limit in caps for row in limit.rows(segment, problem.machine)]
    return min((row.upper / max(map(abs, row.coefficients)) for row in rows), default=inf)


def with_tighter_caps(problem: Problem, share: float) -> Problem | None:
    """The problem with a share of the highest derivative's caps; None where it has none."""
    caps = highest_caps(problem)
    limits = [_tighter(one, share) if one in caps else one for one in problem.limits]
    return replace(problem, limits=tuple(limits)) if caps else None


def _tighter(limit: Limit, share: float) -> Limit:
    largest = {name: share * value for name, value in limit if name.startswith("max_") and value}
    return limit.model_copy(update=largest)


def caps_derivative(limit: Limit, order: int, problem: Problem) -> bool:
    """Whether all that a limit says on free laws is of one derivative, bounded all along."""
    rows = [row for s in problem.free for row in limit.rows(s, problem.machine)]
    return bool(rows) and all(
        row.interval is None
        and not any(row.size)
        and row.upper > 0.0
        and [k for k, factor in enumerate(row.coefficients) if factor] == [order]
        for row in rows
    )
