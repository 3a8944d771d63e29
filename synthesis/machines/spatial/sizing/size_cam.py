"""Choose the laws and dimensions that a spec leaves free: the smallest spatial cam, with a bound.

1. Rollers. Smaller rollers nearer to the turret's axis never make the cam larger, so that they
   start as small and as near as ranges and ribs at rest allow; the bound then holds for all others.
2. Laws and size together, under limits on pressure angle and motion: a convex program where these
   are linear (slides), sequential convex programming otherwise (arms and turrets).
3. The size grows until walls and ribs are sound, by samples.
4. The rollers grow as far as that leaves room for.

Steps 3 and 4 are outside of the program and the bound: walls have no closed form except the convex
radius on a turret, which enters step 2 where the first cam breaks it. A larger cam and smaller
rollers ease all that walls and ribs have to keep, so that the least size and the largest rollers
are roots of monotone functions. Samples are checked quickly; ``measuring`` judges the result.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf

import numpy as np
from scipy.optimize import brentq

from synthesis.catalogue.fields import ends
from synthesis.catalogue.motion import Motion, PlacedSegment
from synthesis.machines.spatial.cam import build_cam
from synthesis.machines.spatial.limits import AnySpatialLimit, WallRadius
from synthesis.machines.spatial.machine import LARGEST, ROLLER_RADIUS, SpatialMachine
from synthesis.machines.spatial.measuring.patches import patches, sample_walls
from synthesis.machines.spatial.measuring.walls import thinnest_rib
from synthesis.machines.spatial.sizing.sequential_convex import formulate_problem, minimise_size
from synthesis.machines.spatial.spec import SpatialCamSpec
from synthesis.optimise import driver
from synthesis.optimise.conic.semi_infinite import most_violated
from synthesis.optimise.parameters.table_smoothing import Tables
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.candidate import Candidate
from synthesis.optimise.recovery.closed_form import closed_form_size
from synthesis.optimise.recovery.junction_repair import Splines
from synthesis.optimise.state.solve_state import SolveState, Stage

SMALLEST = 1e-3  # mm: a radius or an inner end without a least value
CLEAR = 3e-8  # relative: a size keeps off the bound that it was solved for, against rounding
SAMPLING_MARGIN = 20.0  # tightenings: what samples of walls may miss, 2e-6 of the size at first
RIB_MARGIN = 2e-5  # relative: ribs at rest keep this for what samples of ribs in motion miss
SLACK = 0.02  # of the tolerance: the size gives it up, so that the judge resolves less
ROUNDING = 1e-12  # relative: accuracy of the size of given laws
WALL_QUANTITY, RIB_QUANTITY = "convex_radius", "rib_thickness"  # quantities of limits on walls
ANGLES, PLACES = 240, 3  # samples of a wall: cam angles, and places along the roller
NEIGHBOURS, REFINEMENTS = 9, 5  # around the lowest sample; each refinement quarters the interval
WALL_ACCURACY, RIB_ACCURACY = 1e-7, 1e-4  # relative, of a size that is enlarged for walls, for ribs
FIRST_STEP = 0.02  # relative, of a size that is enlarged; doubled until it is enough
ROLLER_MARGIN = 1e-3  # of the ratio of areas: what larger rollers leave for what samples miss

Sizes = Mapping[str, float]
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
        spec: the spec. tables: its program with tables smoothed.
        deadline: ``clock.now()`` at which to stop with the best so far.
        tighten: relative amount by which rows are tightened against the solver's tolerance.
        ribs: whether the cam is enlarged for ribs in motion, which take a while to measure.
        existence_only: steps 1 and 2 alone, which decide whether there is a cam but for walls.
    """
    result = SizingResult(tables.segments, dict(tables.splines), list(tables.stages))
    ranges = {name: ends(given) for name, given in spec.machine.sizes().items()}
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
        result.why = search.infeasibility_proof or search.undecided or "no motion law was found"
        return None
    # Few cams are limited by the radius of their walls: the limit enters where it is broken. The
    # bound without it remains valid.
    kept = replace(problem, limits=(walls,), segments=best.problem.segments)
    if np.any(most_violated(kept, best.size).excess > 0.0):
        best = _minimise(with_walls, result, spec.tolerance, deadline, tighten).incumbent or best
    _adopt_laws(result, problem, best)
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
        result.why, result.proven = "the given laws break a limit on the motion", True
        return None
    result.lower = exact[0] * (1.0 - ROUNDING)
    result.valid_for = "every size of the given laws"
    return clear[0]


def _adopt_laws(result: SizingResult, problem: Problem, cam: Candidate) -> None:
    """Take the laws of a cam over into the program, in its own unit."""
    laws = {segment.index: law for segment, law in zip(problem.free, cam.laws, strict=True)}
    result.segments = tuple(
        segment.with_law(laws[segment.index].curve()) if segment.index in laws else segment
        for segment in result.segments
    )
    chosen = {index: (law.space, law.coefficients) for index, law in laws.items()}
    result.splines = {**result.splines, **chosen}


def strictest_minimum(limits: Sequence[AnySpatialLimit], quantity: str) -> float:
    """The largest lower limit on a quantity [mm]; 0 where there is none."""
    minima = [each.bound for each in limits if each.quantity == quantity and not each.upper]
    return max(minima, default=0.0)


def smallest_rollers(machine: SpatialMachine, ranges: Ranges, rib: float) -> Sizes | None:
    """The smallest rollers nearest to the turret's axis; None where ribs at rest are too thin.

    Args:
        ranges: of the dimensions, by field [mm]. rib: least thickness [mm].
    """
    rollers = {
        name: low if low > 0.0 else SMALLEST
        for name, (low, _) in ranges.items()
        if name != machine.size_field
    }
    place = machine.inner_end_field
    if not place:
        return rollers if machine.dwell_rib(rollers) >= rib * (1.0 - ROUNDING) else None

    def missing(at: float) -> float:
        return rib + RIB_MARGIN * at - machine.dwell_rib({**rollers, place: at})

    # Ribs become thicker away from the turret's axis: move the rollers out as little as needed.
    if missing(rollers[place]) <= 0.0:
        return rollers
    high = min(ranges[place][1], LARGEST)
    if missing(high) > ROUNDING * high:
        return None
    root = float(brentq(missing, rollers[place], high)) if missing(high) < 0.0 else high
    return {**rollers, place: min(root * (1.0 + CLEAR), high)}


def _enlarge_for_walls(
    spec: SpatialCamSpec,
    result: SizingResult,
    sizes: Sizes,
    ranges: Ranges,
    tighten: float,
    *,
    ribs: bool,
) -> None:
    """Enlarge the cam as little as walls, and ribs, need, then the rollers."""
    began, machine = time.perf_counter(), spec.machine
    rib = strictest_minimum(spec.limits, RIB_QUANTITY)
    radius = strictest_minimum(spec.limits, WALL_QUANTITY)
    required = WallRequirements(spec, result.motion, radius, rib, SAMPLING_MARGIN * tighten)
    name, enlarged = machine.size_field, sizes
    high = min(ranges[name][1], LARGEST)
    wanted = [(required.wall_margin, WALL_ACCURACY), (required.rib_margin, RIB_ACCURACY)]
    for margin_of, accuracy in wanted if ribs else wanted[:1]:
        larger = _enlarge(margin_of, enlarged, name, high, accuracy)
        if larger is None:
            result.why, result.walls_failed = "no cam so small has sound walls and ribs", True
            return
        enlarged = larger
    growth = enlarged[name] / sizes[name] - 1.0
    largest = _largest_radius(machine, enlarged, ranges, rib)
    result.sizes = _enlarge_rollers(required, enlarged, largest)
    note = f"grown by {growth:.3g} for walls and ribs" if growth > 0.0 else ""
    seconds = time.perf_counter() - began
    result.stages.append(Stage("walls", "sampled", "none", 1, 0, 0, seconds, "solved", note))


@dataclass(frozen=True, eq=False)
class WallRequirements:
    """What walls and ribs have to keep, for one motion.

    Walls are neither undercut nor rounder than allowed where a roller larger by the least convex
    radius would not undercut them.

    Attributes:
        radius: least convex radius of walls [mm]. rib: least thickness of ribs [mm].
        margin: kept in all of it, relative, for what samples may miss.
    """

    spec: SpatialCamSpec
    motion: Motion
    radius: float
    rib: float
    margin: float

    def wall_margin(self, sizes: Sizes) -> float:
        """The least clearance if one is negative, else the least ratio of areas; less ``margin``.

        The ratio is that of walls to the surface which the axis of a larger roller sweeps.
        """
        machine = self.spec.machine
        unit, clearances = sizes[machine.size_field], machine.clearances(sizes).values()
        least = min((clearance / unit for clearance in clearances), default=inf)
        if least <= 0.0:
            return least - self.margin
        cam = build_cam(self.spec, sizes, self.motion)
        roller = cam.swept.roller
        crown = roller.crown + self.radius if roller.crown else 0.0
        larger = replace(roller, radius=roller.radius + self.radius, crown=crown)
        offset = replace(cam, swept=replace(cam.swept, roller=larger))
        rho = np.linspace(roller.inner, roller.outer, PLACES)
        least, lowest = inf, None
        for wall in sample_walls(list(patches(offset)), rho, ANGLES, ANGLES):
            values = wall.between_faces(wall.contacts.regular, inf)
            at, k = np.unravel_index(int(np.argmin(values)), values.shape)
            if values[at, k] < least:
                least, lowest = float(values[at, k]), (wall, int(at), rho[[k]])
        if lowest is None:
            return inf
        # Between the neighbours of the lowest sample the least value is found by ever finer ones.
        wall, sample, place = lowest
        each = wall.theta.shape[1]
        patch, theta = wall.patches[sample // each], wall.theta.flat[sample]
        step = (patch.high - patch.low) / max(each - 1, 1)
        for _ in range(REFINEMENTS):
            around = np.clip(
                theta + step * np.linspace(-1.0, 1.0, NEIGHBOURS), patch.low, patch.high
            )
            values = patch.at(around, place).contacts.regular[:, 0]
            theta, step = around[np.argmin(values)], 0.25 * step
        return min(least, float(np.min(values))) - self.margin

    def rib_margin(self, sizes: Sizes) -> float:
        """Thickness of the thinnest rib beyond the least one, relative, less ``margin``; slow."""
        cam = build_cam(self.spec, sizes, self.motion)
        thinnest = thinnest_rib(cam, list(patches(cam)), self.spec.machine.seats())
        if thinnest is None:
            return inf
        return (thinnest.limit - self.rib) / sizes[self.spec.machine.size_field] - self.margin


def _enlarge(
    margin_of: Callable[[Sizes], float], sizes: Sizes, name: str, largest: float, accuracy: float
) -> Sizes | None:
    """The sizes with one enlarged until a margin is ≥ 0; None where none up to the largest does."""

    def margin(size: float) -> float:
        return margin_of({**sizes, name: size})

    at = low = sizes[name]
    step = FIRST_STEP * low
    if margin(low) >= 0.0:
        return sizes
    while at < largest:
        at, before = min(low + step, largest), at
        if margin(at) >= 0.0:
            return {**sizes, name: _feasible_root(margin, before, at, accuracy)}
        step *= 2.0
    return None


def _largest_radius(machine: SpatialMachine, sizes: Sizes, ranges: Ranges, rib: float) -> float:
    """The largest radius of the rollers that leaves ribs at rest [mm]."""
    name = ROLLER_RADIUS
    low, high = sizes[name], min(ranges[name][1], LARGEST)

    def margin(radius: float) -> float:
        return machine.dwell_rib({**sizes, name: radius}) - rib - RIB_MARGIN * radius

    if high <= low or margin(high) >= 0.0:
        return max(low, high)
    return float(brentq(margin, low, high)) * (1.0 - CLEAR) if margin(low) > 0.0 else low


def _enlarge_rollers(required: WallRequirements, sizes: Sizes, largest: float) -> Sizes:
    """The sizes with rollers enlarged as far as walls allow, up to a largest radius [mm]."""
    name = ROLLER_RADIUS
    low, more = sizes[name], max(ROLLER_MARGIN - required.margin, 0.0)

    def margin(less: float) -> float:
        return required.wall_margin({**sizes, name: largest - less}) - more

    if largest <= low * (1.0 + ROLLER_MARGIN) or margin(largest - low) < 0.0:
        return sizes
    less = 0.0
    if margin(0.0) < 0.0:
        less = _feasible_root(margin, 0.0, largest - low, WALL_ACCURACY)
    return {**sizes, name: largest - less}


def _feasible_root(
    margin: Callable[[float], float], low: float, high: float, accuracy: float
) -> float:
    """Where the margin becomes positive, on the positive side."""
    step = accuracy * high
    root = float(brentq(margin, low, high, xtol=step, rtol=1e-12))
    while margin(root) < 0.0 and root < high:
        root = min(root + step, high)
    return root
