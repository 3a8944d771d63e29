"""Choose a shaper's free lengths for its requirements, or say why there are none."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Final

from synthesis.catalogue.fields import ends
from synthesis.design.design import Conflict, Proof, Relaxation, Status
from synthesis.errors import InputError, TimeBudgetExceeded
from synthesis.machines.linkages.shaper.answer import SixBarShaper
from synthesis.machines.linkages.shaper.design_space import (
    CLEAR,
    OBJECTIVES,
    SHORTEST_COUPLER,
    DesignSpace,
    ShaperObjective,
    quick_return_ratio_of,
)
from synthesis.machines.linkages.shaper.global_search import global_minimum
from synthesis.machines.linkages.shaper.spec import ShaperSpec
from synthesis.machines.linkages.shaper.turn_analysis import analyse_shaper, report_infeasible
from synthesis.units import rad_per_s

ROUNDING: Final = 1e-9  # relative: a value may be better than its bound by so much
SHARE: Final = 0.9  # of the tolerance; the rest is for the measured value
GAP: Final = 1e-3  # relative: of what would be needed
LONG_COUPLER: Final = 1e3  # longest guides: a longer coupler is no better
VALID_FOR: Final = (
    "all six-bar shapers with a rocking guide and these ranges, whose ram turns back where the "
    "guide does"
)
NOWHERE: Final = (1.0, 0.0)  # a span that holds nothing
CLOSED: Final = (
    "Closed form: S = 2 L r/a and Q = (π + 2β)/(π − 2β) with sin β = r/a. Proven. Each "
    "change was tried."
)


def size_shaper(spec: ShaperSpec, deadline: float | None = None) -> SixBarShaper:
    """The best shaper for a spec with free lengths.

    Raises:
        InputError: the ranges leave rotating guides only.
        TimeBudgetExceeded: before a shaper was found or excluded.
    """
    shortest, farthest = ends(spec.crank_mm)[0], ends(spec.pivot_distance_mm)[1]
    if shortest >= farthest:
        raise InputError(
            "/crank_mm", shortest,
            f"Every allowed crank is longer than the pivot distance (at most "
            f"{farthest:g} mm), so that the guide makes full turns: such shapers are analysed, not "
            "sized.", f"Allow cranks below {farthest:g} mm, or give every length.",
        )  # fmt: skip
    space = DesignSpace.of(spec)
    low, high = space.span()
    if low > high:
        return report_infeasible(spec, _explain_closed_form(spec, space, deadline))
    objective = OBJECTIVES[spec.objective.kind]
    found = global_minimum(space, objective, SHARE * spec.tolerance, deadline)
    lengths = None if found.u is None else space.lengths_at(found.u)
    if lengths is None:
        proven = math.isinf(found.bound)
        if not proven and deadline is not None and time.monotonic() >= deadline:
            raise TimeBudgetExceeded(spec.time_budget_s or 0.0)
        return report_infeasible(spec, _explain_coupler(spec, space, proven, deadline))
    bound = objective.to_wire(found.bound, rad_per_s(spec.speed_rpm))
    return _certified(analyse_shaper(spec, lengths), objective, bound)


def _certified(answer: SixBarShaper, objective: ShaperObjective, bound: float) -> SixBarShaper:
    """The answer with the objective as measured on the finished linkage, and its bound."""
    assert answer.least_transmission_angle_deg is not None  # there is a linkage to measure
    peaks = next(one for one in answer.extremes if one.quantity == "ram_acceleration")
    links = ("crank_mm", "guide_mm", "coupler_mm", "pivot_distance_mm")
    value = {
        "longest_link_mm": max(answer.dimensions[name] for name in links),
        "least_transmission_angle_deg": answer.least_transmission_angle_deg,
        "ram_acceleration_mm_per_s2": max(abs(peaks.largest.value), abs(peaks.smallest.value)),
    }[objective.name]
    if abs(value - bound) <= ROUNDING * abs(value):  # rounding may make it better than the bound
        bound = value
    gap = abs(value - bound) / abs(value)
    proof = Proof(
        objective=objective.name, value=value, lower_bound=bound, bound_valid_for=VALID_FOR, gap=gap
    )
    status: Status = "optimal" if gap <= answer.spec.tolerance else "feasible"
    if not all(limit.holds for limit in answer.limits):
        status = "infeasible"
    return answer.model_copy(update={"certificate": proof, "status": status})


def _explain_closed_form(spec: ShaperSpec, space: DesignSpace, deadline: float | None) -> Conflict:
    """Why stroke, ratio and lengths contradict each other; each relaxed alone."""
    # The two fields whose ranges of s = r/a are disjoint.
    lowest = max(space.sines, key=lambda name: space.sines[name][0])
    highest = min(space.sines, key=lambda name: space.sines[name][1])
    changes = list(_closed_form_relaxations(spec, space, deadline))
    return Conflict(limits=sorted({lowest, highest}), relaxations=changes, evidence=CLOSED)


def _closed_form_relaxations(
    spec: ShaperSpec, space: DesignSpace, deadline: float | None
) -> Iterator[Relaxation]:
    """What stroke, ratio and each length would have to be with the others as they are.

    From s = r/a, S = 2 L s and the ratio's own formula, over the range of s that the others leave.
    """
    stroke, low, high = space.stroke, *space.span("quick_return_ratio")
    guide, crank, pivots = (
        space.lengths[name] for name in ("guide_mm", "crank_mm", "pivot_distance_mm")
    )
    ratios = (low, high) if low > high else tuple(map(quick_return_ratio_of, (low, high)))
    possible = [("quick_return_ratio", "", (low, high), ratios)]
    low, high = s = space.span("stroke_mm")
    possible += [
        ("stroke_mm", "mm", s, (2.0 * guide[0] * low, 2.0 * guide[1] * high)),
        ("guide_mm", "mm", s, (0.5 * stroke[0] / high, 0.5 * stroke[1] / low)),
    ]
    low, high = s = space.span("crank_mm")
    possible += [
        ("crank_mm", "mm", s, (low * pivots[0], high * pivots[1])),
        ("pivot_distance_mm", "mm", s, (crank[0] / high, crank[1] / low)),
    ]
    for name, unit, (low, high), span in possible:
        first, last = ends(getattr(spec, name))
        least, most = span if low <= high else NOWHERE
        requested, needed = (last, least) if last < least else (first, most)
        helps, note = least <= most, "Changing this alone cannot help."
        if helps:
            # Stroke, ratio and lengths agree then; a search says whether some coupler reaches.
            wider = {name: {"min": min(first, needed), "max": max(last, needed)}}
            space = DesignSpace.of(ShaperSpec.model_validate(spec.model_dump() | wider))
            helps = global_minimum(space, SHORTEST_COUPLER, 1.0, deadline).u is not None
            note = f"With {needed:.6g} stroke, ratio and lengths agree, but no coupler reaches."
        yield Relaxation(
            limit=name, field=f"/{name}", unit=unit, requested=requested,
            needed=needed if helps else None, note="" if helps else note,
        )  # fmt: skip


def _explain_coupler(
    spec: ShaperSpec, space: DesignSpace, proven: bool, deadline: float | None
) -> Conflict:
    """Why no coupler serves: the best transmission angle, and the shortest coupler that would."""
    relaxations = []
    requested = spec.least_transmission_angle_deg
    if requested is not None:
        level = OBJECTIVES["transmission_angle"]
        found = global_minimum(replace(space, steep=1.0 - CLEAR), level, GAP, deadline)
        needed = None if found.u is None else level.to_wire(found.value, 1.0)
        note = (
            "No coupler in its range reaches the ram's line everywhere." if found.u is None else
            f"Proven: none has more than {level.to_wire(found.bound, 1.0):.6g}°."
        )  # fmt: skip
        relaxations.append(Relaxation(
            limit="least_transmission_angle_deg", field="/least_transmission_angle_deg",
            unit="deg", requested=requested, needed=needed, note=note,
        ))  # fmt: skip
    shortest, longest = space.lengths["coupler_mm"]
    range_ = (shortest, LONG_COUPLER * space.lengths["guide_mm"][1])
    longer = replace(space, lengths={**space.lengths, "coupler_mm": range_})
    found = global_minimum(longer, SHORTEST_COUPLER, GAP, deadline)
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
