"""Changes of the program that mend a conflict: sufficient, next to impossible, and only such."""

from __future__ import annotations

import copy
from math import inf
from typing import Any

import pytest

from synthesis import synthesise
from synthesis.design.design import Conflict, Relaxation
from synthesis.pipeline import oracle
from synthesis.pipeline.largest_radius import compare
from synthesis.pipeline.oracle import Oracle
from synthesis.pipeline.program_numbers import program_numbers
from synthesis.pipeline.relaxable import relaxable_numbers
from synthesis.spec.design_spec import DesignSpec
from tests.optimise.scenes import PLAIN, acceleration, angles, dwell, fall, jerk, rise, scene

LEAST = 32.0 / 31.0  # h/β³: what a move between dwells needs at least, over what is allowed
CLOSE = 2e-2  # of the way
VIBRATION = {"kind": "residual_vibration", "natural_frequency_hz": 30.0, "max_mm": 0.1}


def why(spec: DesignSpec) -> Conflict:
    found = synthesise(spec).conflict
    assert found is not None
    return found


def with_changes(spec: DesignSpec, changes: list[Relaxation], share: float) -> DesignSpec:
    """The spec with a share of the way from what is requested to what is needed."""
    body = copy.deepcopy(spec.model_dump(exclude_none=True))
    for each in changes:
        at: Any = body
        *parents, last = each.field.split("/")
        for step in parents:
            at = at[int(step)] if isinstance(at, list) else at[step]
        assert each.needed is not None
        at[last] = each.requested + share * (each.needed - each.requested)
    return DesignSpec.model_validate(body)


@pytest.mark.parametrize("factor", [1.7, 3.0, 9.0])
def test_no_change_is_larger_than_by_a_half(factor: float) -> None:
    """9 times less jerk than h/β³ needs would take 0.48 of the speed: that is another machine."""
    changes = why(scene(PLAIN, jerk(32.0 / factor, 71.7), base={"min": 4.3})).program_changes
    for each in changes:
        assert each.needed is not None
        assert 0.5 - 1e-9 <= each.needed / each.requested <= 1.5 + 1e-9
    named = {each.limit for each in changes}
    assert ("speed" in named) is (factor ** (-1 / 3) > 0.5)
    assert ("all_lifts" in named) is (1.0 / factor > 0.5)


def test_a_value_beyond_the_farthest_is_not_tried() -> None:
    spec = scene(PLAIN, jerk(31.0, 71.7), base={"min": 4.3})
    speed = next(n for n in program_numbers(spec, ()) if n.name == "speed")
    asked = Oracle(spec, spec, inf)
    assert asked.is_valid(speed, 0.501 * spec.speed_rpm)
    assert not asked.is_valid(speed, 0.499 * spec.speed_rpm)


@pytest.mark.parametrize(("move", "rest"), [(143.3, 22.4), (131.9, 17.7), (97.1, 31.3)])
def test_a_dwell_that_gives_all_of_its_angle_has_none(move: float, rest: float) -> None:
    program = (rise(move), dwell(rest), fall(360.0 - move - rest))
    spec = scene(program, jerk(31.0, 71.7), base={"min": 4.3})
    number = next(n for n in program_numbers(spec, ()) if n.name == "angle of program/0")
    assert number.farthest is not None
    for _, requested, value in number.values_at(number.farthest):
        assert value >= 0.0
        assert value == 0.0 or value > 1e-9 * requested
    assert Oracle(spec, spec, inf).is_valid(number, number.farthest)


@pytest.fixture(scope="module")
def conflict() -> tuple[DesignSpec, Conflict]:
    spec = scene(PLAIN, jerk(31.0, 71.7), base={"min": 4.3})
    return spec, why(spec)


@pytest.mark.parametrize(
    ("name", "factor"),
    [("angle_of_program/0", LEAST ** (1 / 3)), ("all_lifts", 1.0 / LEAST),
     ("speed", LEAST ** (-1 / 3))],
)  # fmt: skip
def test_the_change_is_that_of_the_closed_form(
    name: str, factor: float, conflict: tuple[DesignSpec, Conflict], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Jerk goes with h ω³/β³."""
    spec, found = conflict
    changes = [each for each in found.program_changes if each.limit == name]
    first = changes[0]
    assert first.needed is not None
    way = first.needed - first.requested
    assert way == pytest.approx(first.requested * (factor - 1.0), rel=CLOSE)
    monkeypatch.setattr("synthesis.pipeline.conflict.relaxable_numbers", lambda _: [])
    assert synthesise(with_changes(spec, changes, 1.0)).certificate.certified
    assert synthesise(with_changes(spec, changes, 1.0 - CLOSE)).status == "infeasible"
    if first.at_least is not None:
        assert (1.0 - CLOSE) * abs(way) < abs(first.at_least - first.requested) < abs(way)


def test_an_angle_takes_its_degrees_from_the_longest_dwell(
    conflict: tuple[DesignSpec, Conflict],
) -> None:
    _, found = conflict
    longer, shorter = (each for each in found.program_changes if "angle" in each.limit)
    assert (longer.field, shorter.field) == ("program/0/angle_deg", "program/3/angle_deg")
    for ends in ((longer.needed, shorter.needed), (longer.at_least, shorter.at_least)):
        assert None not in ends
        assert sum(ends) == pytest.approx(71.7 + 181.1, abs=1e-9)


def test_a_move_that_is_not_the_cause_is_not_changed(conflict: tuple[DesignSpec, Conflict]) -> None:
    _, found = conflict
    assert {each.limit for each in found.program_changes} == {
        "angle_of_program/0", "all_lifts", "speed"
    }  # fmt: skip


def numbers(*limits: dict[str, Any], program: Any = PLAIN) -> dict[str, bool]:
    """Whether more than sufficient values can be shown of each number."""
    spec = scene(program, angles(30.0, 30.0), *limits)
    return {number.name: number.monotone for number in program_numbers(spec, ())}


def test_what_a_longer_move_or_a_lower_speed_proves() -> None:
    free = numbers(jerk(50.0, 71.7))
    assert free == {
        "angle of program/0": True, "angle of program/2": True, "all lifts": False,
        "speed": True,
    }  # fmt: skip
    given = numbers(acceleration(9.0, 71.7), program=(rise(71.7, law="cycloidal"), *PLAIN[1:]))
    assert (given["angle of program/0"], given["angle of program/2"]) == (False, True)
    assert not any(numbers(jerk(50.0, 71.7), VIBRATION).values())


def test_what_depends_on_no_speed_is_not_slowed_down() -> None:
    assert "speed" not in numbers(program=(rise(71.7, law="cycloidal"), *PLAIN[1:]))


def test_what_is_fixed_to_places_of_a_move_is_left_alone() -> None:
    point = {**rise(71.7), "points": [{"angle_deg": 30.0, "travel_mm": 10.0}]}
    found = numbers(jerk(50.0, 71.7), program=(point, *PLAIN[1:]))
    assert found == {"angle of program/0": False, "angle of program/2": False}
    turning = (rise(131.7), fall(228.3))
    assert "angle of program/0" not in numbers(jerk(50.0, 71.7), program=turning)


def test_the_end_of_a_range_at_which_the_number_lies() -> None:
    wide = {"min": 60.0, "max": 80.0}
    program = ({**rise(71.7), "angle_deg": wide}, dwell(23.9), fall(83.3),
               {**dwell(0.0), "angle_deg": {"min": 100.0, "max": 200.0}})  # fmt: skip
    spec = scene(program, angles(30.0, 30.0), jerk(50.0, 71.7))
    at_end = list(program_numbers(spec, [80.0, 172.8]))
    assert [n.paths[0] for n in at_end if "largest" in n.name] == ["program/0/angle_deg/max"]
    assert not [n for n in program_numbers(spec, [70.0, 150.0]) if n.name.startswith("largest")]


def test_a_value_is_put_into_the_question_as_it_stands(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its angles are free there, and may come to others than those chosen for the request."""
    free = ({**rise(71.7), "angle_deg": {"min": 60.0, "max": 80.0}}, *PLAIN[1:3],
            {**dwell(0.0), "angle_deg": {"min": 100.0, "max": 200.0}})  # fmt: skip
    asked, chosen = (
        scene(each, angles(30.0, 31.0), jerk(50.0, 71.7), base={"max": 30.0})
        for each in (free, PLAIN)
    )
    specs = list[DesignSpec]()

    def noted(spec: DesignSpec, *given: Any, **more: Any) -> Any:
        specs.append(spec)
        return compare(spec, *given, **more)

    monkeypatch.setattr(oracle, "compare", noted)
    number = next(n for n in relaxable_numbers(chosen) if n.name == "base radius")
    trial = Oracle(chosen, asked, inf).ask_as_it_stands(number, 33.0, "quick")
    assert trial.certified
    assert trial.attempt.chosen_values
    (spec,) = specs
    assert (spec.program, spec.base_radius_mm.max) == (asked.program, 33.0)


def test_what_is_free_stays_free(monkeypatch: pytest.MonkeyPatch) -> None:
    """A range is widened; none of its numbers is named, and no number beside them is given.

    Of the limits the base radius alone is relaxed: changes of the program follow all the same.
    """
    monkeypatch.setattr(
        "synthesis.pipeline.conflict.relaxable_numbers",
        lambda s: [n for n in relaxable_numbers(s) if n.minimised],
    )
    given = {"kind": "cycloidal"}
    program = (
        {"kind": "rise", "angle_deg": {"min": 50.7, "max": 74.3}, "lift_mm": 28.2, "law": given},
        dwell(45.9),
        {"kind": "return", "angle_deg": {"min": 73.4, "max": 128.0}, "lift_mm": 28.2, "law": given},
        dwell(159.0),
    )
    spec = scene(program, angles(29.4, 39.6), base={"max": 39.0})
    found = why(spec)
    names = {each.limit for each in found.program_changes}
    assert names == {"all_lifts", "largest_program_0_angle_deg"}
    for name in names:
        changes = [each for each in found.program_changes if each.limit == name]
        assert synthesise(with_changes(spec, changes, 1.0)).certificate.certified
