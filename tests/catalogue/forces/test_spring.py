"""The closing spring: against a linear program on a dense turn, and against every other spring."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import linprog

from synthesis import Design, DesignSpec, analyse, synthesise
from synthesis.catalogue.forces.reduced import history
from synthesis.errors import InputError
from synthesis.optimise.parameters.spring_design import SpringProgram
from synthesis.studies.analyse import given_cam
from tests.catalogue.followers.samples import spec
from tests.catalogue.forces.loads import ARM, SLIDE, load_of, loaded
from tests.catalogue.forces.test_limited import BODY

SLOW, FAST = 211.0, 723.0
SPEEDS = {"speeds": {"min_rpm": SLOW, "max_rpm": FAST}}
KINDS = [("translating_roller", 0), ("translating_roller", 2), ("translating_flat_face", 1),
         ("oscillating_roller", 1), ("oscillating_flat_face", 0)]  # fmt: skip


def pulled(angle: float, damping: float) -> dict[str, Any]:
    """Drawn off the cam about one angle: where inertia presses it on, slow speeds are the worst,
    or one in between, if the damper draws as well.
    """
    points = [(angle - 21.0, 0.0), (angle, -900.0), (angle + 19.0, 0.0)]
    process = [{"angle_deg": place, "force_n": force} for place, force in points]
    return SLIDE | {"damping_n_s_per_m": damping, "process": process}


CASES = [(kind, sample, load_of(kind, sample)) for kind, sample in KINDS]


def dense_rows(
    kind: str, sample: int, load: dict[str, Any]
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """N = (s k + F0 + rest)/grip by unit springs: s, smallest and largest rest, grip."""
    question = spec(kind, sample, load=load | SPEEDS)
    cam, machine = given_cam(question), question.machine()
    theta = np.concatenate(
        [np.radians(np.linspace(0.0, 360.0, 3_601)[:-1]), np.radians([120.5 - 1e-9])]
    )

    def force(rate: float, preload: float, rpm: float) -> np.ndarray:
        load = replace(machine.load, rate=rate, preload=preload)
        omega = rpm * 2.0 * np.pi / 60.0
        found = history(machine.follower, load, omega, cam.motion, cam.size, theta)
        return found.contact[""]

    still = force(0.0, 0.0, SLOW)
    grip = 1.0 / (force(0.0, 1.0, SLOW) - still)
    s = (force(1.0, 0.0, SLOW) - still) * grip
    each = [force(0.0, 0.0, rpm) * grip for rpm in np.linspace(SLOW, FAST, 25)]
    return s, np.min(each, axis=0), np.max(each, axis=0), grip


@pytest.mark.parametrize(
    ("kind", "sample", "load"), [
        *CASES,
        ("translating_roller", 0, pulled(25.0, 41.0)),
        ("translating_roller", 0, pulled(235.0, 900.0)),
    ],
)  # fmt: skip
def test_it_is_the_best_of_all_springs(kind: str, sample: int, load: dict[str, Any]) -> None:
    question = spec(kind, sample, load=load | SPEEDS)
    cam, machine = given_cam(question), question.machine()
    ends = (0.0, np.inf)
    found = SpringProgram(cam.motion, machine, machine.load, cam.size, ends, ends).chosen()
    s, low, high, grip = dense_rows(kind, sample, load)
    one = np.ones_like(s)
    scale = np.abs(high).max()
    rows = (
        np.concatenate([np.stack([-s, -one, 0.0 * one], 1), np.stack([s, one, -grip], 1)]) / scale
    )
    wanted = linprog(
        [0.0, 0.0, 1.0], rows, np.concatenate([low, -high]) / scale,
        bounds=[(0, None), (0, None), (None, None)],
    )  # fmt: skip
    assert wanted.success
    assert found.peak == pytest.approx(wanted.fun, rel=3e-4)
    assert found.lacking == 0.0
    # every spring around: one that does not float has a peak that is no lower
    rates = found.rate * np.linspace(0.0, 2.0, 41) + 0.02 * np.arange(41) * (found.rate == 0.0)
    for rate in rates:
        preload = max(np.max(-(s * rate + low)), 0.0)
        peak = np.max((s * rate + preload + high) / grip)
        assert peak >= found.peak * (1.0 - 3e-4)


@pytest.fixture(scope="module")
def sprung() -> Design:
    load = BODY["load"] | {"spring": {}, "speeds": {"min_rpm": 60, "max_rpm": 391.0}}
    limits = [*BODY["limits"], {"kind": "contact_force", "min_n": 0}]
    return synthesise(DesignSpec.model_validate(BODY | {"load": load, "limits": limits}))


def test_a_cam_comes_with_its_spring(sprung: Design) -> None:
    assert sprung.status == "optimal"
    assert set(sprung.free_parameters) == {"load/spring/rate_n_per_mm", "load/spring/preload_n"}
    assert sprung.forces.float_onset_rpm == pytest.approx(391.0, rel=1e-3)
    assert sprung.forces.float_onset_rpm >= 391.0
    assert "any spring" in sprung.certificate.bound_valid_for
    spring = sprung.completed_spec.load.spring
    assert spring.rate_n_per_mm == sprung.free_parameters["load/spring/rate_n_per_mm"]
    stages = [stage.stage for stage in sprung.report.stages]
    assert "spring" in stages
    # over the wire and back it is the same cam with the same spring
    again = Design.model_validate_json(sprung.model_dump_json())
    assert again.completed_spec.load == sprung.completed_spec.load
    assert sprung.spec.load.spring.rate_n_per_mm is None


def test_the_cam_is_the_one_without_a_spring(sprung: Design) -> None:
    alone = {name: value for name, value in BODY.items() if name != "load"}
    cam = synthesise(DesignSpec.model_validate(alone))
    assert sprung.dimensions["base_radius_mm"] == pytest.approx(
        cam.dimensions["base_radius_mm"], rel=1e-3
    )


def test_ranges_of_a_spring_are_kept_and_float_is_told() -> None:
    soft = {"spring": {"rate_n_per_mm": 1.0, "preload_n": {"min": 0.0, "max": 20.0}}}
    design = synthesise(DesignSpec.model_validate(BODY | {"load": BODY["load"] | soft}))
    assert design.free_parameters == {"load/spring/preload_n": pytest.approx(20.0)}
    assert design.forces.floats
    assert design.forces.float_onset_rpm < BODY["speed_rpm"]


def test_an_analysis_asks_for_the_spring() -> None:
    load: dict[str, Any] = SLIDE | {"spring": {"preload_n": 10.0}}
    with pytest.raises(InputError, match="given in full") as caught:
        analyse(loaded("translating_roller", 0).model_copy(
            update={"load": spec("translating_roller", 0, load=load).load}
        ))  # fmt: skip
    assert caught.value.field == "/load/spring/rate_n_per_mm"


def test_an_arm_s_spring_is_told_in_its_own_unit() -> None:
    load = ARM | {"spring": {}, "speeds": {"min_rpm": 1, "max_rpm": 502.0}}
    design = synthesise(spec("oscillating_roller", 0, load=load))
    assert set(design.free_parameters) == {
        "load/spring/rate_n_m_per_rad",
        "load/spring/preload_n_m",
    }
    assert design.forces.float_onset_rpm == pytest.approx(502.0, rel=1e-3)


def test_a_follower_that_nothing_else_presses_keeps_a_little_force() -> None:
    """The best spring has no preload to speak of; what there is keeps the certificate content."""
    load = {name: value for name, value in BODY["load"].items() if name != "process"}
    limits = [*BODY["limits"], {"kind": "contact_force", "min_n": 0}]
    body = BODY | {"load": load | {"spring": {}}, "limits": limits}
    design = synthesise(DesignSpec.model_validate(body))
    assert design.status == "optimal"
    assert (
        0.0
        < design.forces.flanks[0].smallest_n.value
        < 1e-3 * (design.forces.flanks[0].largest_n.value)
    )


@pytest.mark.usefixtures("unexplained")
def test_of_several_objectives_a_spring_that_allows_no_cam_is_infeasible() -> None:
    """Such an answer has one proof without a value, not one for each objective."""
    load = {"kind": "slide", "moving_mass_kg": 2.0, "spring": {"rate_n_per_mm": 1.0}}
    moves = [
        {"kind": kind, "angle_deg": 110.0, "lift_mm": 10.0, "law": {"kind": "cycloidal"}}
        for kind in ("rise", "return")
    ]
    still = {"kind": "dwell", "angle_deg": 70.0}
    body = {
        "speed_rpm": 120.0,
        "program": [moves[0], still, moves[1], still],
        "follower": {"kind": "translating_roller", "roller_radius_mm": 6.0},
        "load": load,
        "limits": [
            {"kind": "pressure_angle", "rise_deg": 35.0, "return_deg": 35.0},
            {"kind": "contact_force", "max_n": 1.0},
        ],
        "objective": [{"kind": "base_radius"}, {"kind": "peak_jerk"}],
    }
    design = synthesise(DesignSpec.model_validate(body))
    assert design.status == "infeasible"
    assert not design.motion
    assert design.conflict is not None
    assert design.certificate.lower_bound is None
