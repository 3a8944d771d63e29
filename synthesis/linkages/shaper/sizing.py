"""Lengths of a shaper chosen for its wishes, or why there are none and what would help."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Final

from synthesis.design import Conflict, Proof, Relaxation, Status
from synthesis.errors import InputError, TimeBudgetExceeded
from synthesis.linkages.shaper.family import Family, Span, ratio_of
from synthesis.linkages.shaper.found import SixBarShaper
from synthesis.linkages.shaper.goals import GOALS, SHORTEST_COUPLER, Goal
from synthesis.linkages.shaper.search import best
from synthesis.linkages.shaper.spec import ShaperSpec
from synthesis.linkages.shaper.telling import nothing_fits, told
from synthesis.ranges import ends
from synthesis.units import rad_per_s

ROUND: Final = 1e-9
SHARE: Final = 0.9  # of the tolerance: the rest is left for measuring
FAR: Final = 1e3  # of the longest guide: a coupler as long as that is as good as any
BOUND_OVER: Final = (
    "all six-bar shapers with a rocking guide and these ranges, whose ram turns back where the "
    "guide does"
)
CLOSED: Final = (
    "Closed form: S = 2 L r/a and Q = (π + 2β)/(π − 2β) with sin β = r/a. Proven. Each "
    "change was tried."
)
NOWHERE: Final = (1.0, 0.0)  # a span that holds nothing


def sized(spec: ShaperSpec, deadline: float | None = None) -> SixBarShaper:
    """The best shaper for a spec with free lengths.

    Raises:
        InputError: only guides that turn all the way round are left.
        TimeBudgetExceeded: before a shaper was found or excluded.
    """
    _rocks(spec)
    family = Family.of(spec)
    low, high = family.span()
    if low > high:
        return nothing_fits(spec, _apart(spec, family, deadline))
    goal = GOALS[spec.objective.kind]
    found = best(family, goal, SHARE * spec.tolerance, deadline)
    lengths = None if found.u is None else family.lengths_at(found.u)
    if lengths is None:
        proven = math.isinf(found.bound)
        if not proven and deadline is not None and time.monotonic() >= deadline:
            raise TimeBudgetExceeded(spec.time_budget_s or 0.0)
        return nothing_fits(spec, _too_steep(spec, family, proven, deadline))
    bound = goal.wire(found.bound, rad_per_s(spec.speed_rpm))
    return _judged(told(spec, lengths), goal, bound)


def _rocks(spec: ShaperSpec) -> None:
    shortest, farthest = ends(spec.crank_mm)[0], ends(spec.pivot_distance_mm)[1]
    if shortest >= farthest:
        raise InputError(
            "/crank_mm", shortest, f"Every crank here is longer than the pivots are apart (at most "
            f"{farthest:g} mm), so the guide turns all the way round: such shapers are analysed, "
            "not sized.", f"Allow cranks below {farthest:g} mm, or give every length.",
        )  # fmt: skip


def _judged(answer: SixBarShaper, goal: Goal, bound: float) -> SixBarShaper:
    """The answer with the goal's value as measured on the finished linkage, and its bound."""
    value = _measured(answer)[goal.name]
    if abs(value - bound) <= ROUND * abs(value):  # rounding may make it better than the bound
        bound = value
    gap = abs(value - bound) / abs(value)
    proof = Proof(
        objective=goal.name, value=value, lower_bound=bound, bound_over=BOUND_OVER, gap=gap
    )
    kept = all(limit.holds for limit in answer.limits)
    reached: Status = "optimal" if gap <= answer.spec.tolerance else "feasible"
    status: Status = reached if kept else "infeasible"
    return answer.model_copy(update={"certificate": proof, "status": status})


def _measured(answer: SixBarShaper) -> dict[str, float]:
    """Values of all goals, measured."""
    peaks = {one.quantity: one for one in answer.extremes}["ram_acceleration"]
    assert answer.least_transmission_angle_deg is not None  # there is a linkage to measure
    links = [answer.dimensions[name] for name in
             ("crank_mm", "guide_mm", "coupler_mm", "pivot_distance_mm")]  # fmt: skip
    return {
        "longest_link_mm": max(links),
        "least_transmission_angle_deg": answer.least_transmission_angle_deg,
        "ram_acceleration_mm_per_s2": max(abs(peaks.largest.value), abs(peaks.smallest.value)),
    }


def _relaxation(name: str, unit: str, asked: Span, able: Span, note: str = "") -> Relaxation:
    """The least change of a wish that brings it into reach; none where nothing does."""
    near, needed = (asked[1], able[0]) if asked[1] < able[0] else (asked[0], able[1])
    useless = able[0] > able[1]
    return Relaxation(
        limit=name, field=f"/{name}", unit=unit, asked=near, needed=None if useless else needed,
        note=note or ("Alone it cannot help." if useless else ""),
    )  # fmt: skip


def _tried(spec: ShaperSpec, change: Relaxation, deadline: float | None) -> Relaxation:
    """The same, or no change that would help where the coupler stands against it too."""
    if change.needed is None:
        return change
    low, high = ends(getattr(spec, change.limit))
    span = {"min": min(low, change.needed), "max": max(high, change.needed)}
    asked = spec.model_dump() | {change.limit: span}
    family = Family.of(ShaperSpec.model_validate(asked))
    if best(family, SHORTEST_COUPLER, 1.0, deadline).u is not None:
        return change
    note = f"With {change.needed:.6g} stroke, ratio and lengths fit, but then no coupler does."
    return change.model_copy(update={"needed": None, "note": note})


def _apart(spec: ShaperSpec, family: Family, deadline: float | None) -> Conflict:
    """Why stroke, ratio and lengths exclude each other: each alone, the others kept."""
    return Conflict(
        limits=_sources(family),
        relaxations=[_tried(spec, each, deadline) for each in _wishes(spec, family)],
        evidence=CLOSED,
    )


def _sources(family: Family) -> list[str]:
    """The two sources of s = r/a whose ranges lie apart."""
    lowest = max(family.sines, key=lambda name: family.sines[name][0])
    highest = min(family.sines, key=lambda name: family.sines[name][1])
    return sorted({lowest, highest})


def _wishes(spec: ShaperSpec, family: Family) -> Iterator[Relaxation]:
    """What stroke, ratio and each length would have to be, the others kept."""
    spans, stroke = family.lengths, family.stroke
    guide, crank, apart = (spans[name] for name in ("guide_mm", "crank_mm", "pivot_distance_mm"))
    low, high = family.span("quick_return_ratio")
    ratios = (ratio_of(low), ratio_of(high)) if low <= high else NOWHERE
    yield _relaxation("quick_return_ratio", "", ends(spec.quick_return_ratio), ratios)
    s = family.span("stroke_mm")
    yield _relaxation("stroke_mm", "mm", stroke, _times(s, (2.0 * guide[0], 2.0 * guide[1])))
    yield _relaxation("guide_mm", "mm", guide, _over((0.5 * stroke[0], 0.5 * stroke[1]), s))
    s = family.span("crank_mm")
    yield _relaxation("crank_mm", "mm", crank, _times(s, apart))
    yield _relaxation("pivot_distance_mm", "mm", apart, _over(crank, s))


def _times(s: Span, length: Span) -> Span:
    return (s[0] * length[0], s[1] * length[1]) if s[0] <= s[1] else NOWHERE


def _over(length: Span, s: Span) -> Span:
    return (length[0] / s[1], length[1] / s[0]) if s[0] <= s[1] else NOWHERE


def _too_steep(spec: ShaperSpec, family: Family, proven: bool, deadline: float | None) -> Conflict:
    """Why no coupler serves: how level it can lie at best, and how long it would have to be."""
    relaxations = []
    asked = spec.least_transmission_angle_deg
    if asked is not None:
        level = GOALS["transmission_angle"]
        found = best(
            replace(family, steep=Family.of(spec, 1.0 - 1e-9).steep), level, 1e-3, deadline
        )
        needed = None if found.u is None else level.wire(found.value, 1.0)
        note = (
            "No coupler in its range reaches across at all." if found.u is None else
            f"Proven: none has more than {level.wire(found.bound, 1.0):.6g}°."
        )  # fmt: skip
        relaxations.append(Relaxation(
            limit="least_transmission_angle_deg", field="/least_transmission_angle_deg",
            unit="deg", asked=asked, needed=needed, note=note,
        ))  # fmt: skip
    shortest, longest = family.lengths["coupler_mm"]
    longer = {**family.lengths, "coupler_mm": (shortest, FAR * family.lengths["guide_mm"][1])}
    found = best(replace(family, lengths=longer), SHORTEST_COUPLER, 1e-3, deadline)
    needed = None if found.u is None else found.value
    note = f"Proven: none shorter than {found.bound:.6g} mm serves." if needed else ""
    relaxations.append(Relaxation(
        limit="coupler_mm", field="/coupler_mm", unit="mm", asked=longest, needed=needed,
        note=note,
    ))  # fmt: skip
    limits = [each.limit for each in relaxations]
    told = f"No box of the ranges can keep {' and '.join(limits)}: excluded by bounds. Proven."
    if not proven:
        told = f"No lengths were found that keep {' and '.join(limits)}. Not proven."
    return Conflict(limits=limits, relaxations=relaxations, evidence=told)
