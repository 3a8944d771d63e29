"""An arm's length left free: global searches, the law of similarity, refusals, what is told."""

from __future__ import annotations

import json
from functools import cache
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from synthesis import Design, DesignSpec, analyse, synthesise
from synthesis.errors import InputError
from synthesis.exporters import PROFILE_FORMATS
from synthesis.optimise.driver import optimise
from synthesis.optimise.parameters import search
from synthesis.optimise.problem.problem import formulate_problem
from tests.optimise.arms import ARM, FALL, HOLD, RISE, SENSES, angles, body, jerk, least
from tests.pipeline.test_oscillating_roller import prime_radius

RANGE = {"min": 40.7, "max": 161.3}
DISTANCE = 101.9

# lengths tried first, descents and their steps, how closely: a search that is sure enough here
SEARCH = {
    "FEW": 4, "MANY": 9, "STARTS": 1, "MAX_STEPS": 8, "POLISHED": 1, "ROUGHLY": 5e-2, "FINE": 2e-2,
}  # fmt: skip

pytestmark = pytest.mark.usefixtures("coarse_search")


def spec(*limits: dict[str, Any], arm: Any = RANGE, **more: Any) -> DesignSpec:
    question = body(*limits, **more)
    question["follower"]["arm_mm"] = arm
    return DesignSpec.model_validate(question)


def sized(*limits: dict[str, Any], **more: Any) -> Design:
    design = synthesise(spec(*limits, **more))
    assert design.certificate.certified
    return design


@cache
def alone(sense: str = "opposite") -> Design:
    """Laws given, the centre distance too."""
    return sized(angles(), law="cycloidal", sense=sense, distance=DISTANCE)


def prime(design: Design) -> float:
    return design.dimensions["prime_radius_mm"]


def searched(sense: str, distance: tuple[float, float]) -> float:
    """The least prime radius by differential evolution over l, ψ0 and, in a range, d."""

    def radius(points: np.ndarray, count: int) -> np.ndarray:
        arm, start, d = (*points, np.full(points.shape[1], distance[0]))[:3]
        return prime_radius(arm, start, d, sense, count)

    bounds = [(RANGE["min"], RANGE["max"]), (0.01, 2.5), distance]
    return least(radius, bounds[: 2 if distance[0] == distance[1] else 3])


@pytest.mark.parametrize("sense", SENSES)
def test_as_small_as_a_global_search_finds(sense: str) -> None:
    design = alone(sense)
    assert prime(design) == pytest.approx(searched(sense, (DISTANCE, DISTANCE)), rel=1e-6)
    arm = design.dimensions["arm_mm"]
    assert design.free_parameters == {"follower/arm_mm": arm}
    assert RANGE["min"] < arm < RANGE["max"]
    # only a search was made over the length, and the bound says so
    assert design.status == "feasible"
    assert design.certificate.bound_valid_for.endswith("at the chosen numbers alone")


def test_as_small_as_a_global_search_over_the_pivot_too(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "FEW", 8)  # of fewer the best is too far from the pivot's end
    distance = {"min": 101.9, "max": 131.7}
    design = sized(angles(), law="cycloidal", distance=distance)
    assert prime(design) == pytest.approx(searched("opposite", (101.9, 131.7)), rel=1e-6)
    assert design.dimensions["centre_distance_mm"] == pytest.approx(101.9, rel=1e-6)


@pytest.mark.parametrize("sense", SENSES)
def test_with_angles_limited_alone_a_cam_shrinks_with_its_arm(sense: str) -> None:
    question: dict[str, Any] = {"law": "cycloidal", "sense": sense}
    free, given = sized(angles(), **question), sized(angles(), arm=ARM, **question)
    assert free.dimensions["arm_mm"] == RANGE["min"]
    assert prime(free) / RANGE["min"] == pytest.approx(prime(given) / ARM, rel=1e-6)


def test_a_length_in_mm_holds_it_up() -> None:
    """A profile radius does not shrink with the arm: neither end of the range is best."""
    least = {"kind": "profile_radius", "min_mm": 14.3}
    question: dict[str, Any] = {"law": "cycloidal", "distance": {"max": 123.4}, "tolerance": 2e-2}
    found = sized(angles(), least, **question)
    for arm in (50.3, 97.7):
        assert prime(found) <= prime(sized(angles(), least, arm=arm, **question)) * (1.0 + 1e-3)
    (radius,) = [e for e in found.extremes if e.limit == "profile_radius"]
    assert radius.value is not None
    assert radius.value >= 14.3 - 1e-6


@pytest.mark.usefixtures("unexplained")
def test_with_laws_free_a_length_beside_it_is_no_better() -> None:
    question: dict[str, Any] = {"distance": DISTANCE, "tolerance": 2e-2}
    found = sized(angles(), jerk(1.9), **question)
    at = found.dimensions["arm_mm"]
    other = synthesise(spec(angles(), jerk(1.9), arm=1.03 * at, **question))
    assert prime(found) <= prime(other) * (1.0 + 2e-2)


def test_a_length_at_which_nothing_is_found_is_given_up_soon() -> None:
    """Rows that allow what no cam keeps were written at three times the points in every round."""
    question = spec(angles(), jerk(1.9), arm=93.183, distance=DISTANCE)
    found = optimise(formulate_problem(question, question.objectives()[0]), 2e-2)
    rounds = [stage for stage in found.stages if stage.stage.startswith("convex")]
    assert found.incumbent is None
    assert len(rounds) <= 4
    assert max(stage.rows for stage in rounds) < 4000


def test_a_range_that_reaches_in_part_is_searched_there() -> None:
    """With Rp = 37.9 mm and d = 101.9 mm arms of 64.0 to 139.8 mm reach, of 5 to 5000 mm asked."""
    found = sized(
        arm={"min": 5.0, "max": 5e3}, distance=DISTANCE, law="cycloidal", base_radius_mm=30.0,
        objective={"kind": "peak_acceleration"},
    ).dimensions  # fmt: skip
    assert found["prime_radius_mm"] == pytest.approx(37.9, rel=1e-9)
    assert 64.0 < found["arm_mm"] < 139.8


def test_angles_and_the_arm_are_free_together() -> None:
    question = body(angles(), law="cycloidal", distance=DISTANCE)
    question["follower"]["arm_mm"] = RANGE
    for k, angle in ((0, RISE), (2, FALL)):
        question["program"][k]["angle_deg"] = {"min": 0.8 * angle, "max": 1.3 * angle}
    design = synthesise(DesignSpec.model_validate(question))
    assert design.certificate.certified
    assert list(design.free_parameters) == [
        "program/0/angle_deg",
        "program/2/angle_deg",
        "follower/arm_mm",
    ]
    turned = [segment.angle_deg for segment in design.motion]
    assert sum(turned) == pytest.approx(360.0, abs=1e-9)
    assert turned[1] == HOLD
    assert prime(design) < 0.999 * prime(alone())


@pytest.fixture(scope="module")
def pair() -> Design:
    """Conjugate cams: the counter arm given, the main arm free."""
    question = body(angles(), law="cycloidal", distance=DISTANCE)
    counter = {"kind": "conjugate", "roller_radius_mm": 9.1, "arm_mm": 78.3}
    question["follower"] |= {"arm_mm": RANGE, "closure": counter}
    return synthesise(DesignSpec.model_validate(question))


def test_a_counter_arm_goes_with_it(pair: Design) -> None:
    assert pair.certificate.certified
    assert pair.dimensions["counter_arm_mm"] == 78.3
    assert prime(pair) == pytest.approx(prime(alone()), rel=1e-5)


def test_the_answer_survives_the_wire_and_makes_files(pair: Design) -> None:
    back = Design.model_validate(json.loads(json.dumps(pair.model_dump(mode="json"))))
    assert back.spec == pair.spec
    assert back.completed_spec.follower.travel == pair.completed_spec.follower.travel
    assert np.array_equal(back.curve.derivatives([1.3]), pair.curve.derivatives([1.3]))
    for exporter in PROFILE_FORMATS.values():
        assert exporter.write(back, exporter.options()) == exporter.write(pair, exporter.options())


@pytest.mark.usefixtures("unexplained")
def test_where_nothing_fits_the_length_tried_is_named() -> None:
    design = synthesise(spec(angles(1.3, 1.9), law="cycloidal", distance=DISTANCE))
    assert design.status == "unsolved"
    assert design.conflict is not None
    assert "follower/arm_mm = " in design.conflict.evidence


def test_an_analysis_wants_a_number() -> None:
    question = spec(law="cycloidal", distance=DISTANCE, base_radius_mm=30.0)
    with pytest.raises(InputError) as caught:
        analyse(question)
    assert caught.value.field == "/follower/arm_mm"
    assert caught.value.value == RANGE


WRONG: dict[str, tuple[Any, dict[str, Any], str, str]] = {
    "empty": ({"min": 90.0, "max": 80.0}, {}, "range_empty", "min = 90.0 is above max = 80.0"),
    "half open": ({"min": 90.0}, {}, "missing", "required"),
    "left out": (None, {}, "float_type", "must be a number"),
    "from zero": ({"min": 0.0, "max": 9.0}, {}, "greater_than", "greater than 0"),
    "too short": (
        {"min": 20.0, "max": 50.0}, {"distance": DISTANCE, "base_radius_mm": 30.0},
        "no_length_serves", "longest, at cam angle 0.0° .program/0., .* arm_mm = 50.0 cannot hold",
    ),
    "too long": (
        {"min": 150.0, "max": 900.0}, {"distance": DISTANCE, "base_radius_mm": 30.0},
        "no_length_serves", "shortest, at cam angle .* arm_mm = 150.0 cannot hold",
    ),
    "under the roller": ({"min": 2.0, "max": 7.7}, {}, "no_length_serves", "over its own pivot"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_nonsense_is_refused(name: str) -> None:
    arm, more, kind, words = WRONG[name]
    with pytest.raises(ValidationError, match=words) as caught:
        spec(arm=arm, law="cycloidal", **more)
    assert kind in [error["type"] for error in caught.value.errors()]
