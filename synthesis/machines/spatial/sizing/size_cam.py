"""Choose the laws and dimensions that a spec leaves free: the smallest spatial cam, with a bound.

1. Rollers. Smaller rollers nearer to the turret's axis never make the cam larger, so that they
   start as small and as near as ranges and ribs at rest allow; the bound then holds for all others.
2. Laws and size together, under limits on pressure angle and motion: a convex program where these
   are linear (slides), sequential convex programming otherwise (arms and turrets).
3. The size grows until walls and ribs are sound, by samples.
4. The rollers grow as far as walls and ribs allow.

Steps 3 and 4 are outside of the program and the bound: walls have no closed form except the convex
radius on a turret, which enters step 2 where the first cam breaks it. A larger cam and smaller
rollers ease all that walls and ribs have to keep, so that the least size and the largest rollers
are roots of monotone functions. Samples are checked quickly; ``measuring`` judges the result.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from math import inf

import numpy as np
from scipy.optimize import brentq

from synthesis.catalogue.motion import Motion, PlacedSegment
from synthesis.machines.spatial.cam import build_cam
from synthesis.machines.spatial.machine import LARGEST, ROLLER_RADIUS, SpatialMachine
from synthesis.machines.spatial.measuring.measure import UNDERCUT, thinnest_rib
from synthesis.machines.spatial.measuring.patches import Sampling, patches
from synthesis.machines.spatial.sizing.sequential_convex import formulate_problem, minimise_size
from synthesis.machines.spatial.spec import AnySpatialLimit, SpatialCamSpec, WallRadius
from synthesis.optimise import driver
from synthesis.optimise.conic.semi_infinite import most_violated
from synthesis.optimise.parameters.table_smoothing import Tables
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.closed_form import closed_form_size
from synthesis.optimise.recovery.junction_repair import Splines
from synthesis.optimise.state import SolveState, Stage

SMALLEST = 1e-3  # mm: a radius or an inner end without a least value
CLEAR = 3e-8  # relative: a size keeps off the bound that it was solved for, against rounding
SAMPLING_MARGIN = 20.0  # tightenings: what samples of walls may miss, 2e-6 of the size at first
RIB_MARGIN = 2e-5  # relative: ribs at rest keep this for what samples of ribs in motion miss
SLACK = 0.02  # of the tolerance: the size gives it up, so that the measurement resolves less
ROUNDING = 1e-12  # relative: accuracy of the size of given laws
WALL_QUANTITY, RIB_QUANTITY = "convex_radius", "rib_thickness"  # quantities of limits on walls
SAMPLES = Sampling(240, 240, 1, 9, 5, 0.25, "sampled")
PLACES = 3  # samples along the roller
WALL_ACCURACY, RIB_ACCURACY = 1e-7, 1e-4  # relative, of a size that is enlarged for walls, for ribs
FIRST_STEP = 0.02  # relative, of a size that is enlarged; doubled until it is enough
ROLLER_MARGIN = 1e-3  # of the ratio of areas: what larger rollers leave for what samples miss

NO_LAW = f"no motion law was found for sizes up to {LARGEST:.0f} mm"

Sizes = Mapping[str, float]
Margin = Callable[[float], float]  # of one dimension; negative where something is broken
Requirement = Callable[[SpatialCamSpec, Motion, Sizes], float]  # the same of all dimensions
Ranges = Mapping[str, tuple[float, float]]


@dataclass(eq=False)
class SizingResult:
    """A sized cam, or why there is none.

    Attributes:
        segments: the program, with its laws where a cam was found [rad or mm].
        splines: of the laws that were chosen, by index.
        stages: what was modelled and what it cost.
        sizes: the dimensions [mm]; None where there is no cam.
        lower: lower bound of the minimised dimension [mm]. valid_for: what the bound covers.
        why: why there is no cam. proven: of all cams of the spec.
        walls_failed: walls and ribs alone leave no cam.
    """

    segments: tuple[PlacedSegment, ...]
    splines: Splines
    stages: list[Stage] = field(default_factory=list)
    sizes: Sizes | None = None
    lower: float = -inf
    valid_for: str = ""
    why: str = ""
    proven: bool = False
    walls_failed: bool = False

    @property
    def motion(self) -> Motion:
        """The motion over one turn."""
        return Motion.of(self.segments)


def size_cam(
    spec: SpatialCamSpec,
    tables: Tables,
    deadline: float = inf,
    tighten: float = 1e-7,
    *,
    ribs: bool = True,
    existence_only: bool = False,
) -> SizingResult:
    """Choose what a spec leaves free.

    Args:
        tables: the program with tables smoothed.
        deadline: ``clock.now()`` at which to stop with the best so far.
        tighten: relative amount by which rows are tightened against the solver's tolerance.
        ribs: whether the cam is enlarged for ribs in motion, which take a while to measure.
        existence_only: steps 1 and 2 alone, which decide whether there is a cam but for walls.
    """
    result = SizingResult(tables.segments, dict(tables.splines), list(tables.stages))
    ranges = spec.machine.ranges()
    # 1. The smallest rollers.
    rib = strictest_minimum(spec.limits, RIB_QUANTITY)
    rollers = smallest_rollers(spec.machine, ranges, rib)
    if rollers is None:
        result.why, result.proven = "rollers leave no rib of that thickness at rest", True
        return result
    # 2. Laws and size together.
    low, high = ranges[spec.machine.size_field]
    size = _solve_laws_and_size(spec, result, rollers, deadline, tighten)
    if size is None:
        return result
    if result.lower > high * (1.0 + ROUNDING):
        result.why, result.proven = "the cam would have to be larger", True
        return result
    if low > result.lower:
        result.lower, result.valid_for = low, "the range of the dimension itself"
    size = max(size * (1.0 + SLACK * spec.tolerance), low)
    if size > high:
        if size > high * (1.0 + CLEAR + SLACK * spec.tolerance):
            result.why = "no cam so small was found"
            return result
        size = high
    sizes = {**rollers, spec.machine.size_field: size}
    # 3. and 4. Walls, ribs and rollers.
    if existence_only:
        result.sizes = sizes
    else:
        _enlarge_for_walls(spec, result, sizes, ranges, tighten, ribs=ribs)
    return result


def _solve_laws_and_size(
    spec: SpatialCamSpec, result: SizingResult, rollers: Sizes, deadline: float, tighten: float
) -> float | None:
    """The smallest size under limits on pressure angle and motion, and the laws for it."""
    # Windows and points of the program are limits of single segments.
    demands = [d for i, segment in enumerate(spec.program) for d in segment.segment_bounds(i)]
    limits = [*(limit for limit in spec.limits if limit.quantity != WALL_QUANTITY), *demands]
    problem = formulate_problem(spec, result.segments, limits, rollers)
    walls = WallRadius(min_mm=strictest_minimum(spec.limits, WALL_QUANTITY))
    with_walls = replace(problem, limits=(*problem.limits, walls))
    if not problem.free:
        return _size_of_given_laws(with_walls, result)
    search = _minimise(problem, result, spec.tolerance, deadline, tighten)
    best = search.incumbent
    if best is None:
        result.proven = search.infeasible
        result.why = search.infeasibility_proof or search.undecided or NO_LAW
        return None
    # Few cams are limited by the radius of their walls: the limit enters where it is broken. The
    # bound without it remains valid.
    kept = replace(problem, limits=(walls,), segments=best.problem.segments)
    if np.any(most_violated(kept, best.size).excess > 0.0):
        best = _minimise(with_walls, result, spec.tolerance, deadline, tighten).incumbent or best
    # The laws of the cam belong to the program, in its own unit.
    laws = {segment.index: law for segment, law in zip(problem.free, best.laws, strict=True)}
    result.segments = tuple(
        segment.with_law(laws[segment.index].curve()) if segment.index in laws else segment
        for segment in result.segments
    )
    chosen = {index: (law.space, law.coefficients) for index, law in laws.items()}
    result.splines = {**result.splines, **chosen}
    return best.size[0]


def _minimise(
    problem: Problem, result: SizingResult, tolerance: float, deadline: float, tighten: float
) -> SolveState:
    """Minimise the size over laws and size; stages and the best bound go to the result."""
    if problem.has_curved_limits:
        search = minimise_size(problem, tolerance, deadline, tighten)
    else:  # linear in motion and size together, as a translating roller's: the planar engine
        search = driver.optimise(problem, tolerance, deadline, tighten)
    result.stages += search.stages
    if search.lower > result.lower:
        result.lower, result.valid_for = search.lower, search.valid_for
    return search


def _size_of_given_laws(problem: Problem, result: SizingResult) -> float | None:
    """The least size in closed form: with given laws every constraint is a half-line of sizes."""
    began = time.perf_counter()
    exact, clear = closed_form_size(problem), closed_form_size(problem, CLEAR)
    seconds = time.perf_counter() - began
    result.stages.append(Stage("closed form", "half-planes", "none", 1, 0, 0, seconds, "solved"))
    if exact is None or clear is None:
        result.why, result.proven = (
            f"the given laws break a limit at every size up to {LARGEST:.0f} mm",
            True,
        )
        return None
    result.lower = exact[0] * (1.0 - ROUNDING)
    result.valid_for = "every size of the given laws"
    return clear[0]


def strictest_minimum(limits: Sequence[AnySpatialLimit], quantity: str) -> float:
    """The largest lower limit on a quantity [mm]; 0 where there is none."""
    minima = [each.bound for each in limits if each.quantity == quantity and not each.upper]
    return max(minima, default=0.0)


def smallest_rollers(machine: SpatialMachine, ranges: Ranges, rib: float) -> Sizes | None:
    """The smallest rollers nearest to the turret's axis; None where ribs at rest are too thin.

    ``rib`` is their least thickness [mm].
    """
    rollers = {
        name: low if low > 0.0 else SMALLEST
        for name, (low, _) in ranges.items()
        if name != machine.size_field
    }
    place = machine.inner_end_field
    start, high = (rollers[place], ranges[place][1]) if place else (0.0, 0.0)

    def margin(at: float) -> float:
        moved = {**rollers, place: at} if place else rollers
        return machine.dwell_rib(moved) - rib * (1.0 - ROUNDING) - RIB_MARGIN * at

    # Ribs become thicker away from the turret's axis: move the rollers out as little as needed.
    least = _boundary(margin, start, high, ROUNDING)
    if least is None:
        return None
    return rollers if least == start else {**rollers, place: min(least * (1.0 + CLEAR), high)}


def _enlarge_for_walls(
    spec: SpatialCamSpec,
    result: SizingResult,
    sizes: Sizes,
    ranges: Ranges,
    tighten: float,
    *,
    ribs: bool,
) -> None:
    """Enlarge the cam as little as walls, and ribs, need, then the rollers as far as they allow."""
    began, machine, sizes = time.perf_counter(), spec.machine, dict(sizes)
    spare = SAMPLING_MARGIN * tighten
    # Each requirement, the accuracy of its roots, and what it keeps where rollers are enlarged.
    required = [(_wall_margin, WALL_ACCURACY, max(ROLLER_MARGIN, spare))]
    required += [(_rib_margin, RIB_ACCURACY, spare)] if ribs else []

    def margin(of: Requirement, name: str, kept: float) -> Margin:
        return cache(lambda value: of(spec, result.motion, {**sizes, name: value}) - kept)

    # 3. The cam: growing steps until one is enough, then the root within the last of them.
    name = machine.size_field
    first, high = sizes[name], ranges[name][1]
    for of, accuracy, _ in required:
        fits, step = margin(of, name, spare), FIRST_STEP * sizes[name]
        low = at = sizes[name]
        while fits(at) < 0.0 and at < high:
            low, at, step = at, min(sizes[name] + step, high), 2.0 * step
        least = _boundary(fits, low, at, accuracy)
        if least is None:
            result.why, result.walls_failed = "no cam so small has sound walls and ribs", True
            return
        sizes[name] = least
    growth = sizes[name] / first - 1.0
    # 4. The rollers: the largest that ribs at rest allow, then walls, and ribs in motion.
    name, rib = ROLLER_RADIUS, strictest_minimum(spec.limits, RIB_QUANTITY)
    smallest, largest = sizes[name], ranges[name][1]

    def rest(radius: float) -> float:
        return machine.dwell_rib({**sizes, name: radius}) - rib - RIB_MARGIN * radius

    radius = _boundary(rest, largest, smallest, ROUNDING) or smallest
    radius *= 1.0 if radius in (smallest, largest) else 1.0 - CLEAR
    if radius > smallest * (1.0 + ROLLER_MARGIN):
        for of, accuracy, kept in required:
            radius = _boundary(margin(of, name, kept), radius, smallest, accuracy) or smallest
        sizes[name] = radius
    result.sizes = sizes
    note = f"grown by {growth:.3g} for walls and ribs" if growth > 0.0 else ""
    seconds = time.perf_counter() - began
    result.stages.append(Stage("walls", "sampled", "none", 1, 0, 0, seconds, "solved", note))


def _wall_margin(spec: SpatialCamSpec, motion: Motion, sizes: Sizes) -> float:
    """The least clearance, relative, if one is negative, else the least ratio of areas.

    That is of walls to the surface which a roller's axis sweeps: they are neither undercut nor
    rounder than allowed where a roller larger by the least convex radius would not undercut them.
    """
    machine, radius = spec.machine, strictest_minimum(spec.limits, WALL_QUANTITY)
    unit, clearances = sizes[machine.size_field], machine.clearances(sizes).values()
    least = min((clearance / unit for clearance in clearances), default=inf)
    if least <= 0.0:
        return least
    cam = build_cam(spec, sizes, motion)
    roller = cam.swept.roller
    crown = roller.crown + radius if roller.crown else 0.0
    larger = replace(roller, radius=roller.radius + radius, crown=crown)
    parts = list(patches(replace(cam, swept=replace(cam.swept, roller=larger))))
    if not parts:
        return inf
    walls = list(SAMPLES.walls(parts, roller.places(PLACES)))
    return UNDERCUT.extremum(walls, SAMPLES).value


def _rib_margin(spec: SpatialCamSpec, motion: Motion, sizes: Sizes) -> float:
    """Thickness of the thinnest rib beyond the least one allowed, relative; slow."""
    cam = build_cam(spec, sizes, motion)
    thinnest = thinnest_rib(cam, list(patches(cam)), spec.machine.seats())
    least = strictest_minimum(spec.limits, RIB_QUANTITY)
    unit = sizes[spec.machine.size_field]
    return inf if thinnest is None else (thinnest.limit - least) / unit


def _boundary(margin: Margin, bad: float, good: float, accuracy: float) -> float | None:
    """Where a monotone margin becomes nonnegative from ``bad`` to ``good``, on the latter's side.

    ``bad`` where it is so there already; None where it is negative at both. ``accuracy``: relative.
    """
    if margin(bad) >= 0.0:
        return bad
    if margin(good) < 0.0:
        return None
    root = float(brentq(margin, bad, good, rtol=accuracy))
    step = accuracy * root
    while margin(root) < 0.0:
        root = max(root - step, good) if good < bad else min(root + step, good)
    return root
