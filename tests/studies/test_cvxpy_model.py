"""The cone program in CVXPY: the same optimum and multipliers, and rows of one's own."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import pytest

from synthesis import DesignSpec, synthesise
from synthesis.errors import InputError
from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.clarabel import solve
from synthesis.studies.cvxpy_model import CvxpyModel, cvxpy_model, on_wire
from tests.pipeline import scenes

PRESSURE = {"kind": "pressure_angle", "rise_deg": 31.0, "return_deg": 37.0}
JERK = {"kind": "jerk", "max_mm_per_s3": 2.5e5}
ROLLER = {"kind": "translating_roller", "roller_radius_mm": 9.5}
SCENES: dict[str, dict[str, Any]] = {
    "size": {"follower": ROLLER, "limits": [PRESSURE, JERK]},
    "none named": {"follower": ROLLER, "limits": [PRESSURE]},
    "peak": {
        "follower": {"kind": "translating_flat_face"}, "limits": [JERK],
        "objective": {"kind": "peak_acceleration"}, "base_radius_mm": {"max": 60.0},
    },
    "mean square": {
        "follower": ROLLER, "limits": [PRESSURE], "base_radius_mm": {"max": 25.0},
        "objective": {"kind": "rms_jerk"},
    },
}  # fmt: skip


def spec(**changes: Any) -> DesignSpec:
    body = {
        "speed_rpm": 90.0,
        "program": scenes.program(lift=23.0, angles=(97.0, 43.0, 113.0, 107.0)),
        "tolerance": 0.01,
        "proof": "quick",
    }
    return DesignSpec.model_validate(body | changes)


@pytest.fixture(scope="module", params=SCENES)
def model(request: pytest.FixtureRequest) -> CvxpyModel:
    made = cvxpy_model(spec(**SCENES[request.param]))
    made.problem.solve(solver="CLARABEL")
    return made


def multipliers(constraint: Any) -> Array:
    found = constraint.dual_value
    parts = found if isinstance(found, list) else [found]
    return np.concatenate([np.ravel(part) for part in parts])


def test_value_and_multipliers_are_our_own(model: CvxpyModel) -> None:
    program, own = model.conic.program, solve(model.conic.program)
    value = on_wire(model.question, model.conic, program.value(own.x))
    assert model.value() == pytest.approx(value, rel=1e-6)
    # A radius is minimised in mm, our own in the unit of the size: so are multipliers.
    unit = 1.0
    if "radius_mm" in model.variables:
        unit = model.conic.scales.size * model.question.question.units.length
    at, largest = 0, unit * float(np.abs(own.multipliers).max())
    for name, constraint in model.constraints.items():
        found = multipliers(constraint)
        wanted = unit * own.multipliers[at : at + len(found)]
        at += len(found)
        assert np.all(np.abs(found.sum() - wanted.sum()) <= 1e-3 * largest), name
        if np.abs(wanted).max() > 1e-2 * largest and len(found) > 1:  # where it acts
            place = np.arange(len(found)) @ np.abs(wanted) / np.abs(wanted).sum()
            here = np.arange(len(found)) @ np.abs(found) / np.abs(found).sum()
            assert here == pytest.approx(place, abs=0.02 * len(found)), name
    assert at == len(program.rhs)


def test_it_is_the_program_of_the_answer(model: CvxpyModel) -> None:
    """The answer's cam is no better, and hardly worse."""
    design = synthesise(model.question.question.physical)
    assert design.certificate.value is not None
    assert model.value() <= design.certificate.value * (1.0 + 1e-6)
    assert model.value() == pytest.approx(design.certificate.value, rel=0.05)


def test_a_row_of_ones_own_and_what_the_motion_is() -> None:
    made = cvxpy_model(spec(**SCENES["size"]))
    made.problem.solve(solver="CLARABEL")
    free, place = made.value(), made.motion(0, 0.5)
    before = float(place.value[0])
    assert 0.0 < before < 23.0
    limit = place[0] >= before + 2.0
    changed = made.with_constraints(limit)
    changed.solve(solver="CLARABEL")
    assert place.value[0] == pytest.approx(before + 2.0, rel=1e-6)
    assert made.value(changed) > free * 1.001
    # the row's multiplier is the size of a mm more
    further = made.with_constraints(place[0] >= before + 2.01)
    price = float(limit.dual_value)
    held = changed.value
    further.solve(solver="CLARABEL")
    assert (further.value - held) / 0.01 == pytest.approx(price, rel=0.02)
    # the return ends at rest at the bottom, and its velocity is negative on the way
    fall = made.motion(2, [0.0, 1.0]).value
    assert fall == pytest.approx([23.0, 0.0], abs=1e-6)
    mean = -23.0 / (113.0 / 360.0 * 60.0 / 90.0)
    middle = made.motion(2, np.linspace(0.0, 1.0, 2001), 1).value
    assert np.mean(middle) == pytest.approx(mean, rel=1e-3)
    with pytest.raises(KeyError, match="no law that is free"):
        made.motion(1, 0.5)


def test_what_has_no_single_program_is_refused() -> None:
    aim = {"kind": "peak_pressure_angle"}
    question = spec(follower=ROLLER, limits=[JERK], objective=aim, base_radius_mm=30.0)
    with pytest.raises(InputError, match="no single cone program"):
        cvxpy_model(question)


def test_without_cvxpy_the_message_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cvxpy", None)
    with pytest.raises(ImportError, match=r"camwright\[cvxpy\]"):
        cvxpy_model(spec(**SCENES["size"]))
