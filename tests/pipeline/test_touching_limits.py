"""Limits that leave no room or next to none, or miss it by as little; what is exact has a formula.

The least peaks of a rise between dwells under other limits are those of bang-bang laws: 32 h/β³ of
jerk, 4 h/β² of acceleration (which no law of class C2 reaches), and the three formulas below.
"""

from __future__ import annotations

from dataclasses import replace
from math import sqrt
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from synthesis import Design, DesignSpec, synthesise
from synthesis.certify.second.recertify import recertify
from synthesis.optimise.strategy.phase_one import PhaseOneResult
from tests.hard.cases import ANGLES, RISE, acceleration, jerk, moves, radius, scene, velocity

pytestmark = pytest.mark.usefixtures("coarse_conflicts")

NO_LAW = "no motion law at all keeps these limits"
J, V_J, A = 50.0, 61.0, 6.1
A_LEAST = J / 4.0 * (1.0 - sqrt(1.0 - 32.0 / J))  # min max |a| under |j| ≤ J
V_UNDER_JERK = float(brentq(lambda v: v * (1.0 - 2.0 * sqrt(v / V_J)) - 1.0, 1.0, 2.0))
V_UNDER_ACCELERATION = (A - sqrt(A * A - 4.0 * A)) / 2.0


def designed(*limits: dict[str, Any]) -> Design:
    body = scene(ANGLES, *limits, program=moves(back=RISE))
    return synthesise(DesignSpec.model_validate(body))


SCENES: dict[str, Any] = {
    "jerk": lambda k: [jerk(32.0 * k)],
    "acceleration": lambda k: [acceleration(4.0 * k)],
    "acceleration under jerk": lambda k: [acceleration(A_LEAST * k), jerk(J)],
    "velocity under jerk": lambda k: [velocity(V_UNDER_JERK * k), jerk(V_J)],
    "velocity under acceleration": lambda k: [
        velocity(V_UNDER_ACCELERATION * k), acceleration(A)
    ],
}  # fmt: skip
FIT = [
    ("jerk", 1e-3), ("jerk", 1e-4), ("acceleration", 1e-2), ("acceleration", 3e-3),
    ("acceleration under jerk", 1e-3), ("acceleration under jerk", 1e-4),
    ("velocity under jerk", 1e-3), ("velocity under jerk", 1e-4),
    ("velocity under acceleration", 1e-2),
]  # fmt: skip
DO_NOT = [
    ("jerk", -1e-6), ("jerk", -1e-4), ("jerk", -1e-2), ("acceleration", -1e-6),
    ("acceleration", -1e-3), ("acceleration under jerk", -1e-2), ("velocity under jerk", -1e-3),
    ("velocity under acceleration", -2e-2),
]  # fmt: skip


@pytest.mark.parametrize(("name", "room"), FIT)
def test_what_little_room_there_is_is_found(name: str, room: float) -> None:
    design = designed(*SCENES[name](1.0 + room))
    assert design.certificate.certified
    assert design.certificate.gap is not None


@pytest.mark.usefixtures("unexplained")
@pytest.mark.parametrize(("name", "room"), DO_NOT)
def test_that_no_law_at_all_would_do_is_proven(name: str, room: float) -> None:
    design = designed(*SCENES[name](1.0 + room))
    assert design.status == "infeasible"
    assert design.conflict is not None
    assert design.conflict.evidence.startswith(NO_LAW)


MET = ["jerk", "acceleration under jerk", "velocity under jerk"]


@pytest.mark.parametrize("name", MET)
def test_limits_that_one_law_just_meets_have_that_cam(name: str) -> None:
    design, looser = designed(*SCENES[name](1.0)), designed(*SCENES[name](1.0 + 1e-4))
    _judge(design, looser)
    assert any("leave no slack" in stage.note for stage in design.report.stages)


@pytest.mark.parametrize("seed", [0, 1, 2, 5])  # each follower; one law or both
def test_the_least_jerk_of_any_law_is_enough(seed: int) -> None:
    """32 h (ω/β)³ on one law or both, with random lifts, angles, speeds and followers."""
    draw = np.random.default_rng(seed)
    lift, rpm = 10.0 ** draw.uniform(-2.0, 2.5), 10.0 ** draw.uniform(0.0, 3.0)
    rise = draw.uniform(25.0, 150.0)
    back = rise if seed % 3 == 0 else rise * draw.uniform(1.02, 1.4)
    least = 32.0 * lift * (np.radians(6.0 * rpm) / np.radians(rise)) ** 3
    follower = [
        {"kind": "translating_roller", "roller_radius_mm": lift * draw.uniform(0.05, 0.5)},
        {"kind": "translating_roller", "roller_radius_mm": 0.2 * lift, "offset_mm": 0.0},
        {"kind": "translating_flat_face"},
    ][seed % 3 if seed % 2 else 0]
    angle = draw.uniform(20.0, 50.0)
    limits: list[dict[str, Any]] = [
        {"kind": "pressure_angle", "rise_deg": angle, "return_deg": angle}
    ]
    if follower["kind"] == "translating_flat_face":
        limits = [{"kind": "profile_radius", "min_mm": lift * draw.uniform(0.1, 1.0)}]

    def with_jerk(share: float) -> Design:
        body = {
            "speed_rpm": rpm, "program": moves(lift, rise, 11.3, back), "follower": follower,
            "limits": [*limits, {"kind": "jerk", "max_mm_per_s3": least * share}],
        }  # fmt: skip
        return synthesise(DesignSpec.model_validate(body))

    _judge(with_jerk(1.0), with_jerk(1.0 + 1e-4))


def _judge(design: Design, looser: Design) -> None:
    """A certified cam, as the second judge says too; next to one of slightly wider limits."""
    assert design.status in {"optimal", "feasible"}
    assert design.conflict is None
    measured = recertify(design)
    assert not [each for each in measured.lines if each.agrees is False or each.holds is False]
    found, wider = design.certificate, looser.certificate
    assert found.value is not None
    assert found.gap is not None
    assert found.gap < 2e-2
    assert wider.value is not None
    assert wider.lower_bound is not None
    assert wider.lower_bound <= found.value <= wider.value * (1.0 + 2e-2)


def test_a_gentle_law_in_place_of_a_refused_cam_keeps_the_bound_and_the_tolerance() -> None:
    """The cam of little acceleration is searched with a tolerance of its own."""
    limits = [radius(20.0), jerk(32.0 * 1.00003, 49.9, np.radians(79.0))]
    program = moves(49.9, 79.0, 11.3, 109.9)
    body = scene(
        *limits, program=program, follower={"kind": "translating_flat_face"}, tolerance=1e-3
    )
    design = synthesise(DesignSpec.model_validate(body))
    proof = design.certificate
    assert proof.gap is not None
    assert (design.status == "optimal") == (proof.gap <= design.spec.tolerance)
    assert proof.gap > design.spec.tolerance, "refused no more: another scene is needed here"
    assert any(stage.exit == "sufficient" for stage in design.report.stages)
    assert proof.gap < 0.1


@pytest.mark.usefixtures("unexplained")
def test_a_limit_that_laws_only_approach_is_refused_without_a_proof() -> None:
    """Of acceleration there is no gentlest law of class C2: 4 h/β² is an infimum."""
    design = designed(*SCENES["acceleration"](1.0))
    assert design.status == "unsolved"
    assert design.conflict is not None
    assert NO_LAW not in design.conflict.evidence


@pytest.mark.usefixtures("unexplained")
def test_acceleration_that_leaves_no_room_for_ramps_is_said_to_be_undecided() -> None:
    """A law of class C2 may be a hair gentler than those on knots can be; one that jumps is."""
    limit = acceleration(4.0 * (1.0 + 2e-5))
    refused = designed(limit)
    assert refused.conflict is not None
    evidence = refused.conflict.evidence
    assert evidence.startswith("whether a law keeps these limits is not known")
    assert "not proven" in evidence
    assert "smoothness 1" in evidence
    law = {"kind": "spline", "smoothness": 1}
    body = scene(ANGLES, limit, program=moves(law=law, back=RISE))
    assert synthesise(DesignSpec.model_validate(body)).certificate.certified


def test_what_is_needed_is_told_closely_where_no_law_would_do() -> None:
    design = designed(jerk(32.0 * 0.97))
    assert design.conflict is not None
    (needed,) = (r.needed / r.requested for r in design.conflict.relaxations if r.needed)
    assert needed == pytest.approx(1.0 / 0.97, rel=1e-3)


def test_a_law_that_meets_its_limits_is_fixed_only_where_it_is_held_back() -> None:
    """Where none is held back the rest of the problem is the problem itself: nothing ends that."""
    met = PhaseOneResult((), 1.0, 1.0, ("jerk",), tight=(0,))
    assert met.just_meets
    assert not replace(met, tight=()).just_meets
