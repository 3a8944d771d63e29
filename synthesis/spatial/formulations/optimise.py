"""The smallest spatial cam: laws, rollers and the dimension that it grows by, and a bound.

Smaller rollers, nearer to a turret's axis, leave the cam smaller or as it is; so they are as small
and as near as ranges and ribs allow, and the bound holds for all others. Then the law and the size
under the limit on the pressure angle; then the size grows until walls and ribs are sound; at last
rollers become as large as that leaves room for.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf

import numpy as np
from scipy.optimize import brentq

from synthesis.formulations.cams.candidate import Candidate
from synthesis.formulations.cams.closed_form import nearest
from synthesis.formulations.cone.exchange import tightest
from synthesis.formulations.free_numbers.tables import Tables
from synthesis.formulations.ladder.refine import search as climbed
from synthesis.formulations.question.grid import SettledLaw
from synthesis.formulations.question.problem import Problem
from synthesis.formulations.rounds.search import Search, Stage
from synthesis.motion import Motion, Stretch
from synthesis.numerics.bspline import SplineSpace
from synthesis.numerics.piecewise import Array
from synthesis.ranges import ends
from synthesis.spatial.formulations.scene import posed
from synthesis.spatial.formulations.squeezing import squeezed
from synthesis.spatial.formulations.walls import Soundness, enlarged, grown
from synthesis.spatial.limits import AnySpatialLimit
from synthesis.spatial.limits.wall_radius import WallRadius
from synthesis.spatial.machine import SpatialMachine
from synthesis.spatial.objectives import objective_of
from synthesis.spatial.spec import SpatialCamSpec

LARGEST = 1e6  # mm: of an open end
TINY = 1e-3  # mm: a radius or a place as small as one likes
CLEAR = 3e-8  # relative: a size stays this far off what binds it
SPARE = 2e-6  # relative: what samples of walls may miss
ROOM = 2e-5  # relative: what ribs at rest keep for what samples of walls may miss
SLACK = 0.02  # of the tolerance
WALLS = "convex_radius"  # quantity of limits on walls
EXACT = 1e-12  # relative: the size of given laws is known so well

Sizes = Mapping[str, float]
Splines = Mapping[int, tuple[SplineSpace, Array]]


@dataclass(eq=False)
class Sized:
    """What came of a question.

    Attributes:
        stretches: the program, settled where a cam was found [rad or mm].
        splines: of the laws that were chosen, by index. sizes: None where there is no cam.
        value, lower: the dimension sought, and below what there is no cam [mm].
        over: what the bound covers. why: why there is no cam; proven: of all there can be.
        cramped: it is walls and ribs that leave no cam.
    """

    stretches: tuple[Stretch, ...]
    splines: Splines
    stages: list[Stage] = field(default_factory=list)
    sizes: Sizes | None = None
    lower: float = -inf
    over: str = ""
    why: str = ""
    proven: bool = False
    cramped: bool = False

    @property
    def motion(self) -> Motion:
        """The motion over one turn."""
        return Motion.of(self.stretches)


def sized(
    spec: SpatialCamSpec,
    tables: Tables,
    deadline: float = inf,
    tighten: float = 1e-7,
    *,
    ribs: bool = True,
    quick: bool = False,
) -> Sized:
    """Choose what a spec leaves free.

    Args:
        spec: what is asked. tables: its program with tables smoothed.
        deadline: ``clock.now()`` at which to stop with the best so far.
        tighten: relative amount by which rows are drawn in for the solver's sake.
        ribs: whether the cam is grown for ribs in motion, which takes a while to measure.
        quick: only whether there is a cam: neither that, nor are walls sampled or rollers enlarged.
    """
    found = Sized(tables.stretches, dict(tables.splines), list(tables.stages))
    ranges = {name: ends(given) for name, given in spec.machine.sizes().items()}
    rollers = least_rollers(spec.machine, ranges, least_of(spec.limits, "rib_thickness"))
    if rollers is None:
        found.why, found.proven = "rollers leave no rib of that thickness at rest", True
        return found
    low, high = ranges[spec.machine.sought]
    size = _pressed(spec, found, rollers, deadline, tighten)
    if size is None:
        return found
    if found.lower > high * (1.0 + EXACT):
        found.why, found.proven = "the cam would have to be larger", True
        return found
    if low > found.lower:
        found.lower, found.over = low, "the range of the dimension itself"
    # a little larger, so that the judge need not resolve what is nothing to whoever asks
    size = max(size * (1.0 + SLACK * spec.tolerance), low)
    if size > high:
        if size > high * (1.0 + CLEAR + SLACK * spec.tolerance):
            found.why = "no cam so small was found"
            return found
        size = high
    sizes = {**rollers, spec.machine.sought: size}
    if quick:
        found.sizes = sizes
    else:
        _sound(spec, found, sizes, ranges, tighten, ribs=ribs)
    return found


def _pressed(
    spec: SpatialCamSpec, found: Sized, rollers: Sizes, deadline: float, tighten: float
) -> float | None:
    """The smallest size under limits on pressure angle and motion, and the laws for it."""
    machine = spec.machine
    # demands of windows and points are limits of single segments
    demands = [d for i, segment in enumerate(spec.program) for d in segment.demands(i)]
    limits = [*(limit for limit in spec.limits if limit.quantity != WALLS), *demands]
    radius = least_of(spec.limits, WALLS)
    objective = objective_of(machine.sought)
    problem = posed(machine, found.stretches, spec.omega, limits, objective, rollers, spec.turns)
    walls = WallRadius(min_mm=radius)
    whole = replace(problem, limits=(*problem.limits, walls))
    if not problem.free:
        return _closed_form(whole, found)
    search = _searched(problem, found, spec.tolerance, deadline, tighten)
    best = search.best
    if best is None:
        found.proven = search.infeasible
        found.why = search.impossible or search.undecided or "no motion law was found"
        return None
    if not _kept(problem, walls, best):
        bulging = _searched(whole, found, spec.tolerance, deadline, tighten)
        best = bulging.best or best
    _settle(found, problem, best)
    return best.size[0]


def _searched(
    problem: Problem, found: Sized, tolerance: float, deadline: float, tighten: float
) -> Search:
    """A search whose stages and bound are told; bounds without limits on walls hold with them."""
    if problem.curved:
        search = squeezed(problem, tolerance, deadline, tighten)
    else:  # linear in motion and size together, as a translating roller's
        search = climbed(problem, tolerance, deadline, tighten)
    found.stages += search.stages
    if search.lower > found.lower:
        found.lower, found.over = search.lower, search.over
    return search


def _kept(problem: Problem, walls: WallRadius, cam: Candidate) -> bool:
    """Whether the walls of a cam are as they shall be, as far as limits on them are known."""
    asked = replace(problem, limits=(walls,), stretches=cam.problem.stretches)
    return not np.any(tightest(asked, cam.size).excess > 0.0)


def _closed_form(problem: Problem, found: Sized) -> float | None:
    began = time.perf_counter()
    exact, clear = nearest(problem), nearest(problem, CLEAR)
    seconds = time.perf_counter() - began
    found.stages.append(Stage("closed form", "half-planes", "none", 1, 0, 0, seconds, "solved"))
    if exact is None or clear is None:
        found.why, found.proven = "the given laws break a limit on the motion", True
        return None
    found.lower, found.over = exact[0] * (1.0 - EXACT), "every size of the given laws"
    return clear[0]


def _settle(found: Sized, problem: Problem, cam: Candidate) -> None:
    """The laws that were found in the program's own unit."""
    laws: dict[int, SettledLaw] = {
        stretch.index: law for stretch, law in zip(problem.free, cam.laws, strict=True)
    }
    found.stretches = tuple(
        stretch.with_law(laws[stretch.index].curve()) if stretch.index in laws else stretch
        for stretch in found.stretches
    )
    found.splines = {
        **found.splines,
        **{index: (law.space, law.coefficients) for index, law in laws.items()},
    }


def _sound(
    spec: SpatialCamSpec,
    found: Sized,
    sizes: Sizes,
    ranges: Mapping[str, tuple[float, float]],
    tighten: float,
    *,
    ribs: bool,
) -> None:
    """Grow the cam until walls and ribs are sound, then the rollers."""
    began, machine = time.perf_counter(), spec.machine
    rib = least_of(spec.limits, "rib_thickness")
    radius = least_of(spec.limits, WALLS)
    sound = Soundness(spec, found.motion, radius, rib, max(SPARE, 20.0 * tighten))
    high = min(ranges[machine.sought][1], LARGEST)
    whole = grown(sound, sizes, high, ribs=ribs)
    if whole is None:
        found.why, found.cramped = "no cam so small has sound walls and ribs", True
        return
    grown_by = whole[machine.sought] / sizes[machine.sought] - 1.0
    largest = _largest_radius(machine, whole, ranges, rib)
    found.sizes = enlarged(sound, whole, largest)
    note = f"grown by {grown_by:.3g} for walls and ribs" if grown_by > 0.0 else ""
    found.stages.append(
        Stage("walls", "sampled", "none", 1, 0, 0, time.perf_counter() - began, "solved", note)
    )


def least_of(limits: Sequence[AnySpatialLimit], quantity: str) -> float:
    """The largest least value that limits ask of a quantity [mm]; 0 where none does."""
    asked = [each.bound for each in limits if each.quantity == quantity and not each.upper]
    return max(asked, default=0.0)


def least_rollers(
    machine: SpatialMachine, ranges: Mapping[str, tuple[float, float]], rib: float
) -> Sizes | None:
    """The smallest rollers nearest to the turret's axis; None where ribs at rest are too thin.

    ``rib``: least thickness [mm].
    """
    found = {name: low for name, (low, _) in ranges.items() if name != machine.sought}
    place = machine.place_field
    for name, low in found.items():
        if low <= 0.0:
            found[name] = TINY
    if not place:
        return found if machine.rest_rib(found) >= rib * (1.0 - EXACT) else None

    def missing(at: float) -> float:
        return rib + ROOM * at - machine.rest_rib({**found, place: at})

    if missing(found[place]) <= 0.0:
        return found
    high = min(ranges[place][1], LARGEST)
    if missing(high) > EXACT * high:
        return None
    root = float(brentq(missing, found[place], high)) if missing(high) < 0.0 else high
    return {**found, place: min(root * (1.0 + CLEAR), high)}


def _largest_radius(
    machine: SpatialMachine, sizes: Sizes, ranges: Mapping[str, tuple[float, float]], rib: float
) -> float:
    """The largest radius of the rollers that leaves ribs at rest [mm]."""
    name = machine.roller_field
    low, high = sizes[name], min(ranges[name][1], LARGEST)

    def spare(radius: float) -> float:
        return machine.rest_rib({**sizes, name: radius}) - rib - ROOM * radius

    if high <= low or spare(high) >= 0.0:
        return max(low, high)
    return float(brentq(spare, low, high)) * (1.0 - CLEAR) if spare(low) > 0.0 else low
