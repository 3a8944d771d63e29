"""Choose a shaper's free lengths for its requirements, or say why there are none.

The best lengths are a global minimum over a unit box: a bundle method from some random points finds
the point, branch and bound the lower bound, which is the least of all boxes that are pruned or left
open. Boxes are taken best first, many at a time, until time or boxes run out.
``numerics.box_search`` goes level by level, which here would need many times the boxes, as bounds
of affine models improve slowly in five dimensions.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from synthesis.catalogue.fields import ends
from synthesis.design.design import Conflict, Proof, Relaxation, Status
from synthesis.errors import InputError, TimeBudgetExceeded
from synthesis.machines.linkages.shaper import report
from synthesis.machines.linkages.shaper.design_space import (
    CLEARANCE,
    CRANK_ANGLES,
    OBJECTIVES,
    ROUNDING,
    SHORTEST_COUPLER,
    DesignSpace,
    ShaperObjective,
    Span,
    quick_return_ratio_of,
)
from synthesis.machines.linkages.shaper.report import SixBarShaper
from synthesis.machines.linkages.shaper.spec import LENGTHS, ShaperSpec
from synthesis.numerics import clock
from synthesis.numerics.affine import Affine
from synthesis.numerics.piecewise import Array
from synthesis.numerics.polytope import BundlePoint, Polytope, minimise
from synthesis.units import FULL_TURN, rad_per_s

SIZE: Final = 5  # dimensions of the unit box
SAMPLES: Final = 24  # crank angles of a turn at which a bound takes the acceleration
# Preferred coordinates where the objective does not decide: guide, pivots and coupler short, the
# ram's line in the middle.
PREFERRED: Final = ((1, 0.0), (2, 0.0), (3, 0.0), (4, 0.5))
SAMPLES_OF_BOX: Final = 1024  # random points before the descent
STARTS: Final = 4  # of these points, starts of a descent
MAX_STEPS: Final = 60  # of a descent
RADIUS: Final = 0.2  # of its first trust region, in the unit box
BATCH: Final = 1500  # boxes of an iteration
MAX_BOXES: Final = 60_000  # in all
MIDDLES: Final = 32  # boxes of an iteration whose middles are evaluated
WIDE: Final = 0.05  # weight of a box's width beside its slopes in the choice of the split
VALUE_ROUNDING: Final = 1e-9  # relative: by so much rounding may make a value better than its bound
SHARE: Final = 0.9  # of the tolerance; the rest is for the measured value
GAP: Final = 1e-3  # relative: of what would be needed
LONG_COUPLER: Final = 1e3  # longest guides: a longer coupler is no better
VALID_FOR: Final = (
    "all six-bar shapers with a rocking guide and these ranges, whose ram turns back where the "
    "guide does"
)
CLOSED: Final = (
    "Closed form: S = 2 L r/a and Q = (π + 2β)/(π − 2β) with sin β = r/a. Proven. Each "
    "change was tried."
)


def analyse_or_size_shaper(spec: ShaperSpec, deadline: float | None = None) -> SixBarShaper:
    """Analyse a shaper with all lengths given, or choose the lengths that are left free.

    Raises:
        InputError: it cannot make a full turn, its crank stops, or free lengths leave rotating
            guides only.
        TimeBudgetExceeded: before lengths were found or excluded.
    """
    if not spec.free:
        return report.analyse_shaper(
            spec, {name: low for name, (low, _) in spec.length_ranges().items()}
        )
    shortest, farthest = ends(spec.crank_mm)[0], ends(spec.pivot_distance_mm)[1]
    if shortest >= farthest:
        raise InputError(
            "/crank_mm", shortest,
            f"Every allowed crank is longer than the pivot distance (at most "
            f"{farthest:g} mm), so that the guide makes full turns: such shapers are analysed, not "
            "sized.", f"Allow cranks below {farthest:g} mm, or give every length.",
        )  # fmt: skip
    space = DesignSpace.of(spec)
    low, high = space.sine_range()
    if low > high:
        # Two fields have disjoint ranges of s = r/a.
        lowest = max(space.sines, key=lambda name: space.sines[name][0])
        highest = min(space.sines, key=lambda name: space.sines[name][1])
        return report.report_infeasible(spec, Conflict(
            limits=sorted({lowest, highest}), evidence=CLOSED, proven=True,
            relaxations=list(_closed_form_relaxations(spec, space, deadline)),
        ))  # fmt: skip
    objective = OBJECTIVES[spec.objective.kind]
    result = global_minimum(space, objective, SHARE * spec.tolerance, deadline)
    lengths = None if result.u is None else space.lengths_at(result.u)
    if lengths is None:
        proven = math.isinf(result.bound)
        if not proven and deadline is not None and clock.now() >= deadline:
            raise TimeBudgetExceeded(spec.time_budget_s or 0.0)
        return report.report_infeasible(spec, _explain_coupler(spec, space, proven, deadline))
    bound = objective.to_wire(result.bound, rad_per_s(spec.speed_rpm))
    return _certified(report.analyse_shaper(spec, lengths), objective, bound)


def _certified(answer: SixBarShaper, objective: ShaperObjective, bound: float) -> SixBarShaper:
    """The answer with the objective as measured on the finished linkage, and its bound."""
    assert answer.least_transmission_angle_deg is not None  # there is a linkage to measure
    peaks = next(one for one in answer.extremes if one.quantity == "ram_acceleration")
    value = {
        "longest_link_mm": max(answer.dimensions[name] for name in LENGTHS[:-1]),
        "least_transmission_angle_deg": answer.least_transmission_angle_deg,
        "ram_acceleration_mm_per_s2": max(abs(peaks.largest.value), abs(peaks.smallest.value)),
    }[objective.name]
    if abs(value - bound) <= VALUE_ROUNDING * abs(value):
        bound = value
    gap = abs(value - bound) / abs(value)
    proof = Proof(
        objective=objective.name, value=value, lower_bound=bound, bound_valid_for=VALID_FOR, gap=gap
    )
    status: Status = "optimal" if gap <= answer.spec.tolerance else "feasible"
    if not all(limit.holds for limit in answer.limits):
        status = "unsolved"
    return answer.model_copy(update={"certificate": proof, "status": status})


def _closed_form_relaxations(
    spec: ShaperSpec, space: DesignSpace, deadline: float | None
) -> Iterator[Relaxation]:
    """What stroke, ratio and each length would have to be with the others as they are."""
    stroke, lengths = space.stroke, space.lengths
    guide, crank, pivots = (lengths[f"{name}_mm"] for name in ("guide", "crank", "pivot_distance"))
    # Each field's range over the range of s that the others leave, from s = r/a, S = 2 L s and the
    # ratio's own formula.
    ranges: tuple[tuple[str, str, Callable[[float, float], Span]], ...] = (
        ("quick_return_ratio", "quick_return_ratio",
         lambda low, high: (quick_return_ratio_of(low), quick_return_ratio_of(high))),
        ("stroke_mm", "stroke_mm", lambda low, high: (2.0 * guide[0] * low, 2.0 * guide[1] * high)),
        ("guide_mm", "stroke_mm",
         lambda low, high: (0.5 * stroke[0] / high, 0.5 * stroke[1] / low)),
        ("crank_mm", "crank_mm", lambda low, high: (low * pivots[0], high * pivots[1])),
        ("pivot_distance_mm", "crank_mm", lambda low, high: (crank[0] / high, crank[1] / low)),
    )  # fmt: skip
    for name, field, range_of in ranges:
        low, high = space.sine_range(field)
        first, last = ends(getattr(spec, name))
        least, most = range_of(low, high) if low <= high else (1.0, 0.0)
        requested, needed = (last, least) if last < least else (first, most)
        helps, note = least <= most, "Changing this alone cannot help."
        if helps:
            # Stroke, ratio and lengths agree then; a search says whether some coupler reaches.
            wider = {name: {"min": min(first, needed), "max": max(last, needed)}}
            changed = DesignSpace.of(ShaperSpec.model_validate(spec.model_dump() | wider))
            helps = global_minimum(changed, SHORTEST_COUPLER, 1.0, deadline).u is not None
            note = f"With {needed:.6g} stroke, ratio and lengths agree, but no coupler reaches."
        yield Relaxation(
            limit=name, field=f"/{name}", unit="mm" if name.endswith("_mm") else "",
            requested=requested, needed=needed if helps else None, note="" if helps else note,
        )  # fmt: skip


def _explain_coupler(
    spec: ShaperSpec, space: DesignSpace, proven: bool, deadline: float | None
) -> Conflict:
    """Why no coupler serves: the best transmission angle, and the shortest coupler that would."""
    relaxations, requested = list[Relaxation](), spec.least_transmission_angle_deg
    if requested is not None:
        angle = OBJECTIVES["transmission_angle"]
        result = global_minimum(replace(space, largest_sine=1.0 - CLEARANCE), angle, GAP, deadline)
        needed, note = None, "No coupler in its range reaches the ram's line everywhere."
        if result.u is not None:
            needed, most = (angle.to_wire(sine, 1.0) for sine in (result.value, result.bound))
            note = f"Proven: none has more than {most:.6g}°."
        relaxations.append(Relaxation(
            limit="least_transmission_angle_deg", field="/least_transmission_angle_deg",
            unit="deg", requested=requested, needed=needed, note=note,
        ))  # fmt: skip
    shortest, longest = space.lengths["coupler_mm"]
    range_ = (shortest, LONG_COUPLER * space.lengths["guide_mm"][1])
    longer = replace(space, lengths=space.lengths | {"coupler_mm": range_})
    result = global_minimum(longer, SHORTEST_COUPLER, GAP, deadline)
    needed = None if result.u is None else result.value
    note = f"Proven: no coupler shorter than {result.bound:.6g} mm serves." if needed else ""
    relaxations.append(Relaxation(
        limit="coupler_mm", field="/coupler_mm", unit="mm", requested=longest, needed=needed,
        note=note,
    ))  # fmt: skip
    limits = [each.limit for each in relaxations]
    names = " and ".join(limits)
    evidence = f"No lengths were found that keep {names}. Not proven."
    if proven:
        evidence = f"No lengths within the ranges can keep {names}: excluded by branch and bound. "
        evidence += "Proven."
    return Conflict(limits=limits, relaxations=relaxations, evidence=evidence, proven=proven)


@dataclass(frozen=True, eq=False)
class SearchResult:
    """The best point and the bound."""

    u: Array | None  # (5,); None: none was found
    value: float  # of the objective there
    bound: float  # no feasible shaper has a smaller value; inf: there is no feasible shaper


@np.errstate(all="ignore")
def global_minimum(
    space: DesignSpace, objective: ShaperObjective, tolerance: float, deadline: float | None
) -> SearchResult:
    """The best shaper, to a relative gap where time allows (``deadline``: ``time.monotonic()``)."""
    low, high = space.sine_range()
    if low > high:
        return SearchResult(None, np.inf, np.inf)
    start = _descend(space, objective)
    u, value = (None, np.inf) if start is None else (start.u, start.value)
    phi = _angles(objective, space, u)
    # Lower and upper corners of open boxes, and their bounds so far; least bound of pruned boxes.
    boxes = [np.zeros((1, SIZE)), np.ones((1, SIZE)), np.array([-np.inf])]
    pruned, count, stop = np.inf, 0, math.inf if deadline is None else deadline
    while len(boxes[0]) and count < MAX_BOXES and clock.now() < stop:
        # Best first: the boxes with the least bounds.
        order = np.argsort(boxes[2])
        lo, hi, known = (each[order[:BATCH]] for each in boxes)
        count += len(lo)
        lower, split = _bounds(space, objective, lo, hi, phi)
        lower = np.maximum(lower, known)
        # Incumbent: the middles of the most promising boxes.
        middle = 0.5 * (lo + hi)[np.argsort(lower)[:MIDDLES]]
        values = _values(space, objective, middle)
        if values.min() < value:
            u, value = middle[values.argmin()], float(values.min())
        # Prune boxes that cannot improve the incumbent by more than the tolerance; their bound
        # counts.
        enough = value - tolerance * abs(value) if np.isfinite(value) else np.inf
        done = lower >= enough
        pruned = min(pruned, float(np.min(lower, where=done, initial=np.inf)))
        # Cut every other box in half at its coordinate.
        lo, hi, split, lower = (each[~done] for each in (lo, hi, split, lower))
        side = np.arange(SIZE) == split[:, None]
        middle = 0.5 * (lo + hi)
        halves = ((lo, np.where(side, middle, hi), lower), (np.where(side, middle, lo), hi, lower))
        boxes = [np.concatenate([each[order[BATCH:]], *cut])
                 for each, *cut in zip(boxes, *halves, strict=True)]  # fmt: skip
    # Preferred coordinates wherever they do not cost anything.
    if u is not None:
        for k, preferred in PREFERRED:
            other = u.copy()
            other[k] = preferred
            if _values(space, objective, other[None])[0] <= value * (1.0 + ROUNDING):
                u = other
    return SearchResult(u, value, min(pruned, float(np.min(boxes[2], initial=np.inf))))


def _values(space: DesignSpace, objective: ShaperObjective, u: Array) -> Array:
    """The objective at points (n, 5); inf where the coupler is too short."""
    one = space.at(u.T)
    values = objective.values(one)
    possible = (one.deficit <= ROUNDING * np.abs(one.coupler)) & np.isfinite(values)
    return np.asarray(np.where(possible, values, np.inf))


def _descend(space: DesignSpace, objective: ShaperObjective) -> BundlePoint | None:
    """The best of some random points, improved by a bundle method (``numerics.polytope``)."""
    rng = np.random.default_rng(3)
    u = np.vstack(
        [rng.random((SAMPLES_OF_BOX, SIZE)), rng.integers(0, 2, (SAMPLES_OF_BOX // 8, SIZE))]
    )
    values = np.concatenate([_values(space, objective, part) for part in np.array_split(u, 32)])
    order = np.argsort(values)[:STARTS]
    starts = [BundlePoint(u[k], float(values[k])) for k in order if np.isfinite(values[k])]
    if not starts:
        return None

    def function(at: Array) -> float | None:
        value = float(_values(space, objective, np.clip(at, 0.0, 1.0)[None])[0])
        return value if np.isfinite(value) else None

    box = Polytope(np.zeros((0, SIZE)), np.zeros(0))
    ends = [minimise(function, box, start, RADIUS, MAX_STEPS) for start in starts]
    reached = min(ends, key=lambda one: one.value)
    return BundlePoint(np.clip(reached.u, 0.0, 1.0), reached.value)


def _angles(objective: ShaperObjective, space: DesignSpace, u: Array | None) -> list[float]:
    """Crank angles for the bound: evenly over the turn, more where the best point has peaks."""
    if not objective.angles:
        return [0.0]
    phi = FULL_TURN * np.arange(SAMPLES) / SAMPLES
    if u is not None:
        for part in objective.over_turn(space.at(u[:, None]))[:, 0]:
            phi = np.append(phi, CRANK_ANGLES[np.argmax(part)] + 0.05 * np.arange(-3, 4))
    return [float(each) for each in phi]


def _bounds(
    space: DesignSpace, objective: ShaperObjective, lo: Array, hi: Array, phi: list[float]
) -> tuple[Array, Array]:
    """A lower bound on every box, inf where nothing is feasible, and the coordinate to split."""
    # Affine models of the shapers on the boxes; |sin γ| ≤ k narrows them.
    k = space.largest_sine
    one = replace(space.at(Affine.variables(lo, hi)), narrow=lambda sine: sine.restrict(-k, k))
    parts = objective.lower_bounds(one, phi, space.lengths["ram_line_mm"])
    lows = np.stack([part.lower for part in parts])
    lows = np.where(np.isfinite(lows), lows, -np.inf)
    which = np.argmax(lows, axis=0)
    lower, rows = np.max(lows, axis=0), np.arange(len(lo))
    slopes = np.abs(np.stack([part.g for part in parts]))[which, :, rows]
    rem = np.stack([part.rem for part in parts])[which, rows]
    # Where nothing is known yet, split what makes the coupler's angle uncertain.
    uncertain = np.abs(one.middle_sine.g.T) + np.abs(one.end_sine.g.T)
    known = np.isfinite(lower)[:, None]
    slopes, rem = np.where(known, slopes, uncertain), np.where(known[:, 0], rem, 0.0)
    spread = (rem + np.sum(slopes, axis=1))[:, None]
    split = np.argmax(slopes + WIDE * spread * (hi - lo), axis=1)
    # Objectives are not negative.
    return np.where(one.deficit.lower > 0.0, np.inf, np.maximum(lower, 0.0)), split
