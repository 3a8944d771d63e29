"""Machines of one shape, small or large: the same cam but for its size, to 1e-9.

Every length of a spec grows with one factor; with a load, times with its root, so that forces and
weights stay. Free laws and pivots on arms are where a search that weighs last digits goes astray.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import cache
from math import inf, radians, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from synthesis import Design, DesignSpec, synthesise
from synthesis.catalogue.fields import ends
from synthesis.catalogue.objectives import OBJECTIVES
from synthesis.optimise.problem.nondimensional import DIMENSIONS, NondimensionalSpec, unit_of
from synthesis.units import FIELD_SUFFIXES, MILLIMETRES, Travel
from tests.catalogue.followers.samples import CASES, LIFTS, spec

EXAMPLES = Path(__file__).parents[2] / "openapi" / "examples"
SMALL, LARGE = 3.7e-5, 4.3e3
SAME = 1e-9
# powers of length and time of what unit names are made of; a mass is as it was
UNITS = {
    "mm": (1, 0), "m": (1, 0), "m2": (2, 0), "m3": (3, 0),
    "s": (0, 1), "s2": (0, 2), "s3": (0, 3), "s4": (0, 4),
    "rpm": (0, -1), "hz": (0, -1), "n": (1, -2), "mpa": (-1, -2), "kg": (0, 0), "deg": (0, 0),
    "rad": (0, 0),
}  # fmt: skip
PURE = {
    "allowance", "b", "c", "d", "coefficient", "continuity", "damping_ratio", "inflection",
    "life_exponent", "poisson_ratio", "report_smoothness_cost", "smoothness", "tolerance",
    "time_budget_s", "min", "max", "points", "overshoot",
}  # fmt: skip


def powers(field: str) -> tuple[int, int]:
    """Powers of length and of time in the unit of a number of this name, or in this unit."""
    unit: list[tuple[int, int]] = []
    for word in reversed(field.replace("N·m", "n_m").lower().split("_")):
        if word == "per":
            unit = [(-a, -b) for a, b in unit]
        elif word not in UNITS:
            break
        else:
            unit.append(UNITS[word])
    length, time = (sum(power[i] for power in unit) for i in (0, 1))
    return length, time


def factor(field: str, k: float, loaded: bool) -> float:
    """What such a number is to be multiplied by in a machine k times as large."""
    length, time = powers(field)
    return k ** (length + (time / 2 if loaded else 0))


def resized(value: Any, k: float, loaded: bool, field: str = "") -> Any:
    """A body with every number in it as of a machine k times as large."""
    if isinstance(value, dict):
        return {
            name: [[a, b * k] for a, b in inner]
            if name == "points" and "tolerance_mm" in value
            else resized(inner, k, loaded, name if name not in ("min", "max") else field)
            for name, inner in value.items()
        }
    if isinstance(value, list):
        return [resized(one, k, loaded, field) for one in value]
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return value * factor(field, k, loaded) if number else value


def free_laws(kind: str, sample: int, **follower: Any) -> dict[str, Any]:
    """A sample machine with its laws and its size left free."""
    body: dict[str, Any] = spec(kind, sample).model_dump(mode="json", exclude_none=True)
    unit, omega = "deg" if "oscillating" in kind else "mm", 137.0 * 2.0 * np.pi / 60.0
    for segment in body["program"]:
        if segment["kind"] != "dwell":
            segment["law"] = {"kind": "spline"}
    jerk = 61.0 * LIFTS[kind] / radians(97.3) ** 3 * omega**3
    angles = {"kind": "pressure_angle", "rise_deg": 41.0, "return_deg": 43.0}
    base = body["base_radius_mm"]
    return body | {
        "follower": body["follower"] | follower,
        "limits": [angles, {"kind": "jerk", f"max_{unit}_per_s3": jerk}],
        "base_radius_mm": {"min": 0.7 * base, "max": 2.1 * base},
        "tolerance": 0.01,
    }


def example(name: str) -> dict[str, Any]:
    """An example with all that it leaves to defaults; its proof is quick."""
    body = json.loads((EXAMPLES / f"{name}.json").read_text("utf-8"))["value"]
    found: dict[str, Any] = DesignSpec.model_validate(body | {"proof": "quick"}).model_dump(
        mode="json", exclude_none=True
    )
    return found


PIVOT = {"centre_distance_mm": {"min": 83.7, "max": 139.1}}
GIVEN = spec("oscillating_roller", 1).model_dump(mode="json", exclude_none=True)
MACHINES: dict[str, dict[str, Any]] = {
    **{f"{kind} {i}": free_laws(kind, i) for kind, i in CASES},
    "pivot free": free_laws("oscillating_roller", 0, **PIVOT),
    "pivot of a face free": free_laws("oscillating_flat_face", 0, **PIVOT),
    "pivot free, laws given": free_laws("oscillating_roller", 1, **PIVOT)
    | {"program": GIVEN["program"]},
    "arm free, laws given": free_laws(
        "oscillating_roller", 1, arm_mm={"min": 61.3, "max": 97.9}, centre_distance_mm=107.9
    )
    | {"program": GIVEN["program"]},
    **{
        name: example(name)
        for name in (
            "conjugate", "constant-velocity", "windows-and-points", "table", "quiet-then-small",
            "no-residual-vibration", "spring-chosen", "undercut-limit",
        )
    },
}  # fmt: skip
# as asked where the wire's ranges leave no smaller one
ONCE = ("table", "spring-chosen", "pivot free", "pivot free, laws given", "arm free, laws given")


@cache
def made(name: str, k: float) -> Design:
    body = MACHINES[name]
    return synthesise(DesignSpec.model_validate(resized(body, k, "load" in body)))


def assert_similar(found: Design, wanted: Design, k: float) -> None:
    """The same to 1e-9: sizes, values, gap, laws, extremes and where they are."""
    loaded = wanted.spec.load is not None
    length = max(wanted.dimensions.values())
    assert found.status == wanted.status
    for mine, theirs in (
        (found.dimensions, wanted.dimensions), (found.objectives, wanted.objectives),
        (found.free_parameters, wanted.free_parameters),
    ):  # fmt: skip
        there = {name: value * factor(name, k, loaded) for name, value in theirs.items()}
        slack = SAME * length * k if mine is found.dimensions else 0.0
        assert mine == pytest.approx(there, rel=SAME, abs=slack)
    assert found.certificate.gap == pytest.approx(wanted.certificate.gap, abs=SAME)
    for a, b in zip(found.motion, wanted.motion, strict=True):
        if b.spline is not None and a.spline is not None:
            assert a.spline.knots == pytest.approx(b.spline.knots, abs=SAME)
            assert a.spline.coefficients == pytest.approx(b.spline.coefficients, abs=SAME)
    for one, other in zip(found.extremes, wanted.extremes, strict=True):
        assert (one.limit, one.holds) == (other.limit, other.holds)
        if one.limit.endswith(("_join", "_jump")) or other.value is None:
            continue  # a jump is roundings, if there is none
        unit = factor(other.unit.replace("/", "_per_").translate(POWERS), k, loaded)
        natural = max(abs(other.bound or 0.0), length if other.unit == "mm" else 0.0)
        slack = SAME * natural * unit
        assert one.value == pytest.approx(other.value * unit, rel=SAME, abs=slack)
        apart = abs(one.angle_deg - other.angle_deg) % 360.0
        assert min(apart, 360.0 - apart) <= SAME * 360.0, one.limit


POWERS = str.maketrans({"²": "2", "³": "3", "⁴": "4", " ": "_"})


@pytest.mark.parametrize("name", MACHINES)
def test_a_machine_of_another_size(name: str) -> None:
    """A tiny one is like a huge one: a size between them would say no more."""
    small = 1.0 if name in ONCE else SMALL
    assert made(name, small).motion
    assert_similar(made(name, LARGE), made(name, small), LARGE / small)


def test_every_number_of_a_spec_tells_its_unit_or_has_none() -> None:
    schema = DesignSpec.model_json_schema()
    bodies = [schema, *schema["$defs"].values()]
    numbers = {
        name for body in bodies for name, field in body.get("properties", {}).items()
        if any(kind in json.dumps(field) for kind in ('"number"', '"integer"'))
    }  # fmt: skip
    assert numbers > {"lift_mm", "max_mpa", "damping_n_m_s_per_rad"}
    unknown = {name for name in numbers if not unit_of(name)} - PURE
    assert not unknown, f"DIMENSIONS lacks the unit of {unknown}"
    for kind, (length, time) in DIMENSIONS.items():
        assert factor(kind, 4.0, loaded=True) == pytest.approx(4.0**length * 2.0**time), kind


@pytest.mark.parametrize("name", sorted(MACHINES))
def test_the_unit_of_every_objective_is_known(name: str) -> None:
    """A value whose unit were not known would be delivered in the optimiser's own."""
    machine = DesignSpec.model_validate(MACHINES[name]).machine()
    for objective in OBJECTIVES:
        assert unit_of(objective.model_construct().name_on_wire(machine)), objective


def test_a_rate_of_any_order_ends_with_a_known_unit() -> None:
    for travel in (MILLIMETRES, Travel("deg", 0.5)):
        for order in range(len(FIELD_SUFFIXES)):
            suffix = travel.field_suffix(order)
            assert unit_of(f"peak_{suffix}") == suffix
        with pytest.raises(IndexError):
            travel.field_suffix(len(FIELD_SUFFIXES))


def numbers(value: Any, path: str = "", field: str = "") -> Iterator[tuple[tuple[str, str], float]]:
    """Every number in a body: path, the field that tells its unit, value."""
    if isinstance(value, dict):
        for name, inner in value.items():
            yield from numbers(inner, f"{path}/{name}", field if name in ("min", "max") else name)
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            yield from numbers(inner, f"{path}/{i}", field)
    elif isinstance(value, float):
        yield (path, field), value


def test_a_question_in_its_own_units_leaves_no_number_in_others() -> None:
    examples = [example(path.stem) for path in EXAMPLES.glob("*.json")]
    seen = set[str]()
    for body in (*MACHINES.values(), *examples):
        question = NondimensionalSpec.of(DesignSpec.model_validate(body))
        request, natural = (
            dict(numbers(spec.model_dump(mode="json")))
            for spec in (question.physical, question.scaled)
        )
        for place in request.keys() & natural.keys():
            length, time = powers(place[1])
            unit = question.units.length**length * question.units.time**time
            assert natural[place] * unit == pytest.approx(request[place], rel=1e-10), place
            seen.add(place[1])
    assert seen > {"max_mpa", "moving_mass_kg", "distance_mm", "rate_n_per_mm", "velocity_mm_per_s"}


def test_what_is_given_comes_back_to_the_last_digit() -> None:
    for body in MACHINES.values():
        question = NondimensionalSpec.of(DesignSpec.model_validate(body))
        assert question.to_physical(question.scaled) is question.physical
        low, high = ends(question.scaled.base_radius_mm)
        radius = 0.3 * low + 0.7 * high if low > 0.0 and high < inf else 3.0
        reported = question.to_physical(
            question.scaled.model_copy(update={"base_radius_mm": radius})
        )
        assert reported.base_radius_mm == radius * question.units.length
        assert reported.model_copy(update={"base_radius_mm": None}) == (
            question.physical.model_copy(update={"base_radius_mm": None})
        )


def test_in_units_of_its_own_a_question_has_no_size() -> None:
    for name, body in MACHINES.items():
        loaded = "load" in body
        one, other = (
            NondimensionalSpec.of(DesignSpec.model_validate(resized(body, k, loaded)))
            for k in (1.0, LARGE)
        )
        assert one.units.length * LARGE == pytest.approx(other.units.length, rel=1e-14)
        if name != "table":  # of a thousand numbers some are rounded the other way
            assert one.scaled == other.scaled
    assert one.units.time == pytest.approx(sqrt(one.units.length) if loaded else 60.0 / 2.0 / np.pi
                                           / one.physical.speed_rpm)  # fmt: skip
