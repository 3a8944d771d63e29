"""Why nothing fits: an irreducible set of limits in conflict, and what each alone would have to be.

Every limit may be exceeded, at a price: that the least total is not zero proves the conflict on
the given grids. Leaving out one limit after the other, for good where the rest still cannot hold,
leaves an irreducible set (Chinneck's deletion filter).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace
from math import inf

import numpy as np

from synthesis.catalogue.limits import Claim
from synthesis.catalogue.ranges import ends
from synthesis.design.design import Conflict, Relaxation
from synthesis.errors import SolverFailed
from synthesis.numerics import clock
from synthesis.numerics.solvers.clarabel import solve
from synthesis.numerics.solvers.statuses import StopReason
from synthesis.optimise.conic.linear_rows import Tightening
from synthesis.optimise.conic.program import formulate
from synthesis.optimise.infeasibility.diagnosis_by_search import diagnose_by_search
from synthesis.optimise.infeasibility.given_motion import (
    GivenMotionConflict,
    given_motion_conflicts,
)
from synthesis.optimise.infeasibility.least_relaxation import least_value
from synthesis.optimise.infeasibility.relaxable import Relaxable
from synthesis.optimise.infeasibility.relaxable_problem import (
    NOTHING,
    OutOfTime,
    RelaxableProblem,
    solve_elastic,
)
from synthesis.optimise.infeasibility.relaxable_sizes import OPEN, harmed_by_size
from synthesis.optimise.problem.grid import Grid
from synthesis.optimise.problem.problem import Problem
from synthesis.spec.design_spec import DesignSpec

Reached = Callable[[Claim], float | None]
LATE = "the time budget ended before this was known"
ALONE = "relaxing this limit alone cannot help"
BEST = "what the best cam found comes to, not proven least"
EACH = "leaving out any one of those named, the others can hold"
ENOUGH = 2e-6  # relative: by how much what is needed is told larger than the cone program has it
SPARE = 2e-3  # relative: what limits that just touch must leave for a cam to be found and proven


def diagnose(
    spec: DesignSpec,
    problem: Problem,
    grids: Sequence[Grid],
    reached: Reached | None = None,
    deadline: float = inf,
) -> Conflict:
    """Why nothing fits, and the least relaxation of every limit alone that would help.

    Args:
        spec: what was asked. problem: as posed. grids: where the search ended, one per free law.
        reached: for a claim that is not convex, the extreme that the best cam found comes to
            [core units]; None where there is no such cam.
        deadline: ``time.monotonic()`` after which no further relaxation is looked for.
    """
    if problem.has_curved_limits or problem.base_circle_conflict:
        return diagnose_by_search(spec, deadline)
    scene = replace(RelaxableProblem.of(spec, problem, grids), deadline=deadline)
    given = given_motion_conflicts(scene.parts, problem)
    members, evidence = _conflict(scene, given, problem)
    if not members:
        scene = replace(scene, drawn=SPARE)
        members, evidence = _conflict(scene, given, problem)
        evidence = f"the limits only just fit: {SPARE:.1%} tighter they do not; {evidence}"
    if not members:
        return _not_convex(spec, problem, reached)
    relaxations = [
        relaxation
        for k in range(len(scene.parts))
        for relaxation in _relaxations(scene, k, members, given, deadline)
    ]
    words = [scene.parts[k].words for k in sorted(members)]
    evidence += _as_far_as(spec, scene, members)
    return Conflict(limits=words, relaxations=relaxations, evidence=evidence)


def _conflict(
    scene: RelaxableProblem, given: dict[int, GivenMotionConflict], problem: Problem
) -> tuple[set[int], str]:
    """The parts that cannot hold together, none if all can, and how that is known."""
    members = set(given)
    evidence = [f"{scene.parts[k].words}: {why.note}" for k, why in given.items()]
    every = range(len(scene.parts))
    try:
        found = solve_elastic(scene, scene.model(), every, exact=False)
    except OutOfTime:
        return set(every), "; ".join([*evidence, LATE])
    if found is None and problem.has_curved_limits:
        return members, "; ".join([*evidence, "no elastic program has a point"])
    if found is None:
        raise SolverFailed("Clarabel", "failed", "The elastic program gave no usable point.")
    if found.total > NOTHING:
        order = [int(k) for k in np.argsort(found.amounts, kind="stable")]
        least, whole = irreducible(scene, order)
        members |= least
        evidence.append(_proof(scene, problem, found.total, whole))
    return members, "; ".join(evidence)


def irreducible(scene: RelaxableProblem, order: Sequence[int]) -> tuple[set[int], bool]:
    """Parts that cannot hold together, though all but any one of them can.

    Args:
        scene: one in which nothing fits.
        order: its parts; those named first are tried first to be left out.

    Returns:
        the parts, and whether every one of them was tried before the scene's deadline.
    """
    kept = set(order)
    for part in order:
        if clock.now() >= scene.deadline:
            return kept, False
        try:
            if not holds(scene, kept - {part}):
                kept.discard(part)
        except OutOfTime:
            return kept, False
    return kept, True


def holds(scene: RelaxableProblem, parts: Collection[int]) -> bool:
    """Whether these parts can hold together."""
    dropped = set(range(len(scene.parts))) - set(parts)
    found = solve_elastic(scene, scene.model(), sorted(parts), dropped, exact=False)
    return found is not None and found.total <= NOTHING


def _proof(scene: RelaxableProblem, problem: Problem, total: float, whole: bool) -> str:
    stopped = solve(formulate(problem, scene.grids, 0.0, Tightening(scene.drawn)).program).stopped
    certified = "; Clarabel certifies that the program as asked is infeasible"
    chosen = "cam and splines on its knots are" if problem.free else "the cam is"
    return (
        f"elastic cone program: however {chosen} chosen, limits are exceeded by {total:.3g} "
        "(sum of relative excesses); "
        f"{EACH if whole else LATE}"
        f"{certified if stopped is StopReason.INFEASIBLE else ''}"
    )


def _as_far_as(spec: DesignSpec, scene: RelaxableProblem, members: Collection[int]) -> str:
    """Up to which size a conflict was looked at, where a cam larger still would end it."""
    names = {scene.parts[k].name for k in members}
    eased = any(block.source in names and block.size.any() for block in scene.model().blocks)
    if not eased or harmed_by_size(scene.problem) or ends(spec.base_radius_mm)[1] < inf:
        return ""
    return (
        f"; looked at were base radii up to {spec.base_radius_range()[1]:.6g} mm, {OPEN:.0f} "
        "strokes: for larger ones give base_radius_mm a max"
    )


def _relaxations(
    scene: RelaxableProblem,
    position: int,
    members: Collection[int],
    given: dict[int, GivenMotionConflict],
    deadline: float,
) -> Iterator[Relaxation]:
    """What one part alone would have to be, field by field."""
    part, needed = scene.parts[position], None
    block = given.get(position)
    alone = position in members and not set(given) - {position}
    late = clock.now() >= deadline
    if alone and not late and (block is None or block.value is not None):
        try:
            needed = least_value(scene, position)
        except OutOfTime:
            late = True
    if needed is not None and scene.drawn == SPARE:
        needed = part.eased(needed, 2.0 * SPARE)
    elif needed is not None and block is None:  # asked for as it is told, it must do
        needed = part.eased(needed, ENOUGH)
    tight = [m for m in part.members if needed is None or _tighter(part, m.requested, needed)]
    note = (
        block.note
        if block is not None
        else part.hint
        if needed is not None
        else LATE
        if late
        else ALONE
    )
    if needed is not None and len(tight) > 1:
        note = "all limits of this name together"
    for member in tight:
        yield Relaxation(
            limit=part.name, field=member.field, unit=part.unit, requested=member.requested,
            needed=needed, note=note,
        )  # fmt: skip


def _tighter(part: Relaxable, asked: float, needed: float) -> bool:
    """Whether a member's value does not allow yet what is needed."""
    return part.tighter(asked, needed) if len(part.members) > 1 else asked != needed


def _not_convex(spec: DesignSpec, problem: Problem, reached: Reached | None) -> Conflict:
    """The limits that neither rows nor cones state, and what the best cam found makes of them."""
    relaxations: list[Relaxation] = []
    segments, machine = problem.segments, problem.machine
    for position, limit in enumerate(problem.limits):
        curved = any(limit.nonconvex(s, machine) for s in segments)
        linear = any(limit.rows(s, machine) for s in segments) or limit.norm_bounds(
            segments, machine
        )
        if linear and not curved and not limit.rows_incomplete:
            continue
        asked_for = position < len(spec.limits)
        for claim in limit.claims(segments, machine):
            extreme = reached(claim) if reached is not None else None
            name = claim.field.rpartition("/")[2]
            relaxations.append(
                Relaxation(
                    limit=claim.limit,
                    field=f"limits/{position}/{name}" if asked_for else "limits",
                    unit=claim.unit,
                    requested=float(getattr(limit, name)),
                    needed=None if extreme is None else claim.to_wire(extreme),
                    note="the least relaxation is not known" if extreme is None else BEST,
                )
            )
    return Conflict(
        limits=[f"{r.limit.replace('_', ' ')}: {r.requested:.6g} {r.unit}" for r in relaxations],
        relaxations=relaxations,
        evidence="the other limits can hold together (elastic cone program: no excess); that "
        "these cannot be kept as well is not proven: no cam was found. A larger cam eases them",
    )
