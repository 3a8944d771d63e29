"""Questions without a best cam are refused; a dwell below says how small a cam can be."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest
from pydantic import ValidationError

from synthesis import DesignSpec, synthesise
from synthesis.catalogue.fields import Range
from synthesis.optimise.problem.problem import formulate_problem
from synthesis.pipeline.relaxable import relaxable_numbers, without

RPM, LIFT = 71.3, 11.7
ROLLER = {"kind": "translating_roller", "roller_radius_mm": 7.3}
GROOVE = ROLLER | {"closure": {"kind": "groove", "clearance_mm": 0.02}}
KNIFE = {"kind": "translating_roller", "roller_radius_mm": 0.0, "offset_mm": {"min": -3.1}}
ARM = {"kind": "oscillating_roller", "arm_mm": 81.0, "roller_radius_mm": 7.3}
NEAR = ARM | {"centre_distance_mm": {"min": 70.0, "max": 90.0}}
FACE = {"kind": "oscillating_flat_face", "centre_distance_mm": {"max": 93.0}}
VANISHING = {"roller": ROLLER, "groove": GROOVE, "knife edge": KNIFE, "arm": ARM,
             "arm, a range": NEAR, "face on a pivot": FACE}  # fmt: skip
PRESSURE = {"kind": "pressure_angle", "rise_deg": 31.0}
RADIUS = {"kind": "profile_radius", "min_mm": 4.1}
CUTTER = {"kind": "cutter_radius", "radius_mm": 40.0}
OUTER = {"kind": "outer_radius", "max_mm": 300.0}


def jerk(unit: str = "mm") -> dict[str, Any]:
    least = 32.0 * LIFT / math.radians(71.0) ** 3 * (RPM * math.pi / 30.0) ** 3
    return {"kind": "jerk", f"max_{unit}_per_s3": 1.7 * least}


def request(
    follower: dict[str, Any], *limits: dict[str, Any], law: str = "spline", below: float = 181.0,
    lift: float = LIFT, **more: Any,
) -> DesignSpec:  # fmt: skip
    unit = "deg" if follower["kind"].startswith("oscillating") else "mm"
    move = {f"lift_{unit}": lift, "law": {"kind": law}}
    program = [
        {"kind": "rise", "angle_deg": 83.0, **move},
        {"kind": "dwell", "angle_deg": 206.0 - below},
        {"kind": "return", "angle_deg": 71.0, **move},
        {"kind": "dwell", "angle_deg": below},
    ]
    return DesignSpec.model_validate(
        {"speed_rpm": RPM, "program": program, "follower": follower, "limits": list(limits), **more}
    )


@pytest.mark.parametrize("follower", VANISHING.values(), ids=VANISHING)
@pytest.mark.parametrize("limited", ["nothing", "motion alone", "no undercut, not too large"])
def test_a_cam_that_nothing_keeps_from_shrinking_is_refused(
    follower: dict[str, Any], limited: str
) -> None:
    unit = "deg" if follower["kind"].startswith("oscillating") else "mm"
    limits: dict[str, list[dict[str, Any]]] = {
        "nothing": [],
        "motion alone": [jerk(unit)],
        "no undercut, not too large": [RADIUS | {"min_mm": 0.0}, OUTER],
    }
    with pytest.raises(ValidationError) as refused:
        request(follower, *limits[limited])
    (error,) = refused.value.errors()
    assert error["type"] == "no_smallest_cam"
    for remedy in ("pressure_angle", "profile_radius", "base_radius_mm a min"):
        assert remedy in error["msg"]


@pytest.mark.parametrize("follower", VANISHING.values(), ids=VANISHING)
@pytest.mark.parametrize("kept", ["pressure angle", "profile radius", "least", "given", "quiet"])
def test_what_keeps_it_large_is_enough(follower: dict[str, Any], kept: str) -> None:
    more: dict[str, Any] = {
        "least": {"base_radius_mm": {"min": 3.7}},
        "given": {"law": "cycloidal"},
        "quiet": {"objective": {"kind": "rms_jerk"}},
    }.get(kept, {})
    limits = {"pressure angle": [PRESSURE], "profile radius": [RADIUS]}.get(kept, [])
    assert request(follower, *limits, **more).objectives()


@pytest.mark.parametrize(
    "follower",
    [
        ROLLER | {"offset_mm": 5.9},
        ROLLER | {"closure": {"kind": "conjugate", "roller_radius_mm": 7.3}},
        ARM | {"centre_distance_mm": 97.0},
        ARM | {"centre_distance_mm": {"min": 82.0}},
        FACE | {"centre_distance_mm": {"min": 40.0, "max": 93.0}},
        FACE | {"face_offset_mm": 2.3},
        {"kind": "translating_flat_face"},
    ],
    ids=["offset", "conjugate", "pivot", "pivot apart", "face's pivot", "face aside", "flat face"],
)
def test_what_has_a_size_of_its_own_is_not_refused(follower: dict[str, Any]) -> None:
    assert request(follower).follower.reason_without_minimum == ""


def test_it_would_indeed_shrink_to_whatever_is_allowed() -> None:
    """The same question with a least radius far below what any machine has: it is reached."""
    smallest = {"objective": {"kind": "base_radius"}, "base_radius_mm": {"min": 1e-3}}
    small = synthesise(request(ARM, **smallest))
    assert small.dimensions["base_radius_mm"] == pytest.approx(1e-3, rel=1e-2)


def test_a_dwell_below_is_a_part_of_the_base_circle() -> None:
    """Its radius is the base radius: a bound, where rows and cones say nothing of curvature."""
    question = request(ROLLER, RADIUS | {"min_mm": 52.3}, jerk(), tolerance=5e-3, proof="quick")
    assert formulate_problem(question, question.objectives()[0]).least_base_circle == 52.3
    design = synthesise(question)
    assert design.certificate.lower_bound == pytest.approx(52.3, rel=1e-9)
    assert design.certificate.gap < 0.05


@pytest.mark.parametrize("ring", [False, True], ids=["no dwell below", "touched from inside"])
def test_elsewhere_the_base_circle_is_no_part_of_the_cam(ring: bool) -> None:
    inside = ROLLER | {"closure": {"kind": "force", "contact": "inside"}}
    question = request(inside, RADIUS) if ring else request(ROLLER, RADIUS, below=0.0)
    assert formulate_problem(question, question.objectives()[0]).least_base_circle == 0.0


@pytest.mark.parametrize("field", ["base_radius_mm", "offset_mm", "centre_distance_mm"])
def test_a_length_that_rounding_hides_the_motion_of_is_refused(field: str) -> None:
    def ask(value: Any) -> DesignSpec:
        if field == "base_radius_mm":
            return request(ROLLER, PRESSURE, base_radius_mm=value)
        return request((ROLLER if field == "offset_mm" else ARM) | {field: value}, PRESSURE)

    stroke = ask(None).stroke()
    for value, sign in ((1.1e9 * stroke, "="), ({"min": 1.1e9 * stroke}, "≥")):
        with pytest.raises(ValidationError) as refused:
            ask(value)
        (error,) = refused.value.errors()
        assert error["type"] == "length_beyond_stroke"
        assert error["msg"].startswith(f"{field} {sign} {1.1e9 * stroke:.6g} mm is over a billion")
    ask(0.9e9 * stroke)
    ask({"max": 1.1e9 * stroke})  # which leaves small ones
    if field == "offset_mm":
        for value, sign in ((-1.1e9 * stroke, "="), ({"max": -1.1e9 * stroke}, "≤")):
            with pytest.raises(ValidationError, match=f"{field} {sign} -.* mm is over a billion"):
                ask(value)


ABSURD = {
    "base radius": ({"base_radius_mm": {"max": 1e30}}, ROLLER),
    "offset": ({}, ROLLER | {"offset_mm": {"min": -1e30, "max": 1e30}}),
    "centre distance": ({}, ARM | {"centre_distance_mm": {"max": 1e30}}),
    "face on a pivot": ({}, FACE | {"centre_distance_mm": {"min": 50.0, "max": 1e30}}),
}


@pytest.mark.parametrize(("more", "follower"), ABSURD.values(), ids=ABSURD)
def test_ranges_as_wide_as_may_be_asked_are_answered(
    more: dict[str, Any], follower: dict[str, Any]
) -> None:
    spec = request(follower, PRESSURE, RADIUS, law="cycloidal", tolerance=0.1, **more)
    assert synthesise(spec).status in ("optimal", "feasible")


SPRUNG = {"kind": "slide", "moving_mass_kg": 1.0}
PLACES: dict[str, Callable[[Any], DesignSpec]] = {
    "base radius": lambda x: request(ROLLER, PRESSURE, base_radius_mm=x),
    "offset": lambda x: request(ROLLER | {"offset_mm": x}, PRESSURE),
    "centre distance": lambda x: request(ARM | {"centre_distance_mm": x}, PRESSURE),
    "initial angle": lambda x: request(ARM | {"initial_angle_deg": x}, PRESSURE),
    "face on a pivot": lambda x: request(FACE | {"centre_distance_mm": x}, RADIUS),
    "spring": lambda x: request(ROLLER, PRESSURE, load={**SPRUNG, "spring": {"rate_n_per_mm": x}}),
    "preload": lambda x: request(ROLLER, PRESSURE, load={**SPRUNG, "spring": {"preload_n": x}}),
}


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("value", [1.1e30, 1e155, -1e200])
def test_numbers_whose_squares_overflow_are_refused(place: str, value: float) -> None:
    for number in (value, {"min": value}, {"max": value}):
        with pytest.raises(ValidationError, match="1e\\+30"):
            PLACES[place](number)


def test_a_hub_and_a_counter_roller_are_named_where_they_stand() -> None:
    with pytest.raises(ValidationError, match=r"base_radius_mm ≥ .* over a billion"):
        request(ROLLER, PRESSURE, hub_diameter_mm=9e5, lift=1e-4)
    counter = {"kind": "conjugate", "roller_radius_mm": 7.3, "offset_mm": 9e5}
    with pytest.raises(ValidationError, match="closure/offset_mm = 900000 mm is over"):
        request(ROLLER | {"closure": counter}, PRESSURE, lift=1e-4)


def test_a_largest_radius_is_left_out_by_one_beyond_what_may_be_asked() -> None:
    spec = request(ROLLER, PRESSURE, base_radius_mm={"max": 1e30})
    (most,) = (number for number in relaxable_numbers(spec) if number.dimension)
    opened = without(spec, [most]).base_radius_mm
    assert isinstance(opened, Range)
    assert opened.max == pytest.approx(1e31)


def test_a_conflict_steps_no_farther_than_may_be_asked() -> None:
    """The step outwards from a jerk of next to nothing would be a base radius of 3e307 mm."""
    limit = jerk() | {"max_mm_per_s3": 1e-300}
    spec = request(ROLLER, PRESSURE, limit, base_radius_mm={"max": 31.0})
    answer = synthesise(spec)
    assert answer.status == "infeasible"
    assert answer.conflict is not None
    (relaxation,) = answer.conflict.relaxations
    assert relaxation.limit == "jerk"
    assert relaxation.needed is not None
