"""A spec that names no objective: the smallest cam of nearly the least rms jerk, and it says so."""

from __future__ import annotations

from typing import Any

import pytest

from synthesis import Design, DesignSpec, sensitivities, synthesise
from synthesis.catalogue.objectives import SMALL_AND_SMOOTH, BaseRadius, PeakAcceleration, PeakJerk
from synthesis.pipeline.assembly import measured
from synthesis.pipeline.proof_file.claims import proof_file
from tests.pipeline import scenes

PRESSURE = {"kind": "pressure_angle", "rise_deg": 30.0, "return_deg": 30.0}
PEAKS = (PeakAcceleration(), PeakJerk())


def pusher(law: dict[str, Any] | None = None, **changes: Any) -> DesignSpec:
    """A pusher of an everyday machine."""
    body = {
        "speed_rpm": 200.0,
        "program": scenes.program(law, 45.0, (120.0, 60.0, 100.0, 80.0)),
        "follower": {"kind": "translating_roller", "roller_radius_mm": 16.0},
        "limits": [PRESSURE],
    }
    return DesignSpec.model_validate(body | changes)


@pytest.fixture(scope="module")
def answer() -> Design:
    return synthesise(pusher())


def test_the_cam_can_be_built(answer: Design) -> None:
    """Smaller than the best textbook law's, and hardly rougher."""
    textbook = synthesise(pusher({"kind": "modified_sine"}))
    assert answer.status == "optimal"
    assert answer.dimensions["base_radius_mm"] < 0.75 * textbook.dimensions["base_radius_mm"]
    own, other = (measured(each, PEAKS) for each in (answer, textbook))
    assert own["peak_acceleration_mm_per_s2"] < 1.2 * other["peak_acceleration_mm_per_s2"]
    assert own["peak_jerk_mm_per_s3"] < 1.3 * other["peak_jerk_mm_per_s3"]


def test_it_is_proven_over_all_laws_and_told(answer: Design) -> None:
    size, (jerk,) = answer.certificate, answer.certificate.other_objectives
    assert (size.objective, jerk.objective) == ("base_radius_mm", "rms_jerk_mm_per_s3")
    assert size.bound_valid_for == jerk.bound_valid_for == "all motion laws with a bounded jerk"
    assert size.gap is not None
    assert size.gap <= 1e-3
    assert jerk.value is not None
    assert jerk.lower_bound is not None
    assert jerk.value <= 1.25 * jerk.lower_bound
    (told,) = answer.assumptions
    assert "rms jerk may be 25 % above the least possible" in told
    assert answer.spec.objective is None


def test_it_may_be_asked_for_by_name(answer: Design) -> None:
    named = [{"kind": "rms_jerk", "allowance": 0.25}, {"kind": "base_radius"}]
    other = synthesise(pusher(objective=named))
    assert (other.motion, other.size) == (answer.motion, answer.size)
    assert (other.status, other.assumptions) == ("optimal", [])
    assert other.certificate.objective == "rms_jerk_mm_per_s3"


def test_sensitivities_are_those_of_the_size(answer: Design) -> None:
    """The derivative by a limit, held to another design with that limit moved."""
    found = sensitivities(answer)
    assert found.objective == "base_radius_mm"
    rise = next(s for s in found.sensitivities if s.field == "/limits/0/rise_deg")
    moved = synthesise(pusher(limits=[PRESSURE | {"rise_deg": 31.0}]))
    change = moved.dimensions["base_radius_mm"] - answer.dimensions["base_radius_mm"]
    assert rise.per_unit == pytest.approx(change, rel=0.1)


def test_its_proof_file_names_the_objectives(answer: Design) -> None:
    claims = {each["place"]: each for each in proof_file(answer)["claims"]}
    assert all(each["proven"] for each in claims.values())
    radius, jerk = answer.certificate, answer.certificate.other_objectives[0]
    assert claims["objective/0"]["at_least"] == pytest.approx(jerk.lower_bound, rel=1e-4)
    assert claims["objective/1"]["at_least"] == pytest.approx(radius.lower_bound, rel=1e-4)
    assert claims["objective/1"]["held"] == [pytest.approx(jerk.value, rel=1e-6)]


LIMITS = {
    "acceleration": {"kind": "acceleration", "max_mm_per_s2": 2e5},
    "jerk": {"kind": "jerk", "max_mm_per_s3": 2e7},
}


@pytest.mark.parametrize("name", LIMITS)
def test_who_limits_acceleration_or_jerk_gets_the_smallest_cam(name: str) -> None:
    assert pusher(limits=[PRESSURE, LIMITS[name]]).objectives() == (BaseRadius(),)


@pytest.mark.parametrize(
    "law", [{"kind": "modified_sine"}, {"kind": "spline", "smoothness": 1}], ids=["given", "C1"]
)
def test_so_does_who_has_no_law_of_finite_jerk_to_choose(law: dict[str, Any]) -> None:
    assert pusher(law).objectives() == (BaseRadius(),)


def test_jerk_is_infinite_beside_a_law_that_jumps() -> None:
    program = pusher().model_dump(mode="json", exclude_none=True)["program"]
    for kind, objectives in (("parabolic", (BaseRadius(),)), ("cycloidal", SMALL_AND_SMOOTH)):
        program[2]["law"] = {"kind": kind}
        assert pusher(program=program).objectives() == objectives


def test_free_angles_are_those_of_the_least_rms_jerk() -> None:
    program = pusher().model_dump(mode="json", exclude_none=True)["program"]
    for index, low in ((0, 110.0), (2, 90.0)):
        program[index]["angle_deg"] = {"min": low, "max": low + 20.0}
    design = synthesise(pusher(program=program, tolerance=0.02, proof="quick"))
    assert design.free_parameters["program/0/angle_deg"] == pytest.approx(110.0, abs=0.1)
    assert design.status == "feasible"
    assert "chosen numbers alone" in design.certificate.bound_valid_for
    assert "left free are those of the least rms jerk" in design.assumptions[0]


ARM: dict[str, Any] = {"kind": "oscillating_roller", "roller_radius_mm": 15.0, "arm_mm": 120.0}
SWING = [
    {"kind": "rise", "angle_deg": 110.0, "lift_deg": 24.0},
    {"kind": "dwell", "angle_deg": 50.0},
    {"kind": "return", "angle_deg": 120.0, "lift_deg": 24.0},
    {"kind": "dwell", "angle_deg": 80.0},
]


def swinging(distance: float | None) -> Design:
    follower = ARM | ({} if distance is None else {"centre_distance_mm": distance})
    angles = {"kind": "pressure_angle", "rise_deg": 40.0, "return_deg": 40.0}
    spec = {"speed_rpm": 180.0, "program": SWING, "follower": follower, "limits": [angles]}
    return synthesise(DesignSpec.model_validate(spec | {"proof": "quick", "tolerance": 5e-3}))


def test_a_free_pivot_is_bounded_and_no_worse_than_a_given_one() -> None:
    free = swinging(None)
    (smooth,) = free.certificate.other_objectives
    # the least rms jerk of the program is no matter of the pivot: the size may use the allowance
    assert smooth.lower_bound is not None
    assert smooth.value == pytest.approx(1.25 * smooth.lower_bound, rel=0.01)
    assert free.certificate.gap is not None
    assert free.certificate.gap < 0.05
    given = swinging(round(free.dimensions["centre_distance_mm"], 6))
    least, value = free.certificate.lower_bound, free.certificate.value
    assert least is not None
    assert value is not None
    assert given.certificate.value is not None
    assert least <= given.certificate.value
    assert value <= given.certificate.value * 1.02  # each is a local optimum
