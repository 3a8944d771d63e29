"""A very stiff elastic train, simulated by another part of the product, bears the rigid forces."""

from __future__ import annotations

import math

import pytest

from synthesis import Design, DesignSpec, synthesise
from synthesis.catalogue.forces.reduced import history
from synthesis.machines.dynamics.report import report_response
from synthesis.machines.dynamics.train import TrainSpec
from tests.catalogue.forces.test_limited import BODY, MASS, PRELOAD, RATE, RPM

STIFF = 3e6  # N/mm
LOAD = {name: value for name, value in BODY["load"].items() if name != "process"}


@pytest.fixture(scope="module")
def idle() -> Design:
    limits = [*BODY["limits"], {"kind": "hertz_pressure", "max_mpa": 600.0}]
    return synthesise(DesignSpec.model_validate(BODY | {"load": LOAD, "limits": limits}))


def test_the_simulation_of_a_stiff_train_agrees(idle: Design) -> None:
    link = {
        "mass_kg": MASS, "stiffness_n_per_mm": STIFF, "damping_n_s_per_mm": 5.0,
        "ground_stiffness_n_per_mm": RATE,
    }  # fmt: skip
    train = {"masses": [link], "preload_n": PRELOAD}
    onset = idle.forces.float_onset_rpm
    question = TrainSpec.model_validate(
        {"cam": idle.spec.model_dump(mode="json"), "train": train,
         "speeds_rpm": [RPM, 0.9 * onset, 1.1 * onset]}
    )  # fmt: skip
    found = report_response(question, idle)
    machine = idle.completed_spec.machine()
    size, theta = tuple(idle.size), [k * 6.283185 / 7200 for k in range(7200)]
    rigid = history(machine.follower, machine.load, machine.omega, idle.curve, size, theta).drive
    at = found.speeds[0]
    # a step of the force's slope makes the train swing by m j/ω_n beside it, at most twice that
    swinging = 2.0 * MASS * 3e4 / math.sqrt(1e3 * STIFF / MASS)
    assert swinging < 5e-3 * rigid.max()
    assert at.contact_force_max_n.value == pytest.approx(rigid.max(), abs=swinging)
    assert at.contact_force_min_n.value == pytest.approx(rigid.min(), abs=swinging)
    assert [speed.floats for speed in found.speeds] == [False, False, True]
    assert found.float_onset_rpm == pytest.approx(onset, rel=5e-3)
