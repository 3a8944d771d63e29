"""Laws found on a question's rounded numbers meet on the numbers as asked, to the last digits."""

from __future__ import annotations

import numpy as np
import pytest

from synthesis import Design, DesignSpec, synthesise
from tests.hard.random_specs import random_spec
from tests.hard.verifier import verify


@pytest.mark.parametrize("number", [1423, 24])
def test_high_derivatives_meet_at_joints_of_free_laws(number: int) -> None:
    """Both have joints where a derivative is a thousand times lift/β^k: 1e-11 of it shows."""
    body = random_spec(number) | {"proof": "quick"}
    design = synthesise(DesignSpec.model_validate(body))
    joins = {each.limit: each for each in design.extremes if each.limit.endswith("_join")}
    assert design.status in ("optimal", "feasible")
    assert all(each.value <= 0.5 * each.bound for each in joins.values())
    assert len(joins) >= 4
    assert not verify(design.model_dump(mode="json")["spec"], design.model_dump(mode="json"))


def test_a_law_meets_a_given_one_that_does_not_rest() -> None:
    """A spline between a law that begins with an acceleration of its own, and a dwell."""
    body = {
        "speed_rpm": 71.3,
        "program": [
            {"kind": "rise", "angle_deg": 71.7, "lift_mm": 13.1, "law": {"kind": "spline"}},
            {
                "kind": "rise", "angle_deg": 57.1, "lift_mm": 17.9,
                "law": {"kind": "constant_velocity"},
            },
            {"kind": "rise", "angle_deg": 61.3, "lift_mm": 11.7, "law": {"kind": "spline"}},
            {"kind": "return", "angle_deg": 97.9, "lift_mm": 42.7},
            {"kind": "dwell", "angle_deg": 72.0},
        ],
        "follower": {"kind": "translating_roller", "roller_radius_mm": 8.3},
        "limits": [{"kind": "pressure_angle", "rise_deg": 37.0, "return_deg": 43.0}],
        "tolerance": 0.05,
        "proof": "quick",
    }  # fmt: skip
    design = synthesise(DesignSpec.model_validate(body))
    joins = {each.limit: each for each in design.extremes if each.limit.endswith("_join")}
    assert design.status != "infeasible", design.conflict
    assert all(each.value <= 0.5 * each.bound for each in joins.values())


@pytest.mark.parametrize("first", [True, False])
def test_where_one_of_two_laws_may_overshoot_the_velocity_between_them_is_free(first: bool) -> None:
    """The quicker move takes some of the other's angle, which goes beyond the lift: less jerk."""
    angles = (103.0, 81.0) if first else (81.0, 103.0)

    def answer(*overshoot: bool) -> Design:
        moves = [
            {
                "kind": kind, "angle_deg": angle, "lift_mm": 10.7,
                "law": {"kind": "spline", "overshoot": may},
            }
            for kind, angle, may in zip(("rise", "return"), angles, overshoot, strict=True)
        ]  # fmt: skip
        body = {
            "speed_rpm": 61.0,
            "program": [*moves, {"kind": "dwell", "angle_deg": 176.0}],
            "follower": {"kind": "translating_flat_face"},
            "base_radius_mm": 900.0,
            "objective": {"kind": "peak_jerk"},
            "proof": "quick",
        }
        return synthesise(DesignSpec.model_validate(body))

    turning, free = answer(False, False), answer(first, not first)
    assert turning.certificate.lower_bound is not None
    assert free.certificate.certified
    assert free.certificate.value is not None
    velocity = free.curve.derivatives([np.radians(angles[0])])[1, 0]
    assert velocity * (-1.0 if first else 1.0) > 0.1
    assert free.certificate.value < 0.9 * turning.certificate.lower_bound
