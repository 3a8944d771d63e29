"""The caps on the highest derivative of the laws: with them wider, tighter or left out."""

from __future__ import annotations

from dataclasses import replace

from synthesis.catalogue.limits import Limit
from synthesis.optimise.problem.problem import Problem

CAPPED = (3, 2)  # derivatives whose caps make the ideal laws switch, the highest first


def highest_caps(problem: Problem) -> tuple[Limit, ...]:
    """The limits on the highest derivative that is limited all along free laws."""
    for order in CAPPED:
        found = tuple(limit for limit in problem.limits if caps_derivative(limit, order, problem))
        if found:
            return found
    return ()


def without_highest_caps(problem: Problem) -> Problem | None:
    """The problem without the caps of the highest capped derivative; None if no lower has one."""
    caps = highest_caps(problem)
    remaining = replace(problem, limits=tuple(one for one in problem.limits if one not in caps))
    return remaining if caps and highest_caps(remaining) else None


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
