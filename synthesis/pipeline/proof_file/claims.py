"""The claims of a design, each with its witness: what the checker accepts is called proven.

A cam is its own witness. The witness of a bound, and of a question that has no cam, are multipliers
that leave no size: those of the program that gave the bound, solved again, or of the program that
shows how much every law exceeds a limit.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import cos, floor, inf, isfinite, log10, sin
from typing import Any

import numpy as np

from synthesis.catalogue.fields import Range
from synthesis.catalogue.followers.closures import Force
from synthesis.catalogue.followers.oscillating_roller import OscillatingRoller
from synthesis.catalogue.followers.pivot import PivotedFollower
from synthesis.catalogue.followers.translating_roller import TranslatingRoller
from synthesis.catalogue.limits.pressure_angle import PressureAngle
from synthesis.catalogue.limits.radii import CounterBaseRadius
from synthesis.catalogue.objectives import BaseRadius, PeakPressureAngle
from synthesis.design.design import Design, Effort, Proof
from synthesis.numerics.solvers.clarabel import ConeSolution, solve
from synthesis.numerics.solvers.statuses import USABLE
from synthesis.optimise.conic.program import ConicModel, formulate
from synthesis.optimise.driver import optimise
from synthesis.optimise.dual_bound.bound import Bound, dual_bound
from synthesis.optimise.problem.derivative_caps import highest_caps
from synthesis.optimise.problem.grid import uniform_grid
from synthesis.optimise.problem.problem import ObjectiveCap, Problem
from synthesis.optimise.strategy.phase_one import (
    INTERVALS,
    LargestShare,
    least_excess_program,
    minimise_excess,
)
from synthesis.pipeline.assembly import Bounded, in_wire_units
from synthesis.pipeline.attempt import prepare
from synthesis.pipeline.goal import Goal
from synthesis.pipeline.largest_radius import first_question
from synthesis.pipeline.proof_file.arms import in_boxes
from synthesis.pipeline.proof_file.checker import as_bytes, checker, not_covered, objections, places
from synthesis.pipeline.proof_file.multipliers import (
    broken_by_given_law,
    multipliers,
    peak_of_given_laws,
)
from synthesis.pipeline.proof_file.rounds import in_rounds
from synthesis.pipeline.proof_file.sizes import in_sizes
from synthesis.pipeline.proof_file.swinging_faces import in_boxes_of_face
from synthesis.spec.design_spec import DesignSpec
from synthesis.units import DEGREE

Json = dict[str, Any]
Witness = tuple[Json, float]  # multipliers, and the bound that they give [wire]
FORMAT, VERSION = "camwright-proof", 1
OBJECTIVE, INFEASIBLE = "objective/0", "infeasible"
LOSSES = (1e-6, 1e-5, 1e-4, 1e-3, 3e-3, 1e-2)  # of a bound, in turn: what rounding takes from it
FIGURES = 9  # of a bound in the file
END_PLACES = 12  # decimals of g(0) and g(1): the rest is rounding
CLOSE = 1e-4  # of a bound: what is proven is the answer's own if it is so near to that
LARGEST_GAP, OWN_PART = 0.9, 0.98  # as in SolveState.allowance
LOOSER = (1.002, 1.01, 1.03, 1.1)  # factors on what is held
ROUNDING = 1e-9  # relative: what decimals and joints may change in a cam's value
NOTHING: Json = {"order": 3, "segments": []}  # multipliers of nothing
PEAKS = {"peak_acceleration": 2, "peak_jerk": 3}  # the derivative that is minimised
COUNTER = ("counter_distance_mm", "counter_angle_deg")  # of the counter roller, from the main one
CHOSEN = ("angle_deg", "lift_mm", "lift_deg")  # of a segment of the cam
NO_WITNESS = "no multipliers are known for it"
OF_ARM = "no rows are known of an arm's size and pressure angle"


def proof_file(design: Design) -> Json:
    """The proof file of a design."""
    cam, question = _cam(design), _question(design.spec)
    body = {
        "format": FORMAT, "version": VERSION, "id": design.id, "question": question, "cam": cam,
    }  # fmt: skip
    named = places(as_bytes(question), has_cam=cam is not None)
    unknown = not_covered(as_bytes(question), as_bytes(_chosen(design)))
    if unknown:
        return {**body, "claims": [_claim(place, unknown) for place in named]}
    # 1. What the cam itself is a witness of.
    of_cam = [place for place in named if not _is_of_all_cams(place)]
    plain = [{"place": place, "proven": True} for place in of_cam]
    spent = Counter[str]()
    found = objections(as_bytes({**body, "claims": plain}), spent)
    # 2. What multipliers are a witness of, with what is left of the work that a file may take.
    claims = [
        _of_all_cams(body, place, design, spent)
        if _is_of_all_cams(place)
        else _claim(place, found[place])
        for place in named
    ]
    return {**body, "claims": claims}


def _question(spec: DesignSpec) -> Json:
    """The question as the checker knows it: the objective named, and room for a hub as a radius."""
    aims = spec.objectives()
    changes: Json = {"objective": spec.objective or (aims[0] if len(aims) == 1 else list(aims))}
    if spec.hub is not None:
        low, high = spec.requested_radii()
        most = high if isfinite(high) else None
        changes["base_radius_mm"] = low if low == high else Range(min=low, max=most)
    hub = {"shaft_diameter_mm", "hub_diameter_mm"}
    return spec.model_copy(update=changes).model_dump(mode="json", exclude=hub)


def _is_of_all_cams(place: str) -> bool:
    return place == INFEASIBLE or place.startswith("objective/")


def _claim(place: str, objection: str, **witness: Any) -> Json:
    if objection:
        return {"place": place, "proven": False, "reason": objection[:100]}
    return {"place": place, "proven": True, **witness}


def _of_all_cams(body: Json, place: str, design: Design, spent: Counter[str]) -> Json:
    """A claim about all cams: the best that the checker accepts after what others have spent."""
    reason = OF_ARM if isinstance(design.spec.follower, OscillatingRoller) else NO_WITNESS
    for witness in _attempts(place, design):
        claim = _claim(place, "", **witness)
        reason = objections(as_bytes({**body, "claims": [claim]}), spent)[place]
        if not reason:
            return claim
    return _claim(place, reason)


def _attempts(place: str, design: Design) -> Iterator[Json]:
    """Claims about all cams that may hold, the best first."""
    spec = design.spec
    if place == INFEASIBLE:  # whatever the objective
        plain = spec.model_copy(update={"objective": BaseRadius()})
        yield from (found for found, _ in _of_sizes(spec, None))
        yield from ({"multipliers": each} for each, _ in _witnesses(plain, infeasible=True))
        return
    rank = int(place.removeprefix("objective/"))
    known, held = _proven(design, rank), _held(design, rank)
    answer = known.lower_bound
    aim = spec.objectives()[rank]
    of_angle = isinstance(aim, PeakPressureAngle)
    of_arm = isinstance(spec.follower, OscillatingRoller)
    kept: Json = {"held": held} if held else {}
    witnesses = []
    if of_arm and (of_angle or isinstance(aim, BaseRadius)):
        # the rows of an arm's size are known in boxes alone
        if of_angle or len(held) < rank:
            return
        witnesses = [({**kept, **found}, bound) for found, bound in _rounds(design, 0.0)]
    elif not of_angle and len(held) == rank:
        witnesses = [({**kept, "multipliers": found}, b) for found, b in _witnesses(spec, held)]
        if isinstance(aim, BaseRadius):
            witnesses += [({**kept, **found}, b) for found, b in _of_sizes(spec, answer)]
    best = max((bound for _, bound in witnesses), default=0.0)
    if not of_arm and place == OBJECTIVE and answer and best < answer * (1.0 - CLOSE):
        witnesses = [*_rounds(design, best), *witnesses]
    # The highest value first: a witness that loses more may still prove more than another one.
    tries = list[tuple[float, Json]]()
    smallest = max(spec.requested_radii()[0], 0.0)
    if isinstance(aim, BaseRadius) and len(held) == rank and (smallest or not answer):
        tries.append((smallest, {**kept, "multipliers": NOTHING}))  # none is asked for below it
    for loss in LOSSES:
        if place == OBJECTIVE and of_angle and answer:
            least = _rounded_down(answer * (1.0 - 0.5 * loss))
            witnesses = [
                ({"multipliers": found}, value) for found, value in _witnesses_of_angle(spec, least)
            ]
        tries += [
            (_rounded_down(bound * (1.0 - loss)), found)
            for found, bound in witnesses
            if 0.0 < bound < inf
        ]
    for value, found in sorted(tries, key=lambda each: -each[0]):
        less = answer is not None and value < answer * (1.0 - CLOSE)
        over = f" over {known.bound_valid_for}" if known.bound_valid_for else ""
        note = {"note": f"the answer's own bound{over}, {answer}, is not covered"} if less else {}
        yield {"at_least": value, **note, **found}


def _of_sizes(spec: DesignSpec, answer: float | None) -> Iterator[tuple[Json, float]]:
    """Witnesses of a base radius, or that there is no cam, from what is known of sizes alone."""
    if spec.free_parameters.parameters:
        return
    asked = as_bytes(_question(spec))
    found = in_sizes(asked)
    if found is not None:
        yield {"multipliers": found[1]}, found[0]
    boxes = in_boxes_of_face(asked, answer)
    if boxes is not None:
        yield boxes[1], boxes[0]


def _proven(design: Design, rank: int) -> Proof:
    """What is proven of an objective, by its place in the list."""
    name = design.spec.objectives()[rank].name_on_wire(design.spec.machine())
    known = [design.certificate, *design.certificate.other_objectives]
    return next(each for each in known if each.objective == name)


def _held(design: Design, rank: int) -> list[float]:
    """What objectives before another may come to [wire]; fewer where one has no value.

    What the search for the next one allowed (``SolveState.allowance``), and at least what the cam
    has.
    """
    found = list[float]()
    for k, objective in enumerate(design.spec.objectives()[:rank]):
        one = _proven(design, k)
        if one.value is None:
            break
        gap = min(objective.allowed_gap(design.spec.tolerance), LARGEST_GAP)
        allowed = (one.lower_bound or 0.0) / (1.0 - OWN_PART * gap)
        found.append(-_rounded_down(-max(allowed, one.value * (1.0 + ROUNDING))))
    return found


def _rounds(design: Design, best: float) -> Iterator[tuple[Json, float]]:
    """A witness of a base radius that rows of radii raise above the best of the linear rows.

    Of an arm, one that its pressure angle needs.
    """
    cam = _cam(design)
    spec, of_arm = design.spec, isinstance(design.spec.follower, OscillatingRoller)
    known = (design.certificate, *design.certificate.other_objectives)
    proven = next((p for p in known if p.objective == "base_radius_mm"), None)
    first = isinstance(spec.objectives()[0], BaseRadius) and not spec.free_parameters.parameters
    answer = proven and (proven.lower_bound or (of_arm and proven.value))
    if cam is None or not answer or not (of_arm or first):
        return
    asked = as_bytes(_question(design.spec))
    if of_arm:
        found = in_boxes(asked, cam["laws"], answer)
    else:
        found = in_rounds(asked, cam["laws"], np.array(design.size), answer)
    if found is not None and found[0] > best:
        yield found[1], found[0]


def _cam(design: Design) -> Json | None:
    """The cam as it was delivered, but for rounding at the ends of laws; None where none fits."""
    if not _has_cam(design):
        return None
    laws: list[Any] = [
        each.spline and each.spline.model_dump(exclude_none=True) for each in design.motion
    ]
    for law in filter(None, laws):
        first, *inner, last = law["coefficients"]
        law["coefficients"] = [round(first, END_PLACES), *inner, round(last, END_PLACES)]
    found = {"size": _size(design), "laws": laws, "program": _chosen(design)}
    load = design.spec.load
    spring = load.free_spring if load is not None else {}
    chosen = {name: design.free_parameters[f"load/spring/{name}"] for name in spring}
    return {**found, "spring": chosen} if chosen else found


def _has_cam(design: Design) -> bool:
    return bool(design.motion) and design.status != "infeasible"


def _size(design: Design) -> list[float]:
    """The sizes of the cam; of an arm the axis as seen from the pivot, along the arm and across."""
    size, known, follower = list(design.size), design.dimensions, design.spec.follower
    if isinstance(follower, PivotedFollower):
        distance, angle = known["centre_distance_mm"], known["initial_angle_deg"] * DEGREE
        size = [distance * cos(angle), distance * sin(angle)]
    size += [known[name] for name in COUNTER if name in known]
    free = isinstance(follower, OscillatingRoller) and not isinstance(follower.arm_mm, float)
    return [*size, known["arm_mm"]] if free else size


def _chosen(design: Design) -> list[Json]:
    """Of every segment the angle and the lift that were chosen, where the question has a range."""
    if not _has_cam(design):
        return []
    asked = design.spec.model_dump(mode="json")["program"]
    made = design.completed_spec.model_dump(mode="json")["program"]
    return [
        {name: made[i][name] for name in CHOSEN if isinstance(s.get(name), dict)}
        for i, s in enumerate(asked)
    ]  # fmt: skip


def _witnesses_of_angle(spec: DesignSpec, least: float) -> Iterator[Witness]:
    """Multipliers that no cam has a peak pressure angle as small: with it as a limit none fits."""
    limit, name = PressureAngle(rise_deg=least, return_deg=least), f"limits/{len(spec.limits)}"
    changes = {"limits": [*spec.limits, limit], "objective": BaseRadius()}
    for found, _ in _witnesses(spec.model_copy(update=changes)):
        for part in found["segments"]:
            for row in part["rows"]:
                row["limit"] = "objective" if row["limit"] == name else row["limit"]
        yield found, least


def _witnesses(
    spec: DesignSpec, held: Sequence[float] = (), *, infeasible: bool = False
) -> Iterator[Witness]:
    """Multipliers of programs whose rows are those of the question.

    ``held``: what objectives come to that are before the one to be bounded [wire]. ``infeasible``:
    whether it is said to have no cam, so that other programs may show that.
    """
    if spec.free_parameters.parameters:
        return  # a bound over all numbers has other multipliers
    attempt = prepare(first_question(_known(spec)), Goal(inf), list[Effort]())
    units, scaled = attempt.question.units, attempt.question.scaled
    length, machine, caps = units.length, scaled.machine(), list[ObjectiveCap]()
    for objective, value in zip(spec.objectives(), held, strict=False):
        own = value / units.of_field(objective.name_on_wire(machine))
        caps.append(ObjectiveCap(objective, objective.from_wire(own, machine)))
    aim = spec.objectives()[len(held)]
    problem = attempt.problem(aim, tuple(caps), Goal(inf).smallest)
    if isinstance(spec.follower, PivotedFollower):  # its lifts are in degrees there
        moving = next(s for s in problem.segments if s.lift)
        length = abs(getattr(spec.program[moving.index], "lift_deg", 0.0) / moving.lift) or length
    tried = [problem] + [
        replace(problem, objective_caps=tuple(replace(c, value=c.value * more) for c in caps))
        for more in (LOOSER if caps else ())
    ]

    def on_wire(value: float) -> float:
        known = [Bounded(problem.objective, value, "")]
        return in_wire_units(attempt.question, scaled, known)[0].lower

    if aim.kind in PEAKS:
        peak = peak_of_given_laws(problem, PEAKS[aim.kind])
        if peak is not None:
            yield peak[0], on_wire(peak[1])
    # 1. The program whose multipliers gave the bound; of given laws, that of the size alone. Where
    #    no spline of its mesh keeps what is held, those of a looser one are nearly as good.
    solved = (optimise(each, attempt.tolerance(len(held))).relaxation for each in tried)
    relaxation = next(filter(None, solved), None)
    if not problem.free:
        relaxation = _solved(formulate(problem, []))
    if relaxation is not None and isfinite(relaxation[2].value):
        model, solution, bound = relaxation
        for found in multipliers(model, solution, spec, length):
            yield found, on_wire(bound.value)
    if infeasible:
        yield from ((found, -inf) for found in _without_cam(problem, spec, length))


def _without_cam(problem: Problem, spec: DesignSpec, length: float) -> Iterator[Json]:
    """Multipliers where there is no cam, each of another program.

    A given law that breaks a limit; the program for the share of a limit that every law needs; that
    for the least excess of all others.
    """
    yield from broken_by_given_law(problem, spec)
    if highest_caps(problem):
        yield from _share_of_limit(problem, spec, length)
    excess = least_excess_program(problem)
    yield from [] if excess is None else multipliers(*excess[:2], spec, length)


def _known(spec: DesignSpec) -> DesignSpec:
    """The question without what the checker has no rows of: other limits, and a counter cam."""
    follower, judge = spec.follower, checker()
    known = {*judge.ORDERS} if isinstance(follower, PivotedFollower) else {*judge.MEET}
    known -= {"hertz_pressure", "camshaft_torque"}
    if spec.load and (spec.load.free_spring or getattr(spec.load, "friction", None)):
        known.discard("contact_force")
    kept = [each for each in spec.limits if each.kind in known]
    rollers = (TranslatingRoller, OscillatingRoller)
    if isinstance(follower, rollers) and follower.closure.counter_paths:
        follower = follower.model_copy(update={"closure": Force()})
        kept = [limit for limit in kept if not isinstance(limit, CounterBaseRadius)]
    return spec.model_copy(update={"follower": follower, "limits": kept})


def _solved(model: ConicModel) -> tuple[ConicModel, ConeSolution, Bound] | None:
    """A program with its solution and bound; None where the solver gives no usable point."""
    solution = solve(model.program)
    return (model, solution, dual_bound(model, solution)) if solution.stopped in USABLE else None


def _share_of_limit(problem: Problem, spec: DesignSpec, length: float) -> list[Json]:
    """Multipliers of the least share of the limit on the highest derivative (phase 1)."""
    steering = highest_caps(problem)
    others = tuple(limit for limit in problem.limits if limit not in steering)
    grids = tuple(uniform_grid(segment, INTERVALS) for segment in problem.free)
    result = minimise_excess(problem, grids, 0.0)
    alone = replace(
        problem, limits=others, objective=LargestShare(shared=steering), objective_caps=()
    )
    found = _solved(formulate(alone, grids if result is None else result.grids))
    return [] if found is None else multipliers(*found[:2], spec, length)


def _rounded_down(value: float) -> float:
    """A number with few figures, not above it."""
    if value == 0.0:
        return value
    unit = 10.0 ** (floor(log10(abs(value))) + 1 - FIGURES)
    return float(f"{floor(value / unit) * unit:.{FIGURES}g}")
