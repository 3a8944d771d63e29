"""Why nothing fits: every value named is enough, a little less is not, and no member is idle."""

from __future__ import annotations

import copy
import itertools
from math import pi
from typing import Any

import numpy as np
import pytest

from synthesis import synthesise
from synthesis.design.design import WITHOUT_CAM, Conflict
from synthesis.numerics.solvers.clarabel import solve
from synthesis.numerics.solvers.statuses import StopReason
from synthesis.optimise.conic.program import formulate
from synthesis.optimise.driver import optimise
from synthesis.optimise.problem.grid import Grid
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.state import SolveState
from synthesis.pipeline import conflict
from synthesis.pipeline.relaxable import relaxable_numbers
from synthesis.spec.design_spec import DesignSpec
from tests.optimise.conic.reference import optimum
from tests.optimise.scenes import (
    LIFT,
    OMEGA,
    PLAIN,
    TURNING,
    acceleration,
    angles,
    dwell,
    even,
    fall,
    jerk,
    problem,
    rise,
    scene,
    velocity,
)

pytestmark = pytest.mark.usefixtures("coarse_conflicts")

NAMED = (rise(71.7, law="cycloidal"), dwell(23.9), fall(83.3), dwell(181.1))
GIVEN = (*NAMED[:2], fall(83.3, law="cycloidal"), dwell(181.1))
OUTER: dict[str, Any] = {"kind": "outer_radius"}
# One free law is enough where two would say the same twice: the long way back keeps every cap.
ONE_FREE = (rise(71.7), dwell(23.9), fall(170.0, law="cycloidal"), dwell(94.4))
LEAST = {"min": 4.3}  # without it, nothing would keep a cam of free laws from shrinking

# what nothing fits, and the fields of which each alone would help
CASES: dict[str, tuple[DesignSpec, set[str]]] = {
    "velocity": (scene(ONE_FREE, velocity(0.97, 71.7), base=LEAST), {"limits/0/max_mm_per_s"}),
    "acceleration and jerk": (
        scene(ONE_FREE, acceleration(4.9, 71.7), jerk(39.0, 71.7), base=LEAST),
        {"limits/0/max_mm_per_s2", "limits/1/max_mm_per_s3"},
    ),
    "size": (
        scene(PLAIN, angles(20.0, 30.0), jerk(47.0, 71.7), base={"max": 30.0}),
        {"limits/0/rise_deg", "limits/1/max_mm_per_s3", "base_radius_mm/max"},
    ),
    "fixed size": (
        scene(ONE_FREE, angles(24.0, 44.0), jerk(47.0, 71.7), base=35.0, offset=3.0),
        {"limits/0/rise_deg", "limits/1/max_mm_per_s3", "base_radius_mm", "follower/offset_mm"},
    ),
    "angle on dwells": (
        scene(PLAIN, angles(30.0, 60.0, dwell_deg=2.0), jerk(60.0, 71.7), base={"max": 40.0},
              offset={"min": 9.0}),
        {"limits/0/dwell_deg", "base_radius_mm/max", "follower/offset_mm/min"},
    ),
    "outer radius": (
        scene(NAMED, angles(24.0, 44.0), jerk(60.0, 71.7), {**OUTER, "max_mm": 46.0}),
        {"limits/0/rise_deg", "limits/2/max_mm"},
    ),
    "outer radius and base radius": (
        scene(NAMED, {**OUTER, "max_mm": 61.0}, angles(50.0, 50.0), base={"min": 40.0}),
        {"limits/0/max_mm", "base_radius_mm/min"},
    ),
    "turning": (
        scene(TURNING, angles(23.0, 33.0), jerk(31.0, 97.3), base={"max": 5.0}),
        {"base_radius_mm/max", "limits/0/return_deg"},
    ),
}  # fmt: skip


KEPT = 1e-8  # rows are of the order of one


def changed(spec: DesignSpec, field: str, value: Any) -> DesignSpec:
    """The spec with one field, named by its path, at another value."""
    body = copy.deepcopy(spec.model_dump())
    at: Any = body
    *path, last = field.split("/")
    for step in path:
        at = at[int(step)] if isinstance(at, list) else at[step]
    at[last] = value
    return DesignSpec.model_validate(body)


def dense(question: Problem, intervals: int = 14) -> list[Grid]:
    return [grid.with_points(np.linspace(0.0, 1.0, 601)) for grid in even(question, intervals)]


def possible(spec: DesignSpec, intervals: int = 14) -> bool:
    """Whether the scene fits, by the direct program; where both radii are limited, by offsets."""
    question = problem(spec)
    if spec.base_radius_mm is None or question.limits[0].kind != "outer_radius":
        return fits(question, dense(question, intervals))
    given = spec.follower.offset_mm
    offsets = np.linspace(-45.0, 45.0, 181) if given is None else [given]
    fixed = [problem(changed(spec, "follower/offset_mm", float(offset))) for offset in offsets]
    return any(fits(question, even(question, intervals)) for question in fixed)


def fits(question: Problem, grids: list[Grid]) -> bool:
    """Whether the solver's point keeps every row, whatever it calls a point with so little room."""
    program = formulate(question, grids).program
    found = solve(program)
    if found.stopped not in (StopReason.SOLVED, StopReason.INACCURATE):
        return False
    slack = program.rhs - program.matrix @ found.x
    first, stop = program.equalities, program.equalities + program.inequalities
    kept = [abs(slack[:first]).max(initial=0.0), (-slack[first:stop]).max(initial=0.0)]
    for size in program.cones:
        kept.append(float(np.linalg.norm(slack[stop + 1 : stop + size])) - slack[stop])
        stop += size
    return max(kept) <= KEPT


def why(spec: DesignSpec) -> Conflict:
    design = synthesise(spec)
    assert design.status in WITHOUT_CAM
    assert design.conflict is not None
    assert design.conflict.proven is (design.status == "infeasible")
    return design.conflict


def certified(spec: DesignSpec) -> bool:
    """Whether a cam is found, with no more proof than that takes."""
    quick = {"proof": "quick", "report_smoothness_cost": False}
    return synthesise(spec.model_copy(update=quick)).certificate.certified


@pytest.fixture(scope="module")
def conflicts(coarse_conflicts: None) -> dict[str, Conflict]:
    return {name: why(spec) for name, (spec, _) in CASES.items()}


@pytest.mark.parametrize("name", CASES)
def test_which_limits_alone_would_help(name: str, conflicts: dict[str, Conflict]) -> None:
    spec, expected = CASES[name]
    assert not possible(spec)
    found = {r.field for r in conflicts[name].relaxations if r.needed is not None}
    assert found == expected


# A law between dwells that may not jump in acceleration never reaches the least velocity.
BELOW = {"velocity": 0.7}
# How far apart the ends of a bracket that is closed so coarsely are at most, relative: how near the
# product brings them is asked in test_boundary.
NEAR = 0.05
NOT_LEAST = "outer radius and base radius"  # not convex: better cams are known


@pytest.mark.parametrize("name", CASES)
def test_what_is_needed_is_enough_and_a_little_less_is_not(
    name: str, conflicts: dict[str, Conflict]
) -> None:
    spec, _ = CASES[name]
    for r in conflicts[name].relaxations:
        if r.needed is not None:
            step = r.needed - r.requested
            assert certified(changed(spec, r.field, r.needed)), r
            less = r.needed - BELOW.get(name, 0.03) * step
            assert name == NOT_LEAST or not possible(changed(spec, r.field, less), 40), r


@pytest.mark.parametrize("name", CASES)
def test_what_is_proven_impossible_is_so_and_lies_next_to_what_is_needed(
    name: str, conflicts: dict[str, Conflict]
) -> None:
    spec, _ = CASES[name]
    for r in conflicts[name].relaxations:
        if r.at_least is None:
            assert not conflicts[name].proven, r
        elif r.needed is not None:
            way, proven = r.needed - r.requested, r.at_least - r.requested
            assert 0.0 <= proven / way <= 1.0, r
            less = r.requested + (1.0 - 1e-3) * proven
            assert proven == 0.0 or not possible(changed(spec, r.field, less), 40), r
            apart = abs(r.needed - r.at_least)
            assert name == NOT_LEAST or apart < NEAR * max(abs(r.needed), abs(way)), r


@pytest.mark.parametrize("name", CASES)
def test_limits_that_cannot_help_alone_are_said_so(
    name: str, conflicts: dict[str, Conflict]
) -> None:
    """Relaxed out of sight, the scene stays impossible, but where that is said not to be known."""
    spec, _ = CASES[name]
    unknown = {each.split(" ≤ ")[0].replace(" ", "_") for each in conflicts[name].unconfirmed}
    for r in conflicts[name].relaxations:
        if r.limit in unknown:
            assert name == NOT_LEAST
        elif r.needed is None and r.unit in ("mm/s", "mm/s²", "mm/s³", "deg"):
            far = 89.0 if r.unit == "deg" else 1e4 * r.requested
            assert not possible(changed(spec, r.field, far)), r
            assert r.note


@pytest.mark.parametrize("factor", [3.1e-3, 3.1e-8])
def test_what_is_needed_is_as_exact_from_far(factor: float) -> None:
    """The least peak jerk between dwells is 32 h/β³."""
    found = why(scene(PLAIN, jerk(factor, 71.7), base=LEAST))
    (needed,) = found.relaxations
    least = 32.0 / factor * needed.requested
    assert needed.needed is not None
    assert least < needed.needed < 1.002 * least


def test_two_limits_far_out_of_reach_are_a_conflict_and_no_failure() -> None:
    found = why(scene(PLAIN, angles(1e-3, 45.0), jerk(3.1e-8, 71.7)))
    assert found.limits == [f"jerk ≤ {jerk(3.1e-8, 71.7)['max_mm_per_s3']:.6g} mm/s³"]
    assert all(r.needed is None for r in found.relaxations)


def test_a_largest_radius_beyond_what_is_searched_by_itself() -> None:
    question = scene(NAMED, angles(3.1e-3, 5e-3), jerk(47.0, 71.7), base={"max": 3.7e5})
    found = [r for r in why(question).relaxations if r.needed is not None]
    assert {r.field for r in found} == {"limits/0/rise_deg", "base_radius_mm/max"}
    for r in found:
        assert certified(changed(question, r.field, r.needed)), r


@pytest.mark.usefixtures("unexplained")
def test_how_large_a_cam_was_searched_is_stated() -> None:
    question = scene(PLAIN, angles(1e-3, 45.0))
    assert f"base radii up to {1e4 * LIFT:.6g} mm" in why(question).evidence
    assert why(question).proven is False
    larger = changed(question, "base_radius_mm", {"max": 3e6})
    assert certified(larger)


# -- the set in conflict ---------------------------------------------------------------------


def without(spec: DesignSpec, fields: set[str]) -> DesignSpec:
    """The spec without some of its limits, named by their fields."""
    body = copy.deepcopy(spec.model_dump(exclude_none=True))
    kept = []
    for position, limit in enumerate(body["limits"]):
        left = {k: v for k, v in limit.items() if f"limits/{position}/{k}" not in fields}
        if len(left) > 1:  # more than its kind
            kept.append(left)
    body["limits"] = kept
    if "base_radius_mm" in fields or "base_radius_mm/max" in fields:
        body["base_radius_mm"] = None
    if not isinstance(body.get("base_radius_mm"), float):
        body["base_radius_mm"] = {**LEAST, **(body.get("base_radius_mm") or {})}
    if "follower/offset_mm" in fields:
        body["follower"]["offset_mm"] = None
    for end in ("min", "max"):
        if f"follower/offset_mm/{end}" in fields:
            body["follower"]["offset_mm"][end] = None
    return DesignSpec.model_validate(body)


def states(spec: DesignSpec) -> bool:
    """Whether CVXPY finds a cam: the second opinion."""
    question = problem(spec)
    return optimum(question, even(question, 24)).value is not None


@pytest.mark.parametrize(
    "name",
    ["acceleration and jerk", "size", "fixed size", "angle on dwells", "outer radius", "turning"],
)  # fmt: skip
def test_the_set_in_conflict_is_irreducible(name: str, conflicts: dict[str, Conflict]) -> None:
    """By brute force over all of its subsets, in CVXPY."""
    spec, _ = CASES[name]
    numbers = relaxable_numbers(spec)
    members = [n for n in numbers if str(n) in conflicts[name].limits]
    everything = {path for n in numbers for path in n.paths}
    assert len(members) == len(conflicts[name].limits)
    for size in range(len(members) + 1):
        for kept in itertools.combinations(members, size):
            left = without(spec, everything - {path for n in kept for path in n.paths})
            assert states(left) == (size < len(members)), kept


def test_two_conflicts_at_once_are_told_one_at_a_time() -> None:
    spec = scene(PLAIN, jerk(31.0, 71.7), acceleration(3.7, 71.7), base=LEAST)
    found = why(spec)
    assert len(found.limits) == 1
    assert all(r.needed is None for r in found.relaxations)


def test_like_limits_have_to_be_raised_together() -> None:
    found = why(scene(PLAIN, jerk(29.0, 71.7), jerk(31.0, 71.7), jerk(90.0, 71.7), base=LEAST))
    fields = {r.field: r for r in found.relaxations}
    assert set(fields) == {"limits/0/max_mm_per_s3", "limits/1/max_mm_per_s3"}
    assert len({r.needed for r in fields.values()}) == 1
    assert all("together" in r.note for r in fields.values())


def test_what_is_said_in_words(conflicts: dict[str, Conflict]) -> None:
    found = conflicts["size"]
    assert found.limits[0] == "pressure angle rise ≤ 20 deg"
    assert found.limits[-1] == "base radius ≤ 30 mm"
    assert found.evidence.startswith("proven: no cam has a base radius below")
    assert "leaving out any one of those named, a cam was found" in found.evidence


# -- given laws, and limits that are not convex ------------------------------------------------


def test_a_given_law_breaks_a_limit_by_itself() -> None:
    """Cycloidal: peak jerk 4π² h/β³, whatever the cam's size."""
    found = why(scene(NAMED, angles(30.0, 44.0), jerk(35.0, 71.7)))
    assert found.limits == [f"jerk ≤ {jerk(35.0, 71.7)['max_mm_per_s3']:.6g} mm/s³"]
    needed = {r.field: r for r in found.relaxations}["limits/1/max_mm_per_s3"]
    assert needed.needed is not None
    own = 4.0 * pi**2 * LIFT / (71.7 * pi / 180.0) ** 3 * OMEGA**3
    assert own <= needed.needed < 1.0002 * own
    assert "program/0, whose law is given" in needed.note


def test_a_given_law_needs_more_than_the_free_one() -> None:
    """The return at rest needs 32, the cycloidal rise 39.5: the larger counts."""
    found = why(scene((fall(71.7, law="cycloidal"), dwell(23.9), rise(71.7), dwell(192.7)),
                      jerk(20.0, 71.7), base=LEAST))  # fmt: skip
    (needed,) = found.relaxations
    assert needed.needed == pytest.approx(4.0 * pi**2 / 20.0 * needed.requested, rel=2e-4)


@pytest.mark.parametrize(
    ("law", "limit", "what"),
    [
        ("parabolic", jerk(200.0, 71.7), "acceleration"),
        ("simple_harmonic", jerk(200.0, 71.7), "acceleration"),
    ],
)
def test_a_jump_of_a_given_law_is_more_than_any_limit(
    law: str, limit: dict[str, Any], what: str
) -> None:
    found = why(scene((rise(71.7, law=law), dwell(23.9), fall(83.3, law=law), dwell(181.1)), limit))
    (needed,) = found.relaxations
    assert needed.needed is None
    assert f"{what} jumps" in needed.note


@pytest.mark.parametrize("limit", [acceleration(200.0, 71.7), jerk(200.0, 71.7)])
def test_a_law_that_no_cam_can_have_is_no_conflict_of_its_limits(limit: dict[str, Any]) -> None:
    law = (rise(71.7, law="constant_velocity"), dwell(23.9))
    back = (fall(83.3, law="constant_velocity"), dwell(181.1))
    found = why(scene((*law, *back), limit))
    assert all(r.needed is None for r in found.relaxations)
    assert found.limits == [*found.unconfirmed, "profile radius"]
    assert "whether there is a cam without" in found.evidence
    assert "profile_radius" in found.evidence


def test_a_jump_that_a_limit_may_have() -> None:
    """Parabolic: its acceleration is bounded by 4 h/β² though it jumps."""
    law = (rise(71.7, law="parabolic"), dwell(23.9), fall(71.7, law="parabolic"), dwell(192.7))
    found = why(scene(law, acceleration(3.0, 71.7)))
    (needed,) = found.relaxations
    assert needed.needed == pytest.approx(4.0 / 3.0 * needed.requested, rel=2e-4)


def test_a_profile_radius_that_the_base_circle_cannot_have() -> None:
    """The dwell below is a part of the base circle: proven without a single cone program."""

    def sought(least: float, *program: dict[str, Any]) -> SolveState:
        radius = {"kind": "profile_radius", "min_mm": least}
        spec = scene(program or PLAIN, angles(31.0, 43.0), radius, base={"max": 60.3})
        return optimise(problem(spec), 0.1)

    refused = sought(60.4)
    assert refused.infeasible
    assert "a dwell below is a part of the base circle" in refused.infeasibility_proof
    assert "60.3 mm at most; a profile radius of 60.4 mm" in refused.infeasibility_proof
    assert not refused.stages
    assert not sought(60.2).infeasibility_proof
    assert not sought(
        60.4, *TURNING[:1], dwell(31.0), fall(197.3)
    ).infeasibility_proof  # it rests above only


def test_a_least_radius_is_eased_by_a_smaller_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(conflict, "ACCURACIES", (0.3,))
    radius = {"kind": "profile_radius", "min_mm": 60.4}
    spec = scene(GIVEN, angles(31.0, 43.0), radius, base={"max": 60.3})
    reported = why(spec)
    assert reported.limits == ["profile radius ≥ 60.4 mm", "base radius ≤ 60.3 mm"]
    needed = reported.relaxations[0].needed
    assert needed is not None
    assert 30.0 < needed < 60.3


# -- limits far out of reach -------------------------------------------------------------------


def test_a_cap_that_no_law_keeps_is_proven_so_beside_curved_limits(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Phase 1 knows no curvature; left out, it excludes no law that keeps the cap."""
    monkeypatch.setattr(conflict, "ACCURACIES", (0.3,))
    body = {
        "speed_rpm": 83.7,
        "follower": {"kind": "oscillating_flat_face", "centre_distance_mm": 109.0},
        "program": [
            {"kind": "rise", "angle_deg": 110.0, "lift_deg": 13.8},
            {"kind": "dwell", "angle_deg": 40.0},
            {"kind": "return", "angle_deg": 116.0, "lift_deg": 13.8},
            {"kind": "dwell", "angle_deg": 94.0},
        ],
        "limits": [
            {"kind": "profile_radius", "min_mm": 4.6}, {"kind": "jerk", "max_deg_per_s3": 1.0}
        ],
    }  # fmt: skip
    design = synthesise(DesignSpec.model_validate(body))
    assert design.status == "infeasible"
    assert design.conflict is not None
    (needed,) = design.conflict.relaxations
    assert needed.needed is not None
    assert needed.at_least is not None
    assert needed.requested < needed.at_least < needed.needed


def test_a_least_radius_far_out_is_brought_back_to_what_fits() -> None:
    """The largest convex part that a largest base circle leaves, whatever was requested."""
    radius = {"kind": "profile_radius", "min_mm": 1e6}
    body = {
        **scene(PLAIN, jerk(60.0, 71.7), radius, base={"max": 60.0}).model_dump(exclude_none=True),
        "follower": {"kind": "translating_flat_face"},
    }
    (least, _) = why(DesignSpec.model_validate(body)).relaxations
    assert least.field == "limits/1/min_mm"
    assert least.needed is not None
    assert least.at_least is not None
    assert 0.0 < least.at_least - least.needed < NEAR * least.needed


def test_all_members_come_near_before_any_comes_nearer(monkeypatch: pytest.MonkeyPatch) -> None:
    """In little time: both ends of each are named then, and none to the last digit."""
    asked, seek = list[tuple[str, float]](), conflict.Boundary.seek_bound

    def noted(self: conflict.Boundary, accuracy: float) -> None:
        asked.append((self.number.name, accuracy))
        seek(self, accuracy)

    monkeypatch.setattr(conflict.Boundary, "seek_bound", noted)
    monkeypatch.setattr(conflict, "ACCURACIES", (2.5e-3, 2.5e-4))
    monkeypatch.setattr(conflict, "program_numbers", lambda *_: ())
    spec = scene(PLAIN, angles(20.0, 30.0), jerk(47.0, 71.7), base={"max": 30.0})
    found = synthesise(spec).conflict
    assert found is not None
    assert len(found.relaxations) == 3
    names = [name for name, _ in asked]
    assert names == 2 * names[:3]
    assert [accuracy for _, accuracy in asked] == sorted([2.5e-3, 2.5e-4] * 3, reverse=True)
