"""The least peak of the force along the motion, against closed forms and other laws."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from synthesis import Design, DesignSpec, synthesise
from synthesis.catalogue.forces.reduced import history
from tests.catalogue.forces.test_limited import BODY

MASS, RPM, LIFT, RISE = 3.7, 211.0, 23.9, 83.0
JERK = 8e6
OMEGA, BETA = RPM * 2.0 * np.pi / 60.0, np.radians(RISE)


def designed(load: dict[str, Any], **changes: Any) -> Design:
    program = [
        {"kind": "rise", "angle_deg": RISE, "lift_mm": LIFT, "law": {"kind": "spline"}},
        {"kind": "dwell", "angle_deg": 41.0},
        {"kind": "return", "angle_deg": RISE, "lift_mm": LIFT, "law": {"kind": "spline"}},
        {"kind": "dwell", "angle_deg": 360.0 - 2.0 * RISE - 41.0},
    ]
    body = {
        "speed_rpm": RPM, "program": program, "load": {"kind": "slide"} | load,
        "follower": {"kind": "translating_flat_face"}, "base_radius_mm": 120.0,
        "limits": [{"kind": "jerk", "max_mm_per_s3": JERK}],
        "objective": {"kind": "peak_drive_force"}, "tolerance": 2e-3,
    }  # fmt: skip
    return synthesise(DesignSpec.model_validate(body | changes))


def test_a_mass_alone_takes_the_law_of_least_acceleration() -> None:
    """Pushed both ways, |m a|: of unit lift and angle (J/4)(1 − √(1 − 32/J)), J the jerk's cap."""
    groove = {"kind": "translating_roller", "roller_radius_mm": 8.1, "offset_mm": 2.3,
              "closure": {"kind": "groove"}}  # fmt: skip
    design = designed({"moving_mass_kg": MASS}, follower=groove)
    cap = JERK * BETA**3 / (LIFT * OMEGA**3)
    least = 0.25 * cap * (1.0 - np.sqrt(1.0 - 32.0 / cap))
    wanted = MASS * least * LIFT * 1e-3 * OMEGA**2 / BETA**2
    assert design.status == "optimal"
    value = design.objectives["peak_drive_force_n"]
    assert wanted * (1.0 - 1e-9) <= value <= wanted * (1.0 + 2e-3)
    assert design.certificate.lower_bound <= value


def test_a_spring_shifts_the_inertia_forward() -> None:
    """No law may do worse than its own top, and none of the named ones comes near."""
    load = {"moving_mass_kg": MASS, "damping_n_s_per_m": 33.0,
            "spring": {"rate_n_per_mm": 2.0, "preload_n": 70.0}}  # fmt: skip
    limits = [{"kind": "jerk", "max_mm_per_s3": JERK}, {"kind": "contact_force", "min_n": 0}]
    design = designed(load, limits=limits, tolerance=2e-2)
    value = design.objectives["peak_drive_force_n"]
    assert design.certificate.gap <= 2e-2
    assert value >= 70.0 + 2.0 * LIFT
    for law in ("modified_sine", "cycloidal", "polynomial_3_4_5", "modified_trapezoid"):
        program = [segment.model_dump(mode="json") for segment in design.spec.program]
        for segment in program:
            if segment["kind"] != "dwell":
                segment["law"] = {"kind": law}
        other = designed(load, program=program, limits=limits[1:])
        assert other.objectives["peak_drive_force_n"] > value * 1.001
    machine = design.completed_spec.machine()
    theta = np.linspace(0.0, 6.2831, 40_001)
    drive = history(
        machine.follower, machine.load, machine.omega, design.curve, tuple(design.size), theta
    ).drive
    assert drive.max() == pytest.approx(value, rel=1e-6)
    # an upright flat face: the drive is the contact force
    assert design.forces.flanks[0].largest_n.value == pytest.approx(value, rel=1e-9)


def test_a_process_force_that_changes_along_a_rise_is_refused() -> None:
    with pytest.raises(ValidationError, match="same value at both ends"):
        DesignSpec.model_validate(BODY | {"objective": {"kind": "peak_drive_force"}})
    alone = {name: value for name, value in BODY.items() if name != "load"}
    with pytest.raises(ValidationError, match="Give load"):
        DesignSpec.model_validate(alone | {"objective": {"kind": "peak_drive_force"}})
