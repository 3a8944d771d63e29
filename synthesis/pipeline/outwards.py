"""A first value of a number that suffices: outwards from the request.

The secant of the excess from the requested value on; of a cap on a peak the least peak itself;
where these do not help, a cam without the number says which value suffices.
"""

from __future__ import annotations

from math import copysign, inf

from synthesis.catalogue.objectives import BaseRadius, Objective, PeakAcceleration, PeakJerk
from synthesis.pipeline.boundary import LATE, SPARE, Boundary
from synthesis.pipeline.oracle import ALONE, COARSE
from synthesis.pipeline.relaxable import without

STEPS = 8  # of the secant outwards
STRIPS, BEYOND_STRIP = 3, 1.5
"""Steps outwards, and the factor of each, where a trial finds neither a cam nor an excess."""
FALLING = 0.9  # of the excess before: where less is gained the number does not help in proportion
AHEAD = 2.0  # of the way so far: where the secant's zero lies farther ahead it may not end
OBJECTIVE_OF: dict[str, Objective] = {"acceleration": PeakAcceleration(), "jerk": PeakJerk()}
"""What makes the quantity of a limit small, by the limit's name."""


def seek_value(boundary: Boundary) -> None:
    """Find a value that suffices, and confirm it."""
    number, smallest = boundary.number, boundary.original.smallest
    try:
        if number.minimised and smallest is not None:
            boundary.take(smallest)
        else:
            _ = _minimise(boundary) or _step_outwards(boundary) or _leave_out(boundary)
    except TimeoutError:
        boundary.note = LATE
    boundary.confirm()


def _step_outwards(boundary: Boundary) -> bool:
    """Whether a value that suffices is found by the secant of the excess."""
    before = value = boundary.number.tightest
    excess = boundary.requested_excess
    if boundary.number.sense in "=±" or excess is None or value == 0.0:
        return False
    way, strips = (excess + COARSE) * abs(value) / boundary.number.power, 0
    for _ in range(STEPS):
        value, farthest = boundary.value_at(way), boundary.number.farthest
        if farthest is not None and way >= boundary.way_to(farthest):
            return boundary.tried(farthest).certified
        if not boundary.oracle.is_valid(boundary.number, value):
            return False
        trial = boundary.tried(value)
        if trial.certified:
            return True
        if trial.excess is None and strips < STRIPS:
            way, strips = BEYOND_STRIP * way, strips + 1  # next to the least value: beyond it
            continue
        if trial.excess is None or trial.excess > FALLING * excess:
            return False
        fall = (excess - trial.excess) / abs(value - before)
        ahead = (trial.excess + COARSE) / fall
        # Trials become dearer as limits are relaxed: does anything suffice at all?
        far = farthest is None and ahead > AHEAD * way
        if far and not boundary.oracle.without([boundary.number]).certified:
            return False
        way += ahead
        before, excess = value, trial.excess
    return False


def _minimise(boundary: Boundary) -> bool:
    """Whether the least value is found by making it the objective, which bounds it as well."""
    objective = OBJECTIVE_OF.get(boundary.number.limit)
    spec = boundary.oracle.spec
    if objective is None or boundary.number.paths[0].startswith("program"):
        return False
    low, high = spec.requested_radii()
    if low < high < inf:  # the smallest cam is a sharper measure
        return False
    trial = boundary.oracle.ask(without(spec, [boundary.number]), boundary.fine, objective)
    if not trial.certified:
        return False
    if trial.lower is not None:
        boundary.exclude(trial.lower)
    least, _ = boundary.oracle.value_on(boundary.number, trial)
    if least is None:
        return False
    for spare in SPARE[1]:
        value = least * (1.0 + spare)
        if boundary.tried(value).certified:
            boundary.levels[value] = 0.0  # no nearer one is sought
            return True
    return False


def _leave_out(boundary: Boundary) -> bool:
    """Whether a cam without the number shows a value that suffices."""
    if boundary.oracle.is_late():
        raise TimeoutError
    if boundary.number.farthest is not None:  # an excess, if it is known, says more
        far = boundary.number.farthest
        return boundary.requested_excess is None and boundary.tried(far).certified
    if boundary.number.dimension:  # its value on the smallest cam, not on any
        open_spec = without(boundary.oracle.spec, [boundary.number])
        trial = boundary.oracle.ask(open_spec, COARSE, BaseRadius(), cam_only=True)
    else:
        trial = boundary.oracle.without([boundary.number])
    if not trial.certified:
        boundary.note = ALONE if trial.on_time else LATE
        return False
    reached, note = boundary.oracle.value_on(boundary.number, trial)
    boundary.note = note or ALONE
    if reached is None:
        return False
    if boundary.number.sense == "=":
        boundary.direction = copysign(1.0, reached - boundary.number.tightest)
    boundary.record(reached, trial)  # that cam keeps it
    return True
