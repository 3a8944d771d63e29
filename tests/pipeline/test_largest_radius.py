"""A maximum of the base radius: no cam that exists is denied because one is asked for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from math import inf
from types import SimpleNamespace
from typing import Any

import pytest

from synthesis import DesignSpec, synthesise
from synthesis.catalogue.fields import Range
from synthesis.design.design import Design
from synthesis.pipeline import largest_radius
from synthesis.pipeline.assembly import in_wire_units
from synthesis.pipeline.goal import Goal
from synthesis.pipeline.radius_search import solve_spec

pytestmark = pytest.mark.usefixtures("coarse_conflicts")

Spec = dict[str, Any]


def program(rise: float, top: float, back: float, **lift: float) -> list[Spec]:
    law = {"kind": "spline"}
    return [
        {"kind": "rise", "angle_deg": rise, **lift, "law": law},
        {"kind": "dwell", "angle_deg": top},
        {"kind": "return", "angle_deg": back, **lift, "law": law},
        {"kind": "dwell", "angle_deg": round(360.0 - rise - top - back, 9)},
    ]


# a convex question, and one whose gap stays open: 10.94 mm, proven above 8.76
CONVEX: Spec = {
    "speed_rpm": 104.0,
    "program": program(88.1, 31.3, 97.7, lift_mm=17.3),
    "follower": {"kind": "translating_roller", "roller_radius_mm": 8.3, "offset_mm": 0},
    "limits": [
        {"kind": "pressure_angle", "rise_deg": 31.7, "return_deg": 37.1},
        {"kind": "jerk", "max_mm_per_s3": 418_000.0},
    ],
    "tolerance": 0.005,
}
OPEN_GAP: Spec = {
    "speed_rpm": 277.0,
    "program": program(113.0, 19.4, 69.7, lift_mm=12.2),
    "follower": {"kind": "translating_roller", "roller_radius_mm": 5.37},
    "limits": [
        {"kind": "pressure_angle", "rise_deg": 39.0, "return_deg": 27.0},
        {"kind": "jerk", "max_mm_per_s3": 7_890_000.0},
        {"kind": "profile_radius", "min_mm": 4.9},
    ],
    "tolerance": 0.005,
}
# one that a longer proof answers: the quick one leaves a larger cam
LONGER_PROOF: Spec = {
    "speed_rpm": 115.0,
    "program": program(83.8, 31.1, 82.4, lift_mm=20.4),
    "follower": {
        "kind": "translating_roller",
        "roller_radius_mm": 11.5,
        "offset_mm": {"min": -3.12, "max": 9.54},
    },
    "limits": [
        {"kind": "pressure_angle", "rise_deg": 37.7, "return_deg": 27.9},
        {"kind": "jerk", "max_mm_per_s3": 1_090_000.0},
    ],
    "tolerance": 0.005,
    "proof": "auto",
}
PIVOT_FREE: Spec = {
    "speed_rpm": 106.0,
    "program": program(82.5, 53.3, 68.7, lift_deg=17.3),
    "follower": {"kind": "oscillating_roller", "roller_radius_mm": 11.9, "arm_mm": 106.0,
                 "sense": "same"},
    "limits": [
        {"kind": "pressure_angle", "rise_deg": 34.8, "return_deg": 42.8},
        {"kind": "jerk", "max_deg_per_s3": 869_686.0},
    ],
    "tolerance": 0.005,
    "base_radius_mm": {"max": 23.7538},
}  # fmt: skip
SWINGING_FACE: Spec = {
    "speed_rpm": 191.0,
    "program": program(98.3, 34.3, 120.0, lift_deg=13.4),
    "follower": {"kind": "oscillating_flat_face", "centre_distance_mm": 105.0,
                 "face_offset_mm": 3.94, "sense": "same"},
    "limits": [
        {"kind": "profile_radius", "min_mm": 3.36},
        {"kind": "jerk", "max_deg_per_s3": 1_175_420.0},
    ],
    "tolerance": 0.005,
    "base_radius_mm": {"max": 25.85331626898722},
}  # fmt: skip

BODIES = {"convex": CONVEX, "open gap": OPEN_GAP, "longer proof": LONGER_PROOF}


def answer(body: Spec, **changes: Any) -> Design:
    return synthesise(DesignSpec.model_validate({"proof": "quick", **body, **changes}))


@cache
def smallest(name: str) -> Design:
    """The answer without a maximum of the radius."""
    return answer(BODIES[name])


def radius(design: Design) -> float:
    return design.dimensions["base_radius_mm"]


def test_a_maximum_that_does_not_bind_changes_nothing_but_the_certificate() -> None:
    free = smallest("convex")
    limited = answer(CONVEX, base_radius_mm={"max": 60.0})
    assert limited.status == free.status == "optimal"
    assert limited.motion == free.motion
    assert limited.certificate == free.certificate
    assert len(limited.report.stages) == len(free.report.stages)
    (held,) = (e for e in limited.extremes if e.limit == "base_radius")
    assert (held.bound, held.holds) == (60.0, True)
    assert (
        limited.spec.base_radius_mm
        == DesignSpec.model_validate({**CONVEX, "base_radius_mm": {"max": 60.0}}).base_radius_mm
    )


@pytest.mark.parametrize("spare", [0.0, 1e-6, 1e-3])
@pytest.mark.parametrize("name", BODIES)
def test_the_answers_own_base_radius_is_a_maximum_that_it_keeps(name: str, spare: float) -> None:
    least = radius(smallest(name))
    limited = answer(BODIES[name], base_radius_mm={"max": least * (1.0 + spare)})
    assert limited.certificate.certified
    assert radius(limited) <= least * (1.0 + spare)


def test_a_maximum_below_the_bound_is_proven_infeasible_and_what_is_needed_suffices(
    explain_only: Callable[[str], None],
) -> None:
    explain_only("base_radius_mm/max")
    proof = smallest("convex").certificate
    assert proof.lower_bound is not None
    most = 0.98 * proof.lower_bound
    denied = answer(CONVEX, base_radius_mm={"max": most})
    assert denied.status == "infeasible"
    assert not denied.motion
    assert denied.conflict is not None
    assert denied.conflict.evidence.startswith("proven: no cam has a base radius below")
    assert f"base radius ≤ {most:.6g} mm" in denied.conflict.limits
    (own,) = (r for r in denied.conflict.relaxations if r.field == "base_radius_mm/max")
    assert own.requested == most
    assert own.needed is not None
    assert answer(CONVEX, base_radius_mm={"max": own.needed}).status == "optimal"


def test_a_radius_given_above_the_smallest_cam_is_a_bound_of_its_own() -> None:
    """A cam found without it is enlarged; that no cam is smaller then follows from the question."""
    free = solve_spec(DesignSpec.model_validate(CONVEX), Goal(inf), [])
    assert free.cam is not None
    least = 1.013 * free.final_spec.follower.dimensions(free.cam.size)["base_radius_mm"]
    given = DesignSpec.model_validate({**CONVEX, "base_radius_mm": least})
    smallest = largest_radius._smallest(given, free)
    assert smallest is not None
    (bound,) = in_wire_units(smallest.attempt.question, free.final_spec, smallest.attempt.bounds)
    assert bound.lower == pytest.approx(least, rel=1e-9)
    assert bound.valid_for == "all cams with the least base radius asked for"


def test_a_maximum_between_bound_and_cam_claims_no_proof(
    explain_only: Callable[[str], None],
) -> None:
    explain_only("base_radius_mm/max")
    proof = smallest("open gap").certificate
    assert proof.lower_bound is not None
    assert proof.value is not None
    assert proof.gap is not None
    assert proof.gap > 0.05
    most = proof.lower_bound + 0.3 * (proof.value - proof.lower_bound)
    denied = answer(OPEN_GAP, base_radius_mm={"max": most})
    assert denied.status == "unsolved"
    assert denied.conflict is not None
    assert "that there is none is not proven" in denied.conflict.evidence
    (own,) = (r for r in denied.conflict.relaxations if r.field == "base_radius_mm/max")
    assert own.needed is not None
    assert proof.lower_bound < own.needed <= proof.value * (1.0 + 1e-6)
    assert answer(OPEN_GAP, base_radius_mm={"max": own.needed}).certificate.certified


@pytest.mark.parametrize("share", [1.0, 1.02])
@pytest.mark.parametrize("name", BODIES)
def test_a_known_cam_is_found_where_its_base_radius_is_given(name: str, share: float) -> None:
    given = share * radius(smallest(name))
    fixed = answer(BODIES[name], base_radius_mm=given)
    assert fixed.certificate.certified
    assert len(fixed.report.stages) <= len(smallest(name).report.stages)  # no second search
    assert radius(fixed) == pytest.approx(given, rel=1e-12)


def test_a_later_objective_keeps_the_maximum() -> None:
    both = {"objective": [{"kind": "base_radius"}, {"kind": "peak_jerk"}]}
    found = answer(CONVEX, **both)
    limited = answer(CONVEX, **both, base_radius_mm={"max": radius(found)})
    assert limited.certificate.certified
    assert limited.objectives == found.objectives


@pytest.mark.parametrize(
    ("body", "value"), [(PIVOT_FREE, 15.8359), (SWINGING_FACE, 24.6222)], ids=["pivot", "face"]
)
def test_a_maximum_half_again_as_large_as_a_known_cam_is_kept(body: Spec, value: float) -> None:
    limited = answer(body)
    assert limited.certificate.certified
    assert radius(limited) <= value * 1.005


def test_a_given_radius_is_sought_from_the_smallest_cam_before_the_gentlest_law() -> None:
    """The answer's own radius put back: the open question, and nothing else."""
    question: Spec = {
        "speed_rpm": 133.0,
        "program": program(101.0, 20.1, 89.0, lift_deg=13.8),
        "follower": {
            "kind": "oscillating_roller", "roller_radius_mm": 6.13, "arm_mm": 85.7,
            "sense": "same", "centre_distance_mm": 105.0,
        },
        "limits": [
            {"kind": "pressure_angle", "rise_deg": 36.7, "return_deg": 40.8},
            {"kind": "jerk", "max_deg_per_s3": 748_000.0},
            {"kind": "profile_radius", "min_mm": 5.33},
        ],
        "tolerance": 0.005,
    }  # fmt: skip
    least = answer(question)
    found = answer(question, base_radius_mm=radius(least))
    assert found.status == "optimal"
    assert [each.stage for each in found.report.stages] == [
        each.stage for each in least.report.stages
    ]


def test_a_given_radius_is_its_own_bound_however_wide_the_gap_of_the_smallest_cam() -> None:
    groove = {"kind": "groove", "clearance_mm": 0.05, "rim_mm": 6.39}
    question: Spec = {
        "speed_rpm": 116.0,
        "program": program(70.7, 46.8, 82.0, lift_deg=12.2),
        "follower": {
            "kind": "oscillating_roller", "roller_radius_mm": 11.9, "arm_mm": 108.0,
            "sense": "opposite", "closure": groove, "centre_distance_mm": 133.0,
        },
        "limits": [
            {"kind": "pressure_angle", "rise_deg": 38.7, "return_deg": 37.5},
            {"kind": "jerk", "max_deg_per_s3": 1_180_000.0},
        ],
        "tolerance": 0.005,
        "proof": "quick",
    }  # fmt: skip
    smallest = synthesise(DesignSpec.model_validate(question))
    assert smallest.certificate.gap is not None
    assert smallest.certificate.gap > 0.02
    radius = smallest.dimensions["base_radius_mm"]
    given = synthesise(DesignSpec.model_validate({**question, "base_radius_mm": radius}))
    assert given.status == "optimal"
    assert given.certificate.lower_bound == pytest.approx(radius, rel=1e-11)
    assert given.certificate.lower_bound <= radius


@pytest.mark.parametrize("spare", [0.0, 0.05, 1000.0])
def test_a_maximum_below_where_the_search_begins_is_kept_by_the_cam_that_is_found_there(
    spare: float,
) -> None:
    """The roller alone is large enough: the smallest cam is a point, come near to."""
    question: Spec = {
        "speed_rpm": 241.0,
        "program": program(92.3, 27.0, 116.0, lift_mm=9.25),
        "follower": {"kind": "translating_roller", "roller_radius_mm": 8.98},
        "limits": [
            {"kind": "pressure_angle", "rise_deg": 28.5, "return_deg": 38.0},
            {"kind": "jerk", "max_mm_per_s3": 2_750_000.0},
            {"kind": "outer_radius", "max_mm": 74.0},
        ],
        "tolerance": 0.005,
        "proof": "quick",
    }
    radius = synthesise(DesignSpec.model_validate(question)).dimensions["base_radius_mm"]
    assert radius < 1e-6
    most = {"max": radius * (1.0 + spare)}
    found = synthesise(
        DesignSpec.model_validate({**question, "base_radius_mm": most, "time_budget_s": 60.0})
    )
    assert found.status == "feasible"
    assert found.certificate.infimum
    assert found.dimensions["base_radius_mm"] <= most["max"] * (1.0 + 1e-9)
    given = answer(question, base_radius_mm=most["max"])
    assert given.status == "optimal"
    assert all(stage.stage != "nonlinear" for stage in given.report.stages)  # no other search


def test_a_maximum_in_a_gap_of_the_quick_proof_is_excluded_by_the_spec_s_own() -> None:
    """A jerk limit 0.2 % below the least peak that a cam of this size can have; curvature binds."""
    program = [
        {"kind": "rise", "angle_deg": 62.1, "lift_mm": 8.83, "law": {"kind": "spline"}},
        {"kind": "dwell", "angle_deg": 41.9},
        {"kind": "return", "angle_deg": 106.0, "lift_mm": 8.83,
         "law": {"kind": "polynomial_4_5_6_7"}},
        {"kind": "dwell", "angle_deg": 150.0},
    ]  # fmt: skip
    body = {
        "speed_rpm": 142.0, "program": program,
        "follower": {"kind": "translating_roller", "roller_radius_mm": 7.01},
        "limits": [
            {"kind": "pressure_angle", "rise_deg": 29.6, "return_deg": 32.9},
            {"kind": "jerk", "max_mm_per_s3": 1416579.6915784194},
        ],
        "base_radius_mm": {"max": 7.439875209917396},
    }  # fmt: skip
    excluded = {}
    for proof in ("quick", "auto"):
        spec = DesignSpec.model_validate({**body, "proof": proof})
        _, smallest = largest_radius.solve_with_maximum(spec, Goal(inf), [])
        assert smallest is not None
        assert smallest.lower <= 7.4503 <= smallest.radius  # the cam of a proof ten times finer
        excluded[proof] = smallest.excludes
    assert excluded == {"quick": False, "auto": True}


@pytest.mark.parametrize("excess", [3e-3, 2.4e-5, 3e-7])
def test_the_spec_s_own_proof_is_tried_wherever_no_quick_one_decides(
    excess: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A cam a little too large, whose bound is below the maximum, at each of these tolerances."""
    asked = list[tuple[float, str]]()

    def ask(spec: DesignSpec, _goal: Goal, _stages: list[Any]) -> None:
        asked.append((spec.tolerance, spec.proof))

    monkeypatch.setattr(largest_radius, "solve_spec", ask)
    monkeypatch.setattr(largest_radius, "_smallest", lambda *_: None)
    spec = DesignSpec.model_validate({**CONVEX, "tolerance": 5e-3, "proof": "auto"})
    attempt: Any = SimpleNamespace(
        certified=False, chosen_values=(), number_bound=None, searches=[], mesh=lambda _: ()
    )
    known = largest_radius.Smallest(attempt, 1.0 + excess, 1.0, 0.999, "")
    goal = Goal(largest_radius.clock.now() + 100.0)
    assert largest_radius._decided(spec, spec, known, goal, []) is known
    (*quick, (finest, last)) = asked
    tolerances = [tolerance for tolerance, proof in quick if proof == "quick"]
    assert len(tolerances) == len(quick) == {3e-3: 2, 2.4e-5: 4, 3e-7: 4}[excess]
    assert tolerances == sorted(tolerances, reverse=True)
    assert last == "auto"
    assert 1e-6 <= finest <= max(0.5 * excess, 1e-6)


@pytest.mark.parametrize(
    ("gap", "asked_for"), [(4e-3, [(5e-4, "auto")]), (6e-3, [])], ids=["closed", "open"]
)
def test_a_gap_that_nodes_have_closed_is_closed_further_by_the_spec_s_own_proof(
    gap: float, asked_for: list[tuple[float, str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """No quick one has any; what its time has left open is no narrower with a finer tolerance."""
    asked = list[tuple[float, str]]()
    monkeypatch.setattr(
        largest_radius, "solve_spec", lambda spec, *_: asked.append((spec.tolerance, spec.proof))
    )
    monkeypatch.setattr(largest_radius, "_smallest", lambda *_: None)
    spec = DesignSpec.model_validate({**CONVEX, "tolerance": 5e-3, "proof": "auto"})
    search = SimpleNamespace(stages=[SimpleNamespace(nodes=3)], covers_all_laws=True)
    attempt: Any = SimpleNamespace(
        certified=False, chosen_values=(), number_bound=None, searches=[search], mesh=lambda _: ()
    )
    known = largest_radius.Smallest(attempt, 1.001, 1.0, 1.001 * (1.0 - gap), "")
    goal = Goal(largest_radius.clock.now() + 100.0)
    assert largest_radius._decided(spec, spec, known, goal, []) is known
    assert asked == asked_for
    quick = spec.model_copy(update={"proof": "quick"})
    asked.clear()
    largest_radius._decided(quick, quick, known, goal, [])
    assert {proof for _, proof in asked} == {"quick"}


def test_a_finer_search_that_comes_to_a_larger_cam_leaves_the_smaller_one() -> None:
    """On many knots the solver's last digits are lost; its bound is the better one all the same."""
    spec = DesignSpec.model_validate(CONVEX)
    spec = spec.model_copy(update={"base_radius_mm": Range(max=1.0), "proof": "quick"})
    rough, fine = (
        largest_radius.solve_with_maximum(
            spec.model_copy(update={"tolerance": tolerance}), Goal(inf), []
        )[1]
        for tolerance in (0.1, 1e-3)
    )
    assert rough is not None
    assert fine is not None
    assert fine.radius < rough.radius
    assert rough.lower < fine.lower
    worse = replace(rough, lower=fine.lower + 1e-6)
    kept = largest_radius._smaller(fine, worse)
    assert (kept.radius, kept.attempt.cam) == (fine.radius, fine.attempt.cam)
    assert kept.lower == worse.lower
    assert largest_radius._smaller(rough, fine) is fine
    assert largest_radius._smaller(rough, None) is rough


NEXT = {"convex": CONVEX, "open gap": OPEN_GAP}


@cache
def finest(name: str) -> float:
    """The smallest base radius that a fine tolerance finds."""
    fine = {"proof": "quick", "tolerance": 1e-5, "objective": {"kind": "base_radius"}}
    return synthesise(DesignSpec.model_validate({**NEXT[name], **fine})).certificate.value


@pytest.mark.parametrize("name", NEXT)
@pytest.mark.parametrize("spare", [3e-5, 3e-4])
def test_a_cam_next_to_the_smallest_is_found_whatever_is_made_small(
    name: str, spare: float
) -> None:
    """The maximum lies nearer to the smallest base radius than the question's own tolerance."""
    most = {"max": finest(name) * (1.0 + spare)}
    other = {"proof": "quick", "base_radius_mm": most, "objective": {"kind": "peak_acceleration"}}
    assert synthesise(DesignSpec.model_validate({**NEXT[name], **other})).motion


def test_a_radius_next_to_the_smallest_may_be_given() -> None:
    other = {"proof": "quick", "objective": {"kind": "peak_acceleration"}}
    given = {**CONVEX, **other, "base_radius_mm": finest("convex") * (1.0 + 3e-5)}
    assert synthesise(DesignSpec.model_validate(given)).motion
