"""Why nothing fits, where limits are curved: found by leaving them out and trying again.

The elastic cone program prices rows that hold everywhere; a curved limit has none. So whole
searches are the oracle: a limit belongs to the conflict if a cam was found without it but none
with it. That none exists is claimed only where it is proven: with given laws, by half-planes that
have no common point, with free ones, by a relaxation that has none.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from math import inf, isfinite
from typing import Any

from synthesis.catalogue.followers import Follower
from synthesis.catalogue.limits import Limit
from synthesis.catalogue.objectives.base_radius import BaseRadius
from synthesis.catalogue.ranges import ends, without_end
from synthesis.design.design import Conflict, Relaxation
from synthesis.numerics import clock
from synthesis.optimise.driver import optimise
from synthesis.optimise.infeasibility.given_motion import given_motion_conflicts
from synthesis.optimise.infeasibility.relaxable import relaxable_limits
from synthesis.optimise.problem.problem import formulate_problem
from synthesis.optimise.state.solve_state import SolveState
from synthesis.spec.design_spec import DesignSpec

ROUGH = 0.05  # tolerance: whether there is a cam is asked, not which is best
HALVINGS = 14
ACCURATE = 1e-4  # relative: bracket of a limit's needed value
CEILING = {"deg": 89.9}
LATE = "the time budget ended before this was known"
FOUND = "a cam was found with this value; that it is the least is not proven"
ELSEWHERE = "a cam was found with this value; nearer ones were not looked for"
REFUSED = "a cam was found that keeps all limits, but it could not be certified"
ALONE = "relaxing this limit alone was not seen to help"


@dataclass(frozen=True)
class _Part:
    """One number of the spec that may be in the way.

    Attributes:
        field: JSON path. name, words, unit, asked: as told.
        owner: position among the limits, None for a dimension. attribute: its field there.
    """

    field: str
    name: str
    words: str
    unit: str
    requested: float
    owner: int | None
    attribute: str


def diagnose_by_search(spec: DesignSpec, deadline: float = inf) -> Conflict:
    """Why nothing fits, and what was seen to help.

    Args:
        spec: what was asked.
        deadline: ``time.monotonic()`` after which nothing more is tried.
    """
    alone_broken = _by_given_laws(spec)
    if alone_broken is not None:
        return alone_broken
    parts = list(_parts(spec))
    whole = _tried(spec, (), deadline)
    if whole.incumbent is not None:
        return Conflict(limits=[], relaxations=[], evidence=REFUSED)
    kept, proven, late = _irreducible(spec, parts, whole, deadline)
    alone = {
        part: _tried(spec, {part}, deadline)
        for part in parts
        if part in kept and clock.now() < deadline
    }
    relaxations = [
        _relaxation(spec, part, alone[part], deadline) for part in parts if part in alone
    ]
    named = [part for part in parts if part in kept]
    return Conflict(
        limits=[part.words for part in named],
        relaxations=relaxations,
        evidence=_evidence(proven, late),
    )


def _irreducible(
    spec: DesignSpec, parts: list[_Part], whole: SolveState, deadline: float
) -> tuple[set[_Part], SolveState, bool]:
    """Parts that do not fit together, the search that showed it, and whether time ended first.

    ``whole``: the search with all of them.
    """
    kept, shown = set(parts), whole
    for part in parts:
        if clock.now() >= deadline:
            return kept, shown, True
        tried = _tried(spec, set(parts) - (kept - {part}), deadline)
        if tried.incumbent is None and not tried.infeasible and clock.now() >= deadline:
            return kept, shown, True  # it might have found a cam
        if tried.incumbent is None:
            kept.discard(part)  # without it the others still do not fit
            shown = tried
    return kept, shown, False


def _by_given_laws(spec: DesignSpec) -> Conflict | None:
    """Limits that a given law breaks whatever the size; None where there are none."""
    problem = formulate_problem(spec, BaseRadius())
    parts = relaxable_limits(problem, len(spec.limits))
    found = given_motion_conflicts(parts, problem)
    if not found:
        return None
    return Conflict(
        limits=[parts[k].words for k in found],
        relaxations=[
            Relaxation(
                limit=parts[k].name, field=member.field, unit=parts[k].unit,
                requested=member.requested, needed=why.value, note=why.note,
            )
            for k, why in found.items()
            for member in parts[k].members
        ],
        evidence="; ".join(f"{parts[k].words}: {why.note}" for k, why in found.items()),
    )  # fmt: skip


def _evidence(proven: SolveState, late: bool) -> str:
    """What is known of the limits named."""
    kinds = "no size fits the given laws" if not proven.problem.free else (
        "no cam and splines on the knots tried fit"
    )  # fmt: skip
    searched = (
        proven.problem.machine.follower.fixable_dimension() is not None
    )  # of its values, only some
    known = (
        f"{kinds}, proven for these limits"
        if proven.infeasible and proven.relaxed is None and not searched
        else "no cam was found that keeps these limits; that there is none is not proven"
    )
    if late:
        return f"{known}; {LATE}"
    return f"{known}; of those named alone, leaving out any one, a cam was found"


def _parts(spec: DesignSpec) -> Iterator[_Part]:
    machine, segments = spec.machine(), spec.placed_segments()
    for position, limit in enumerate(spec.limits):
        for claim in limit.claims(segments, machine):
            attribute = claim.field.rpartition("/")[2]
            asked = float(getattr(limit, attribute))
            least = claim.upper is None or attribute.startswith("min_")
            sign = "≥" if least else "≤"
            words = f"{claim.limit.replace('_', ' ')} {sign} {asked:.6g} {claim.unit}"
            field = f"limits/{position}/{attribute}"
            yield _Part(field, claim.limit, words, claim.unit, asked, position, attribute)
    given = {"base_radius_mm": ("", spec.base_radius_mm)}
    given |= {
        name: ("follower/", value) for name, value in spec.follower.adjustable_dimensions().items()
    }
    for name, (prefix, value) in given.items():
        low, high = ends(value)
        for sign, end in (("=", low),) if low == high else (("≥", low), ("≤", high)):
            tail = {"=": "", "≥": "/min", "≤": "/max"}[sign]
            if isfinite(end) and not (prefix and _measures(spec.follower, name, tail)):
                title, _, unit = name.rpartition("_")
                words = f"{title.replace('_', ' ')} {sign} {end:.6g} {unit}"
                yield _Part(prefix + name + tail, title, words, unit, end, None, name)


def _measures(follower: Follower, name: str, tail: str) -> bool:
    """Whether displacements are measured by this end of a dimension: it cannot be left out."""
    open_end = without_end(getattr(follower, name), tail.lstrip("/"))
    return not isfinite(follower.model_copy(update={name: open_end}).travel.per_unit)


def _without(spec: DesignSpec, dropped: Collection[_Part]) -> DesignSpec:
    """The spec with some of its numbers left out."""
    return _changed(spec, dict.fromkeys(dropped))


def _changed(spec: DesignSpec, values: Mapping[_Part, float | None]) -> DesignSpec:
    """The spec with other numbers in its limits, and without those that are None."""
    limits: list[Limit | None] = list(spec.limits)
    update: dict[str, Any] = {}
    follower: dict[str, Any] = {}
    for part, value in values.items():
        if part.owner is not None:
            limits[part.owner] = _limit(spec, limits[part.owner], part.attribute, value)
        elif part.field.startswith("follower/"):
            now = follower.get(part.attribute, getattr(spec.follower, part.attribute))
            follower[part.attribute] = without_end(now, part.field.rpartition("/")[2])
        else:
            now = update.get(part.attribute, getattr(spec, part.attribute))
            update[part.attribute] = without_end(now, part.field.rpartition("/")[2])
    kept = [limit for limit in limits if limit is not None]
    machine = spec.follower.model_copy(update=follower)
    return spec.model_copy(update={**update, "limits": kept, "follower": machine})


def _limit(
    spec: DesignSpec, limit: Limit | None, attribute: str, value: float | None
) -> Limit | None:
    """A limit with one field changed; None where it says nothing without that field."""
    if limit is None:
        return None
    claims = limit.claims(spec.placed_segments(), spec.machine())
    said = {claim.field.rpartition("/")[2] for claim in claims}
    if value is None and not said - {attribute}:
        return None
    return limit.model_copy(update={attribute: value})


def _tried(spec: DesignSpec, dropped: Collection[_Part], deadline: float) -> SolveState:
    return optimise(formulate_problem(_without(spec, dropped), BaseRadius()), ROUGH, deadline)


def _relaxation(spec: DesignSpec, part: _Part, alone: SolveState, deadline: float) -> Relaxation:
    """What one part alone would have to be."""
    needed, note = None, ALONE
    if alone.incumbent is not None and part.owner is None:
        dimensions = alone.problem.machine.follower.dimensions(alone.incumbent.size)
        needed, note = dimensions.get(part.attribute), ELSEWHERE
    elif alone.incumbent is not None:
        needed = _least(spec, part, deadline) if clock.now() < deadline else None
        note = LATE if needed is None else FOUND
    return Relaxation(
        limit=part.name, field=part.field, unit=part.unit, requested=part.requested, needed=needed,
        note=note,
    )  # fmt: skip


def _least(spec: DesignSpec, part: _Part, deadline: float) -> float | None:
    """A value near the least with which a cam is found, the other limits kept; None: none seen."""

    def fits(value: float) -> bool:
        problem = formulate_problem(_changed(spec, {part: value}), BaseRadius())
        return optimise(problem, ROUGH, deadline).incumbent is not None

    asked, ceiling = part.requested, CEILING.get(part.unit, inf)
    eased = part.words.find("≥") < 0
    low, high = asked, (min(1.5 * asked, ceiling) if eased else 0.0)
    while not fits(high):
        if high in (ceiling, 0.0) or clock.now() >= deadline or high > 1e6 * asked:
            return None
        low, high = high, min(2.0 * high, ceiling)
    for _ in range(HALVINGS):
        if abs(high - low) <= ACCURATE * abs(high) or clock.now() >= deadline:
            break
        middle = 0.5 * (low + high)
        low, high = (low, middle) if fits(middle) else (middle, high)
    return high
