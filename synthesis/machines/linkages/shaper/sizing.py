"""Choose a shaper's free lengths for its requirements, or say why there are none."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Final

from synthesis.catalogue.ranges import ends
from synthesis.design.design import Conflict, Proof, Relaxation, Status
from synthesis.errors import InputError, TimeBudgetExceeded
from synthesis.machines.linkages.shaper.answer import SixBarShaper
from synthesis.machines.linkages.shaper.design_space import (
    OBJECTIVES,
    SHORTEST_COUPLER,
    DesignSpace,
    ShaperObjective,
    Span,
    quick_return_ratio_of,
)
from synthesis.machines.linkages.shaper.global_search import global_minimum
from synthesis.machines.linkages.shaper.spec import ShaperSpec
from synthesis.machines.linkages.shaper.turn_analysis import analyse_shaper, report_infeasible
from synthesis.units import rad_per_s

ROUNDING: Final = 1e-9  # relative: a value may be better than its bound by so much
SHARE: Final = 0.9  # of the tolerance; the rest is for the measured value
LONG_COUPLER: Final = 1e3  # longest guides: a longer coupler is no better
VALID_FOR: Final = (
    "all six-bar shapers with a rocking guide and these ranges, whose ram turns back where the "
    "guide does"
)
CLOSED: Final = (
    "Closed form: S = 2 L r/a and Q = (π + 2β)/(π − 2β) with sin β = r/a. Proven. Each "
    "change was tried."
)
NOWHERE: Final = (1.0, 0.0)  # a span that holds nothing


def size_shaper(spec: ShaperSpec, deadline: float | None = None) -> SixBarShaper:
    """The best shaper for a spec with free lengths.

    Raises:
        InputError: the ranges leave rotating guides only.
        TimeBudgetExceeded: before a shaper was found or excluded.
    """
    _check_rocking(spec)
    family = DesignSpace.of(spec)
    low, high = family.span()
    if low > high:
        return report_infeasible(spec, _explain_closed_form(spec, family, deadline))
    goal = OBJECTIVES[spec.objective.kind]
    found = global_minimum(family, goal, SHARE * spec.tolerance, deadline)
    lengths = None if found.u is None else family.lengths_at(found.u)
    if lengths is None:
        proven = math.isinf(found.bound)
        if not proven and deadline is not None and time.monotonic() >= deadline:
            raise TimeBudgetExceeded(spec.time_budget_s or 0.0)
        return report_infeasible(spec, _explain_coupler(spec, family, proven, deadline))
    bound = goal.to_wire(found.bound, rad_per_s(spec.speed_rpm))
    return _certified(analyse_shaper(spec, lengths), goal, bound)


def _check_rocking(spec: ShaperSpec) -> None:
    shortest, farthest = ends(spec.crank_mm)[0], ends(spec.pivot_distance_mm)[1]
    if shortest >= farthest:
        raise InputError(
            "/crank_mm", shortest,
            f"Every allowed crank is longer than the pivot distance (at most "
            f"{farthest:g} mm), so that the guide makes full turns: such shapers are analysed, not "
            "sized.", f"Allow cranks below {farthest:g} mm, or give every length.",
        )  # fmt: skip


def _certified(answer: SixBarShaper, goal: ShaperObjective, bound: float) -> SixBarShaper:
    """The answer with the objective as measured on the finished linkage, and its bound."""
    assert answer.least_transmission_angle_deg is not None  # there is a linkage to measure
    peaks = next(one for one in answer.extremes if one.quantity == "ram_acceleration")
    links = ("crank_mm", "guide_mm", "coupler_mm", "pivot_distance_mm")
    value = {
        "longest_link_mm": max(answer.dimensions[name] for name in links),
        "least_transmission_angle_deg": answer.least_transmission_angle_deg,
        "ram_acceleration_mm_per_s2": max(abs(peaks.largest.value), abs(peaks.smallest.value)),
    }[goal.name]
    if abs(value - bound) <= ROUNDING * abs(value):  # rounding may make it better than the bound
        bound = value
    gap = abs(value - bound) / abs(value)
    proof = Proof(
        objective=goal.name, value=value, lower_bound=bound, bound_valid_for=VALID_FOR, gap=gap
    )
    status: Status = "optimal" if gap <= answer.spec.tolerance else "feasible"
    if not all(limit.holds for limit in answer.limits):
        status = "infeasible"
    return answer.model_copy(update={"certificate": proof, "status": status})


def _relaxation(name: str, unit: str, asked: Span, able: Span, note: str = "") -> Relaxation:
    """The least change of a requirement that makes it feasible; none where nothing does."""
    near, needed = (asked[1], able[0]) if asked[1] < able[0] else (asked[0], able[1])
    useless = able[0] > able[1]
    return Relaxation(
        limit=name, field=f"/{name}", unit=unit, requested=near, needed=None if useless else needed,
        note=note or ("Changing this alone cannot help." if useless else ""),
    )  # fmt: skip


def _checked(spec: ShaperSpec, change: Relaxation, deadline: float | None) -> Relaxation:
    """The relaxation if some coupler serves then; otherwise one without a needed value."""
    if change.needed is None:
        return change
    low, high = ends(getattr(spec, change.limit))
    span = {"min": min(low, change.needed), "max": max(high, change.needed)}
    asked = spec.model_dump() | {change.limit: span}
    family = DesignSpace.of(ShaperSpec.model_validate(asked))
    if global_minimum(family, SHORTEST_COUPLER, 1.0, deadline).u is not None:
        return change
    note = f"With {change.needed:.6g} stroke, ratio and lengths agree, but no coupler reaches."
    return change.model_copy(update={"needed": None, "note": note})


def _explain_closed_form(spec: ShaperSpec, family: DesignSpace, deadline: float | None) -> Conflict:
    """Why stroke, ratio and lengths contradict each other; each relaxed alone."""
    # The two fields whose ranges of s = r/a are disjoint.
    lowest = max(family.sines, key=lambda name: family.sines[name][0])
    highest = min(family.sines, key=lambda name: family.sines[name][1])
    changes = [_checked(spec, each, deadline) for each in _closed_form_relaxations(spec, family)]
    return Conflict(limits=sorted({lowest, highest}), relaxations=changes, evidence=CLOSED)


def _closed_form_relaxations(spec: ShaperSpec, family: DesignSpace) -> Iterator[Relaxation]:
    """What stroke, ratio and each length would have to be with the others as they are."""
    spans, stroke = family.lengths, family.stroke
    guide, crank, apart = (spans[name] for name in ("guide_mm", "crank_mm", "pivot_distance_mm"))
    low, high = family.span("quick_return_ratio")
    ratios = (quick_return_ratio_of(low), quick_return_ratio_of(high)) if low <= high else NOWHERE
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


def _explain_coupler(
    spec: ShaperSpec, family: DesignSpace, proven: bool, deadline: float | None
) -> Conflict:
    """Why no coupler serves: the best transmission angle, and the shortest coupler that would."""
    relaxations = []
    asked = spec.least_transmission_angle_deg
    if asked is not None:
        level = OBJECTIVES["transmission_angle"]
        found = global_minimum(
            replace(family, steep=DesignSpace.of(spec, 1.0 - 1e-9).steep), level, 1e-3, deadline
        )
        needed = None if found.u is None else level.to_wire(found.value, 1.0)
        note = (
            "No coupler in its range reaches the ram's line everywhere." if found.u is None else
            f"Proven: none has more than {level.to_wire(found.bound, 1.0):.6g}°."
        )  # fmt: skip
        relaxations.append(Relaxation(
            limit="least_transmission_angle_deg", field="/least_transmission_angle_deg",
            unit="deg", requested=asked, needed=needed, note=note,
        ))  # fmt: skip
    shortest, longest = family.lengths["coupler_mm"]
    longer = {
        **family.lengths,
        "coupler_mm": (shortest, LONG_COUPLER * family.lengths["guide_mm"][1]),
    }
    found = global_minimum(replace(family, lengths=longer), SHORTEST_COUPLER, 1e-3, deadline)
    needed = None if found.u is None else found.value
    note = f"Proven: no coupler shorter than {found.bound:.6g} mm serves." if needed else ""
    relaxations.append(Relaxation(
        limit="coupler_mm", field="/coupler_mm", unit="mm", requested=longest, needed=needed,
        note=note,
    ))  # fmt: skip
    limits = [each.limit for each in relaxations]
    evidence = (
        f"No lengths within the ranges can keep {' and '.join(limits)}: excluded by branch and "
        "bound. Proven."
    )
    if not proven:
        evidence = f"No lengths were found that keep {' and '.join(limits)}. Not proven."
    return Conflict(limits=limits, relaxations=relaxations, evidence=evidence)
