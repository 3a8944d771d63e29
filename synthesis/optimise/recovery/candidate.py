"""From a solver's point to a cam: laws fixed, size fitted to them, objective measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import sqrt

from synthesis.catalogue.constraints import enlarged, enlarged_to
from synthesis.optimise.conic.linear_rows import row_excess
from synthesis.optimise.problem.grid import SplineLaw, law_curves
from synthesis.optimise.problem.mean_square import mean_square
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.closed_form import closed_form_size
from synthesis.optimise.recovery.smooth_limits import enlarged_size

Vector = tuple[float, ...]
ALLOWED = 1e-9  # relative excess of a row that is solver noise
OUTSIDE = 1e-7  # relative: what a solver may leave a cone by
BEYOND_CAP = 1e-4  # relative: what tightened limits may take of an earlier objective's cap
CLEARANCE = 1e-8  # relative: sizes and smooth limits stay this far off what binds them


@dataclass(frozen=True, eq=False)
class Candidate:
    """A cam of the optimiser: laws, size and value, not yet certified.

    Attributes:
        problem: the question with these laws fixed. laws: one per free segment.
        size: size variables [length]. value: the objective in problem units.
        fitted: the size meets every row that speaks of it, all along the laws, but for what
            growing costs in the last size variable.
    """

    problem: Problem
    laws: tuple[SplineLaw, ...]
    size: Vector
    value: float
    fitted: bool = False


def recover_cam(
    problem: Problem, laws: Sequence[SplineLaw], size: Vector, *, keep_size: bool = False
) -> Candidate:
    """The cam of these laws: the least that their rows allow, limits that are not convex left out.

    Args:
        problem: the problem. laws: one per free segment.
        size: the solver's, used where the least one has no closed form.
        keep_size: whether the solver's is used in any case.
    """
    placed = [s.with_law(curve) for s, curve in zip(problem.free, law_curves(laws), strict=True)]
    fixed = problem.with_laws(placed)
    least = None if keep_size or weighs_size(problem) else smallest_size(fixed)
    cam = cam_at_size(fixed, laws, size if least is None else least)
    # it may have grown since: that eases some rows, and others are looked at again
    only_enlarged = least is not None and cam.size[:-1] == least[:-1] and cam.size[-1] >= least[-1]
    return replace(cam, fitted=only_enlarged)


def cam_at_size(problem: Problem, laws: Sequence[SplineLaw], size: Vector) -> Candidate:
    """The cam with this size, raised to the least prime radius and off the rows that bind it."""
    follower, size = problem.machine.follower, project_size(problem, size)
    clear = CLEARANCE * follower.radius_norm().value(size)
    if not _is_least_and_off_rows(problem, size, clear):
        size = enlarged(size, min(clear, problem.max_enlargement(size)))
    return Candidate(problem, tuple(laws), size, objective_value(problem, size))


def _is_least_and_off_rows(problem: Problem, size: Vector, clear: float) -> bool:
    """Whether a size is as small as any may be, and no row binds it.

    Then it is that size that is asked for: of a tiny cam what is added would be a multiple of it.
    """
    norm, ends = problem.machine.follower.radius_norm(), problem.sizing.bounds[-1]
    least = problem.searched_norm * (1.0 + ALLOWED)
    if norm.value(size) > least and size[-1] > ends[0]:
        return False
    rows = ((row, s) for s in problem.segments for row in problem.limit_rows(s) if any(row.size))
    return all(row_excess(row, s, size) < -clear * max(map(abs, row.size)) for row, s in rows)


def project_size(problem: Problem, size: Vector) -> Vector:
    """The size within its bounds and cones, which a solver keeps to its tolerance only."""
    bounds, cones = problem.sizing.bounds, problem.norm_bounds
    size = tuple(min(max(v, low), high) for v, (low, high) in zip(size, bounds, strict=True))
    # back into cones that it has left by no more than the solver's tolerance
    outside = [cone for cone in cones if cone.norm.value(size) > cone.upper]
    steps = [(-cone.norm.growth(size, cone.upper), OUTSIDE * cone.upper) for cone in outside]
    inwards = max((step for step, most in steps if 0.0 < step <= most), default=0.0)
    norm = problem.machine.follower.radius_norm()
    size = enlarged_to(enlarged(size, -inwards), norm, problem.searched_norm)
    return enlarged(size, max((cone.growth_to_lower(size) for cone in cones), default=0.0))


def enlarge_for_rows(cam: Candidate) -> Candidate:
    """The cam raised until rows hold that a solver kept at points only, where that mends them."""
    problem, follower = cam.problem, cam.problem.machine.follower
    unit = enlarged(cam.size, 1.0)
    needed = 0.0
    for segment in problem.segments:
        for row in problem.limit_rows(segment):
            each = zip(row.size, unit, cam.size, strict=False)
            gain = -sum(a * (new - old) for a, new, old in each)
            if gain > 0.0:
                needed = max(needed, row_excess(row, segment, cam.size) / gain)
    if needed == 0.0:
        return cam
    # and by more than the certificate's enclosures are wide, or that could not tell
    clear = CLEARANCE * follower.radius_norm().value(cam.size)
    needed = (1.0 + CLEARANCE) * needed + clear
    size = enlarged(cam.size, min(needed, problem.max_enlargement(cam.size)))
    return replace(cam, size=size, value=objective_value(problem, size))


def given_cam(problem: Problem) -> Candidate | None:
    """The cam that is given down to its size, whatever limits it breaks; None if any is free."""
    if problem.free or any(low != high for low, high in problem.sizing.bounds):
        return None
    size = tuple(low for low, _ in problem.sizing.bounds)
    return Candidate(problem, (), size, objective_value(problem, size))


def enlarge_until_feasible(cam: Candidate, *, densely: bool = False) -> Candidate | None:
    """The cam raised until the limits that are not convex hold; None where none allowed does."""
    problem = cam.problem
    size = enlarged_size(problem, cam.size, CLEARANCE, densely=densely)
    if size is None or _is_out_of_bounds(problem, size):
        return None
    if size == cam.size:
        return cam
    return replace(cam, size=size, value=objective_value(problem, size))


def _is_out_of_bounds(problem: Problem, size: Vector) -> bool:
    """Whether enlarging a cam has violated what it does not ease: rows of a counter roller, which
    comes nearer as the main cam grows, the cone of another distance, the range of an angle, or an
    earlier objective.
    """
    if not problem.machine.follower.allows(size):
        return True
    if any(cap.excess(size, problem.machine) > BEYOND_CAP for cap in problem.objective_caps):
        return True
    cones = problem.norm_bounds
    if any(cone.lower > 0.0 for cone in cones) and any(
        cone.norm.value(size) > cone.upper * (1.0 + OUTSIDE) for cone in cones
    ):
        return True
    return bool(problem.machine.follower.closure.counter_paths) and any(
        row_excess(row, segment, size) > ALLOWED * max(map(abs, row.size)) * problem.length
        for segment in problem.segments
        for row in problem.limit_rows(segment)
        if row.size
    )


def weighs_size(problem: Problem) -> bool:
    """Whether the objective weighs the size otherwise than by making it small."""
    return any(
        row.size
        for segment in problem.segments
        for row in problem.objective.rows(segment, problem.machine, 1.0)
    )


def smallest_size(problem: Problem) -> Vector | None:
    """The closed form's size; None where there is none, or a cone cuts it off."""
    # a curved limit's half-planes hold at one angle each: raising the size may break others
    clear = 3.0 * CLEARANCE if problem.has_curved_limits else 0.0
    size = closed_form_size(problem, clear, least=problem.searched_norm)
    if size is None:
        return None
    if any(not cone.lower <= cone.norm.value(size) <= cone.upper for cone in problem.norm_bounds):
        return None
    follower = problem.machine.follower
    pinning = follower.fixable_dimension()
    if pinning is None or not problem.has_curved_limits:
        return size
    small = follower.radius_norm().value(size) < problem.searched_norm
    return None if small or not pinning.low <= pinning.value_in(size) <= pinning.high else size


def objective_value(problem: Problem, size: Vector) -> float:
    """The objective of a finished cam, in problem units."""
    objective, machine = problem.objective, problem.machine
    norm, order = objective.norm(machine), objective.energy_order()
    if norm is not None:
        return norm.value(size)
    if order is not None:
        return sqrt(sum(mean_square(s.placed(), order) for s in problem.segments))
    if objective.equivalent_limits(1.0, machine):  # on an arm: no rows say it
        return max(objective.segment_value(s, machine, size) for s in problem.segments)
    return _fractional_value(problem, size) if objective.quasiconvex else _level(problem, size, 0.0)


def _level(problem: Problem, size: Vector, trial: float) -> float:
    """The least P that satisfies the objective's rows."""
    return max(
        row_excess(row, segment, size) / -row.level
        for segment in problem.segments
        for row in problem.objective.rows(segment, problem.machine, trial)
    )


def _fractional_value(problem: Problem, size: Vector) -> float:
    """The trial level at which the rows of a fractional objective are just met.

    P(t) is convex and falls with t, so Newton's method from below climbs to the root.
    """
    trial, step = 0.0, 1e-6
    for _ in range(60):
        excess = _level(problem, size, trial)
        slope = (_level(problem, size, trial + step) - excess) / step
        if slope >= 0.0:
            break
        move = -excess / slope
        trial += move
        if abs(move) <= 1e-14 * max(trial, 1.0):
            break
    return trial
