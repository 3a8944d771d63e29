"""Why nothing fits: an irreducible conflict, and what each number in it would have to be alone.

The pipeline itself is the oracle: a question with some numbers left out or relaxed has a certified
cam, or it is proven that it has none, or neither is known. So everything named here is shown by a
cam, and what is claimed to be impossible is proven.

    1. Each number alone: a value of it that suffices, all others kept (``boundary``). Where there
       is one, every set of numbers without a cam has this number in it.
    2. These numbers by themselves: where they have no cam, they are the conflict. Else a deletion
       filter (Chinneck) over the others: leave out one after the other, for good where the rest
       still has no cam.
    3. The bounds: which values of each are proven impossible.
    4. Changes of the program that mend it.
    5. With the time that is left, both ends of the members' values once more, by longer proofs
       (``longer_proofs``).
    6. What the certificate refused on the cam at hand.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf

from synthesis.catalogue.fields import ends
from synthesis.design.design import Conflict, Relaxation
from synthesis.numerics import clock
from synthesis.pipeline.attempt import Attempt
from synthesis.pipeline.boundary import ROUGH, Boundary
from synthesis.pipeline.largest_radius import Smallest
from synthesis.pipeline.longer_proofs import close_in
from synthesis.pipeline.oracle import FINE, Oracle, Trial
from synthesis.pipeline.outwards import seek_value
from synthesis.pipeline.program_numbers import program_numbers
from synthesis.pipeline.relaxable import Relaxable, relaxable_numbers
from synthesis.spec.design_spec import DesignSpec

MOST_PROGRAMS = 1000
"""Programs that a conflict may solve where the spec gives no time: 10 to 30 s. Counted, so that the
answer is the same on every machine; most conflicts take 100 to 700."""
ACCURACIES = 2.5e-3, 2.5e-4
"""Shares of the way to which both ends of the members' values are brought, one after the other: all
of them come near before any comes nearer."""
CHANGES_PARTS, PARTS_BEFORE_LONGER_PROOFS = 2, 8
"""Changes of the program have one of so many equal parts of the time that is left: the first where
nothing else follows, the second where longer proofs do."""
UNTRIED = "the budget ended before every number was tried"
TOGETHER = "all limits of this name together; a cam was found with this value"


@dataclass(frozen=True, eq=False)
class Members:
    """Numbers that have no cam together.

    Attributes:
        numbers: these. trial: the question with them alone.
        unconfirmed: those of them without which neither a cam nor a proof was found.
        on_time: whether every number was tried before the budget ended.
    """

    numbers: list[Relaxable]
    trial: Trial
    unconfirmed: list[Relaxable]
    on_time: bool


def explain(
    asked: DesignSpec, attempt: Attempt, smallest: Smallest | None, deadline: float
) -> Conflict:
    """Why a question has no cam, and what each of its conflicting numbers would have to be.

    Args:
        asked: the question, with what it leaves free.
        attempt: what it came to, without a certified cam, at the numbers that were chosen.
        smallest: the smallest cam without its maximum of the base radius, where that was sought.
        deadline: ``clock.now()`` at which to stop; what is not known by then is said to be so.
    """
    original = Trial(attempt, smallest, True)
    spec = attempt.question.physical
    most = inf if spec.time_budget_s is not None else clock.programs_solved() + MOST_PROGRAMS
    own = asked if attempt.chosen_values else spec
    chosen = bool(attempt.chosen_values)
    # Programs of a search over numbers are not counted one by one: it takes a time.
    counted = spec.proof == "thorough" and not chosen
    has_time = spec.time_budget_s is not None or counted
    longer = has_time and spec.proof != "quick"
    oracle = Oracle(spec, own, deadline, most, has_longer_proofs=longer and not chosen)
    numbers = relaxable_numbers(oracle.spec)
    # 1. A value of each number that suffices alone.
    boundaries = {number: Boundary(oracle, number, original) for number in numbers}
    for boundary in boundaries.values():
        seek_value(boundary)
    # 2. The conflict.
    sufficing = [n for n, boundary in boundaries.items() if boundary.nearest is not None]
    members = _irreducible(oracle, numbers, sufficing, original)
    # 3. The least values of its members, and those that are proven impossible.
    for number in members.numbers:
        boundaries[number].narrow()
    #    A proof at numbers that were chosen is none over all of them: longer ones are, below.
    for accuracy in () if chosen and longer else ACCURACIES:
        for number in members.numbers:
            boundaries[number].seek_bound(accuracy)
    # 4. Changes of the program, with all limits as they are, that mend it: in half of the time that
    #    is left, or an eighth where longer proofs follow. Numbers that are free stay so. A gap that
    #    another program leaves open says nothing of the one asked for.
    changes = list[Relaxation]()
    parts = PARTS_BEFORE_LONGER_PROOFS if longer else CHANGES_PARTS
    changed = replace(oracle.share(parts), spec=own, known={}, has_longer_proofs=False)
    for changeable in program_numbers(own, attempt.chosen_values) if members.numbers else ():
        boundary = Boundary(changed, changeable, original)
        seek_value(boundary)
        if boundary.needed is not None:
            boundary.narrow()
            boundary.seek_bound(ROUGH)
            changes += _relaxations(boundary)
    # 5. With what time is left, the members' values once more where a gap is open: longer proofs,
    #    of all numbers that are free.
    known = [boundaries[number] for number in members.numbers]
    if chosen:
        oracle = replace(oracle, spec=own, known={}, has_longer_proofs=longer)
        known = [_with_numbers_free_again(boundary, oracle) for boundary in known]
    if oracle.has_longer_proofs and (chosen or oracle.open_gap > FINE):
        close_in(oracle, known)
    relaxations = [one for boundary in known for one in _relaxations(boundary)]
    limits = [str(number) for number in members.numbers]
    refused = [extreme for extreme in attempt.extremes if not extreme.holds]
    evidence = _evidence(original, members, "those named" if not refused else ", ".join(limits))
    # 6. What the certificate refused on the cam at hand, which no member may name.
    if refused:
        values = ", ".join(
            f"{e.limit} {e.evidence if e.value is None else f'{e.value} {e.unit}'} "
            f"at {e.angle_deg:.3f}°"
            for e in refused
        )
        evidence = f"{evidence}; the certificate refused the cam at hand: {values}"
        names = [extreme.limit.replace("_", " ") for extreme in refused]
        limits += [n for n in names if not any(known.startswith(n) for known in limits)]
    return Conflict(
        limits=limits, relaxations=relaxations, program_changes=changes, evidence=evidence,
        proven=bool(original.proof or members.trial.proof),
        unconfirmed=[str(number) for number in members.unconfirmed],
    )  # fmt: skip


def _irreducible(
    oracle: Oracle, numbers: Sequence[Relaxable], sufficing: Collection[Relaxable], original: Trial
) -> Members:
    """Numbers that have no cam together, but have one without any single one of them.

    ``sufficing``: numbers that have a cam if they alone are relaxed.
    """

    def has_none(trial: Trial) -> bool:
        """Whether a question with fewer numbers has no cam either, as surely as the original."""
        found_none = trial.on_time and not original.proof
        return not trial.certified and (bool(trial.proof) or found_none)

    # What was proven once is proven of fewer numbers by as long a proof, if at all; and what was
    # not found by one may be found by nothing less: all questions have the spec's own.
    kept, shown = list(numbers), original
    # What phase 1 names, or those that suffice alone, may have no cam by themselves.
    strained = [number for number in numbers if number.limit in original.strained]
    for few in (list(sufficing), strained):
        if 0 < len(few) < len(kept) and not oracle.is_late():
            trial = oracle.proven_without([number for number in numbers if number not in few])
            if has_none(trial):
                kept, shown = few, trial
    unconfirmed, on_time = list[Relaxable](), True
    for number in [number for number in kept if number not in sufficing]:
        if oracle.is_late():
            unconfirmed.append(number)
            on_time = False
            continue
        removed = [one for one in numbers if one not in kept or one is number]
        trial = oracle.proven_without(removed)
        if has_none(trial):
            kept.remove(number)
            shown = trial
        elif not trial.certified:
            unconfirmed.append(number)
            on_time = on_time and trial.on_time
    return Members(kept, shown, unconfirmed, on_time)


def _with_numbers_free_again(known: Boundary, oracle: Oracle) -> Boundary:
    """The same of the question that leaves numbers free: cams answer it, proofs do not."""
    free = Boundary(
        oracle, known.number, known.original, nearest=known.nearest, needed=known.needed,
        confirmed=known.confirmed, note=known.note,
    )  # fmt: skip
    free.direction = known.direction
    return free


def _evidence(original: Trial, members: Members, named: str) -> str:
    """How the conflict is known, and what of it is proven; ``named``: its members."""
    undecided = [search.undecided for search in original.attempt.searches[-1:]]
    known = (original.proof, members.trial.proof, *undecided)
    parts = [reason for reason in known if reason][:1]
    proven = bool(original.proof or members.trial.proof)
    smallest = original.smallest
    if smallest is not None and smallest.radius > smallest.most:
        bound = "" if smallest.excludes or smallest.lower <= 0.0 else (
            f", and none below {smallest.lower:.6g} mm is possible ({smallest.valid_for})"
        )  # fmt: skip
        size = f"{smallest.radius:.6g} mm"
        parts.append(f"without base_radius_mm/max a cam of {size} was found{bound}")
    if not proven:
        parts.append("no cam was found that keeps these limits; that there is none is not proven")
    if not members.on_time:
        parts.append(UNTRIED)
    if not members.numbers:
        parts.append("leaving out all that the spec limits, none was found either")
    elif not members.unconfirmed:
        parts.append(f"leaving out any one of {named}, a cam was found")
    else:
        names = ", ".join(number.name for number in members.unconfirmed)
        parts.append(f"whether there is a cam without {names} is not known")
    spec = original.attempt.question.physical
    if ends(spec.base_radius_mm)[1] == inf and not proven:
        parts.append(f"base radii up to {spec.base_radius_range()[1]:.6g} mm were searched")
    return "; ".join(parts)


def _relaxations(boundary: Boundary) -> Iterator[Relaxation]:
    """What one number alone would have to be, field by field."""
    number, needed, at_least = boundary.number, boundary.needed, boundary.at_least
    if needed is None:
        for path, requested in zip(number.paths, number.requested, strict=True):
            yield Relaxation(
                limit=number.limit, field=path, unit=number.unit, requested=requested, needed=None,
                at_least=at_least, note=boundary.note,
            )  # fmt: skip
        return
    rows = list(number.values_at(needed))
    excluded = dict[str, float]()
    if at_least is not None:
        excluded = {path: value for path, _, value in number.values_at(at_least)}
    for path, requested, value in rows:
        yield Relaxation(
            limit=number.limit, field=path, unit=number.unit, requested=requested, needed=value,
            at_least=excluded.get(path, at_least),
            note=TOGETHER if len(rows) > 1 else boundary.note,
        )  # fmt: skip
