"""The verifier itself: it shares nothing with the product, and it sees what is wrong."""

from __future__ import annotations

import ast
import copy
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from synthesis import DesignSpec, synthesise
from synthesis.catalogue.laws import LAWS
from tests.hard.cases import ANGLES, CENTRAL, FACE, FREE, H, jerk, moves, radius, scene
from tests.hard.own_laws import named
from tests.hard.random_specs import RESTS, TURNS
from tests.hard.verifier import verify
from tests.hard.witnesses import best, constant_jerk, contradictions

HERE = Path(__file__).parent
OWN = ("own_laws", "own_cam", "own_ringing", "verifier", "witnesses")


@pytest.mark.parametrize("module", OWN)
def test_it_imports_nothing_of_the_product(module: str) -> None:
    tree = ast.parse((HERE / f"{module}.py").read_text())
    names = [a.name for node in ast.walk(tree) if isinstance(node, ast.Import) for a in node.names]
    names += [node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    allowed = {f"tests.hard.{own}" for own in OWN}
    for name in names:
        assert name.split(".")[0] not in ("synthesis", "service"), name
        assert not name.startswith("tests.") or name in allowed, name


@pytest.mark.parametrize("kind", [*RESTS, *TURNS])
def test_both_write_the_same_laws(kind: str) -> None:
    """Two transcriptions of the same literature, in different forms."""
    for segment in ("rise", "return"):
        theirs = LAWS[kind].curve(segment)
        for a, b, g in named({"kind": kind}, segment):
            x = np.linspace(a, b, 23)[1:-1]
            for order in range(4):
                found, wanted = theirs(x, order), g(x, order)
                np.testing.assert_allclose(found, wanted, rtol=0, atol=2e-11 * 30.0**order)


def test_constant_jerk_is_what_it_says() -> None:
    pieces = constant_jerk()
    for (_, b, g), (c, _, f) in pairwise(pieces):
        for order in range(3):
            x = np.array([b]), np.array([c])
            np.testing.assert_allclose(g(x[0], order), f(x[1], order), atol=1e-12)
    assert {abs(float(g(np.array([a]), 3)[0])) for a, _, g in pieces} == {32.0}
    np.testing.assert_allclose(pieces[-1][2](np.ones(1), 0), 1.0, atol=1e-14)


# -- faults put in on purpose --------------------------------------------------------------------


def answer(spec: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    design = synthesise(DesignSpec.model_validate(spec)).model_dump(mode="json")
    return design["spec"], design


@pytest.fixture(scope="module")
def roller() -> tuple[dict[str, Any], dict[str, Any]]:
    return answer(scene(ANGLES, jerk(48.0), radius(3.0)))


@pytest.fixture(scope="module")
def face() -> tuple[dict[str, Any], dict[str, Any]]:
    width = {"kind": "face_width", "width_mm": 120.0}
    return answer(scene(jerk(48.0), radius(5.0), width, follower=FACE))


def limit(design: dict[str, Any], name: str) -> dict[str, Any]:
    return next(extreme for extreme in design["extremes"] if extreme["limit"] == name)


def smaller(design: dict[str, Any]) -> None:
    for name in ("base_radius_mm", "prime_radius_mm", "s0_mm"):
        if name in design["dimensions"]:
            design["dimensions"][name] *= 1.0 - 1e-4


def rougher(design: dict[str, Any]) -> None:
    coefficients = design["motion"][0]["spline"]["coefficients"]
    coefficients[len(coefficients) // 2] += 1e-4


def cut_short(design: dict[str, Any]) -> None:
    design["motion"][0]["spline"]["coefficients"][-1] = 1.0 - 1e-7


def kinked(design: dict[str, Any]) -> None:
    design["motion"][0]["spline"]["coefficients"][1] = 1e-6


def forgotten(design: dict[str, Any]) -> None:
    design["extremes"].remove(limit(design, "jerk"))


def bettered(design: dict[str, Any]) -> None:
    design["certificate"]["value"] *= 1.0 - 1e-5


def above(design: dict[str, Any]) -> None:
    design["certificate"]["lower_bound"] = 1.001 * design["certificate"]["value"]


def wide_gap(design: dict[str, Any]) -> None:
    design["status"] = "optimal"
    design["certificate"]["lower_bound"] = 0.9 * design["certificate"]["value"]
    design["certificate"]["gap"] = 0.1


def misread(design: dict[str, Any]) -> None:
    limit(design, "jerk")["value"] *= 0.999


FAULTS: list[Callable[[dict[str, Any]], None]] = [
    smaller, rougher, cut_short, kinked, forgotten, bettered, above, wide_gap, misread,
]  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("which", ["roller", "face"])
def test_it_sees_a_fault(
    which: str, fault: Callable[[dict[str, Any]], None], request: pytest.FixtureRequest
) -> None:
    spec, design = request.getfixturevalue(which)
    assert verify(spec, design) == []
    broken = copy.deepcopy(design)
    fault(broken)
    assert verify(spec, broken), fault.__name__


def test_it_sees_windows_and_points() -> None:
    spec = scene(ANGLES)
    rise, _, back, _ = spec["program"]
    rise["points"] = [{"angle_deg": 21.0, "travel_mm": 8.1, "tolerance_mm": 0.05,
                       "velocity_mm_per_s": 365.0}]  # fmt: skip
    rise["windows"] = [{"from_deg": 30.0, "to_deg": 40.0, "travel_mm": {"min": 9.0},
                        "velocity_mm_per_s": {"min": -3.0, "max": 480.0}}]  # fmt: skip
    back["windows"] = [{"from_deg": 13.0, "to_deg": 41.0, "jerk_mm_per_s3": {"max": 1e7},
                        "acceleration_mm_per_s2": {"max": 2e4}}]  # fmt: skip
    spec, design = answer(spec)
    assert verify(spec, design) == []
    for place, field, wrong in (
        ("points", "travel_mm", 8.3), ("points", "velocity_mm_per_s", 365.01),
        ("windows", "travel_mm", {"min": 20.0}), ("windows", "velocity_mm_per_s", {"max": 300.0}),
    ):  # fmt: skip
        other = copy.deepcopy(spec)
        other["program"][0][place][0][field] = wrong
        assert verify(other, design) != [], (place, field)
    assert contradictions(spec, {**design, "status": "infeasible"}) == []  # it makes no such laws


def test_a_refusal_without_ground_is_refuted(roller: tuple[dict[str, Any], dict[str, Any]]) -> None:
    spec, design = roller
    assert contradictions(spec, design | {"status": "infeasible"})


def test_a_bound_without_ground_is_refuted(roller: tuple[dict[str, Any], dict[str, Any]]) -> None:
    spec, design = roller
    witness = best(spec)
    assert witness is not None
    assert witness.value > design["certificate"]["value"]
    proof = {"lower_bound": 1.001 * witness.value, "bound_valid_for": "all motion laws"}
    assert contradictions(spec, design | {"certificate": proof})


def test_witnesses_are_cams_that_the_product_could_have_made() -> None:
    spec = scene(ANGLES, jerk(48.0), follower=CENTRAL, program=moves(H, law=FREE))
    witness = best(spec)
    assert witness is not None
    design = synthesise(DesignSpec.model_validate(spec))
    assert design.certificate.value is not None
    assert design.certificate.value <= witness.value
