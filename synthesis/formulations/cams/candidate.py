"""From a solver's point to a cam: laws settled, size fitted to them, objective measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import sqrt

from synthesis.formulations.cams.closed_form import nearest
from synthesis.formulations.cams.smooth import grown
from synthesis.formulations.cone.rows import exceeded
from synthesis.formulations.question.energy import mean_square
from synthesis.formulations.question.grid import SettledLaw, curves
from synthesis.formulations.question.problem import Problem

Vector = tuple[float, ...]
ALLOWED = 1e-9  # relative excess of a row that is solver noise
OUTSIDE = 1e-7  # relative: what a solver may leave a cone by
CLEARANCE = 1e-8  # relative: sizes and smooth limits stay this far off what binds them


@dataclass(frozen=True, eq=False)
class Candidate:
    """A cam that the formulations hold for good.

    Attributes:
        problem: the question with these laws settled.
        laws: one per free stretch.
        size: size variables [mm].
        value: the objective in core units.
        fitted: the size meets every row that speaks of it, all along the laws, but for what
            growing costs in the last size variable.
    """

    problem: Problem
    laws: tuple[SettledLaw, ...]
    size: Vector
    value: float
    fitted: bool = False


def settle(
    problem: Problem, laws: Sequence[SettledLaw], hint: Vector, *, keep_hint: bool = False
) -> Candidate:
    """The cam of the relaxation: limits that are not convex are not looked at.

    Args:
        problem: the question, laws free.
        laws: one per free stretch.
        hint: the solver's size; used where the closed form does not apply.
        keep_hint: take the hint even where the closed form applies.
    """
    placed = [s.with_law(curve) for s, curve in zip(problem.free, curves(laws), strict=True)]
    settled = problem.settled(placed)
    size = None if keep_hint or needs_size(problem) else smallest(settled)
    found = at_size(settled, laws, hint if size is None else size)
    # it may have grown since: that eases some rows, and others are looked at again
    grown = size is not None and found.size[:-1] == size[:-1] and found.size[-1] >= size[-1]
    return replace(found, fitted=grown)


def at_size(settled: Problem, laws: Sequence[SettledLaw], size: Vector) -> Candidate:
    """The cam with this size, raised to the least prime radius and off the rows that bind it."""
    follower, size = settled.machine.follower, inside(settled, size)
    clear = CLEARANCE * follower.prime_radius().value(size)
    size = follower.raised(size, min(clear, settled.room(size)))
    return Candidate(settled, tuple(laws), size, value(settled, size))


def inside(problem: Problem, size: Vector) -> Vector:
    """The size within its bounds and cones, which a solver keeps to its tolerance only."""
    follower, bounds = problem.machine.follower, problem.sizing.bounds
    size = tuple(min(max(v, low), high) for v, (low, high) in zip(size, bounds, strict=True))
    size = follower.raised(size, -_outside(problem, size))
    size = follower.reaching(size, problem.sizing.least)
    return follower.raised(size, max((cone.short(size) for cone in problem.cones), default=0.0))


def mended(found: Candidate) -> Candidate:
    """The cam raised until rows hold that a solver kept at points only, where that mends them."""
    settled, follower = found.problem, found.problem.machine.follower
    unit = follower.raised(found.size, 1.0)
    needed = 0.0
    for stretch in settled.stretches:
        for row in settled.limit_rows(stretch):
            each = zip(row.size, unit, found.size, strict=False)
            gain = -sum(a * (new - old) for a, new, old in each)
            if gain > 0.0:
                needed = max(needed, exceeded(row, stretch, found.size) / gain)
    if needed == 0.0:
        return found
    # and by more than the certificate's enclosures are wide, or that could not tell
    clear = CLEARANCE * follower.prime_radius().value(found.size)
    needed = (1.0 + CLEARANCE) * needed + clear
    size = follower.raised(found.size, min(needed, settled.room(found.size)))
    return replace(found, size=size, value=value(settled, size))


def given_size(problem: Problem) -> Candidate | None:
    """The cam that is given down to its size, whatever limits it breaks; None if any is free."""
    if problem.free or any(low != high for low, high in problem.sizing.bounds):
        return None
    size = tuple(low for low, _ in problem.sizing.bounds)
    return Candidate(problem, (), size, value(problem, size))


def grow(found: Candidate, *, closely: bool = False) -> Candidate | None:
    """The cam raised until the limits that are not convex hold; None where none allowed does.

    ``closely``: as in ``grown``.
    """
    size = grown(found.problem, found.size, CLEARANCE, closely=closely)
    if size is None or (found.problem.machine.follower.companions and breaks(found.problem, size)):
        return None
    if _pushed_out(found.problem, size):
        return None
    return (
        found if size == found.size else replace(found, size=size, value=value(found.problem, size))
    )


def _outside(settled: Problem, size: Vector) -> float:
    """How far a size sticks out of a cone, if it is no more than a solver may leave it by [mm]."""
    left = (cone for cone in settled.cones if cone.norm.value(size) > cone.radius)
    inwards = [(-cone.step(size), OUTSIDE * cone.radius) for cone in left]
    return max((step for step, most in inwards if 0.0 < step <= most), default=0.0)


def _pushed_out(settled: Problem, size: Vector) -> bool:
    """Whether a size that was raised for a least distance has left another cone for it."""
    if not any(cone.least > 0.0 for cone in settled.cones):
        return False
    return any(cone.norm.value(size) > cone.radius * (1.0 + OUTSIDE) for cone in settled.cones)


def breaks(settled: Problem, size: Vector) -> bool:
    """Whether a row is broken at this size: a counter roller comes nearer as the main cam grows."""
    return any(
        exceeded(row, stretch, size) > ALLOWED * max(map(abs, row.size)) * settled.length
        for stretch in settled.stretches
        for row in settled.limit_rows(stretch)
        if row.size
    )


def needs_size(problem: Problem) -> bool:
    """Whether the objective weighs the size otherwise than by making it small."""
    rows = (
        row
        for stretch in problem.stretches
        for row in problem.objective.rows(stretch, problem.machine, 1.0)
    )
    return any(row.size for row in rows)


def smallest(settled: Problem) -> Vector | None:
    """The closed form's size; None where there is none, or a cone cuts it off."""
    # a curved limit's half-planes hold at one angle each: raising the size may break others
    size = nearest(settled, 3.0 * CLEARANCE if settled.curved else 0.0)
    if size is None:
        return None
    if any(not cone.least <= cone.norm.value(size) <= cone.radius for cone in settled.cones):
        return None
    follower = settled.machine.follower
    pinning = follower.pinning()
    if pinning is None or not settled.curved:
        return size
    small = follower.prime_radius().value(size) < settled.sizing.least
    return None if small or not pinning.low <= pinning.of(size) <= pinning.high else size


def value(settled: Problem, size: Vector) -> float:
    """The objective of a finished cam, in core units."""
    objective, machine = settled.objective, settled.machine
    norm, order = objective.norm(machine), objective.energy_order()
    if norm is not None:
        return norm.value(size)
    if order is not None:
        return sqrt(sum(mean_square(s.placed(), order) for s in settled.stretches))
    if objective.limits(1.0, machine):  # on an arm: no rows say it
        return max(objective.worst(s, machine, size) for s in settled.stretches)
    return _fraction(settled, size) if objective.fractional else _level(settled, size, 0.0)


def _level(settled: Problem, size: Vector, trial: float) -> float:
    """The least P that satisfies the objective's rows."""
    return max(
        exceeded(row, stretch, size) / -row.level
        for stretch in settled.stretches
        for row in settled.objective.rows(stretch, settled.machine, trial)
    )


def _fraction(settled: Problem, size: Vector) -> float:
    """The trial level at which the rows of a fractional objective are just met.

    P(t) is convex and falls with t, so Newton's method from below climbs to the root.
    """
    trial, step = 0.0, 1e-6
    for _ in range(60):
        excess = _level(settled, size, trial)
        slope = (_level(settled, size, trial + step) - excess) / step
        if slope >= 0.0:
            break
        move = -excess / slope
        trial += move
        if abs(move) <= 1e-14 * max(trial, 1.0):
            break
    return trial
