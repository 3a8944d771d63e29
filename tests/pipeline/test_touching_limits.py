"""Limits that leave next to no room, or miss it by as little; what is exact has a formula.

The least peaks of a rise between dwells under other limits are those of bang-bang laws: 32 h/β³ of
jerk, 4 h/β² of acceleration (which no law of class C2 reaches), and the three formulas below.
"""

from __future__ import annotations

from math import sqrt
from typing import Any

import pytest
from scipy.optimize import brentq

from synthesis import Design, DesignSpec, synthesise
from tests.hard.cases import ANGLES, RISE, acceleration, jerk, moves, scene, velocity

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


@pytest.mark.usefixtures("unexplained")
@pytest.mark.parametrize("name", ["jerk", "acceleration", "velocity under jerk"])
def test_limits_that_one_law_touches_are_refused_without_that_claim(name: str) -> None:
    """There is a law, if only one: a certificate has no room, and no proof denies it."""
    design = designed(*SCENES[name](1.0))
    assert design.status == "unsolved"
    assert design.conflict is not None
    assert NO_LAW not in design.conflict.evidence


def test_acceleration_that_leaves_no_room_for_ramps_is_said_to_be_undecided() -> None:
    """A law of class C2 may be a hair gentler than those on knots can be; one that jumps is."""
    limit = acceleration(4.0 * (1.0 + 6e-4))
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
