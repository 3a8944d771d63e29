"""Flat-face designs from spec to certificate: closed forms, a face that binds, honest refusals."""

from __future__ import annotations

from math import pi, sin
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError
from scipy.optimize import minimize_scalar

from synthesis.catalogue.laws import LAWS
from synthesis.design.design import Design, Extreme
from synthesis.exporters import MOTION_FORMATS, PROFILE_FORMATS, ProfileOptions
from synthesis.exporters.options import CamDrawingOptions
from synthesis.pipeline.synthesise import synthesise
from tests.exporters.written import written
from tests.numerics.geometry.cams import gentle
from tests.optimise.conic.test_flat_face import LEAST, RADIUS, question
from tests.optimise.scenes import LIFT, acceleration, jerk

BETA = 73.0 * pi / 180.0
NAMED = [name for name, law in LAWS.items() if gentle(law.curve("rise"))]


def extreme(design: Design, name: str) -> Extreme:
    (found,) = [e for e in design.extremes if e.limit == name]
    return found


def test_cycloidal_law_by_hand() -> None:
    design = synthesise(question(RADIUS, law="cycloidal"))

    def needed(x: float) -> float:  # ρ_min − s − s'' on the shorter move
        s = LIFT * (x - sin(2.0 * pi * x) / (2.0 * pi))
        return LEAST - s - LIFT / BETA**2 * 2.0 * pi * sin(2.0 * pi * x)

    worst = minimize_scalar(lambda x: -needed(x), bounds=(0.5, 1.0), options={"xatol": 1e-12})
    assert design.status == "optimal"
    assert design.dimensions["base_radius_mm"] == pytest.approx(-worst.fun, rel=3e-8)
    assert design.certificate.lower_bound == pytest.approx(-worst.fun, rel=1e-9)
    assert extreme(design, "profile_radius").angle_deg == pytest.approx(73.0 * worst.x, abs=1e-3)
    # contact at s' = h/β (1 − cos 2πx): 2h/β on the rise, as far on the return by its own angle
    assert design.dimensions["face_right_mm"] == pytest.approx(2.0 * LIFT / BETA, rel=1e-12)
    left = 2.0 * LIFT / (86.0 * pi / 180.0)
    assert design.dimensions["face_left_mm"] == pytest.approx(left, rel=1e-12)


@pytest.mark.parametrize("law", NAMED)
def test_given_laws_need_the_largest_of_least_radius_less_s_and_its_bend(law: str) -> None:
    spec = question(RADIUS, law=law)
    design = synthesise(spec)
    curve = design.curve
    breaks = curve.curve.breaks
    x = (breaks[:-1, None] + np.diff(breaks)[:, None] * np.linspace(0.0, 1.0, 3001)).ravel()
    both = [curve.derivatives(x, 2, side) for side in ("left", "right")]
    needed = max(float(np.max(LEAST - s[0] - s[2])) for s in both)
    assert design.status == "optimal"
    assert [stage.stage for stage in design.report.stages] == ["closed form"]
    assert design.dimensions["base_radius_mm"] == pytest.approx(needed, rel=2e-6)


def test_a_face_that_binds_costs_base_radius() -> None:
    free = synthesise(question(RADIUS, jerk(47.0, 73.0), tolerance=1e-2))
    right = free.dimensions["face_right_mm"] - 3.0
    tight = synthesise(
        question(
            RADIUS, jerk(47.0, 73.0), {"kind": "face_width", "right_mm": right}, tolerance=1e-2
        )
    )
    assert free.status == tight.status == "optimal"
    assert tight.dimensions["base_radius_mm"] > 1.02 * free.dimensions["base_radius_mm"]
    reported = extreme(tight, "face_right")
    assert reported.holds
    assert reported.value == pytest.approx(right, rel=1e-3)
    assert reported.value == pytest.approx(tight.dimensions["face_right_mm"], rel=1e-9)


def test_total_width_is_centred_on_the_slide() -> None:
    width = {"kind": "face_width", "width_mm": 82.0}
    design = synthesise(question(RADIUS, jerk(47.0, 73.0), width, tolerance=1e-2))
    reported = extreme(design, "face_width")
    assert design.status == "optimal"
    assert abs(reported.value or 0.0) == pytest.approx(82.0, rel=1e-3)
    assert max(design.dimensions[f"face_{side}_mm"] for side in ("left", "right")) <= 41.0


def test_undercut_is_refused_with_its_angle() -> None:
    design = synthesise(question(law="cycloidal", base_radius_mm=30.0))
    reported = extreme(design, "profile_radius")
    assert design.status == "infeasible"
    assert design.conflict is not None
    assert reported.value is not None
    assert reported.value < -20.0
    assert 50.0 < reported.angle_deg < 60.0
    assert f"at {reported.angle_deg:.3f}°" in design.conflict.evidence
    (mend,) = [r for r in design.conflict.relaxations if r.field == "base_radius_mm"]
    assert mend.needed == pytest.approx(30.0 - reported.value, rel=3e-6)
    assert mend.needed is not None
    mended = question(law="cycloidal", base_radius_mm=mend.needed)
    assert synthesise(mended).status == "optimal"


def test_a_smaller_profile_radius_is_offered_where_that_alone_helps() -> None:
    largest = {"max": synthesise(question(RADIUS, law="cycloidal")).size[0] - 4.1}
    design = synthesise(question(RADIUS, law="cycloidal", base_radius_mm=largest))
    assert design.conflict is not None
    (mend,) = [r for r in design.conflict.relaxations if r.limit == "profile_radius"]
    assert mend.needed == pytest.approx(LEAST - 4.1, rel=3e-3)
    assert mend.needed is not None
    assert mend.needed <= (LEAST - 4.1) * (1.0 + 1e-7)
    eased = {"kind": "profile_radius", "min_mm": LEAST - 4.1 - 1e-4}
    assert synthesise(question(eased, law="cycloidal", base_radius_mm=largest)).status == "optimal"


def test_a_jump_of_the_velocity_is_no_cam() -> None:
    design = synthesise(question(law="constant_velocity"))
    assert design.status == "infeasible"
    assert "velocity jumps" in extreme(design, "profile_radius").evidence
    assert design.conflict is not None
    assert "velocity jumps" in design.conflict.evidence


@pytest.mark.parametrize("rotation", ["ccw", "cw"])
def test_every_format_is_written(rotation: str) -> None:
    design = synthesise(question(RADIUS, law="polynomial_3_4_5", rotation=rotation))
    for exporter in PROFILE_FORMATS.values():
        assert len(written(exporter, design)) > 1000
        cutter = {"curve": "cutter", "cutter_diameter_mm": 8.0}
        other = exporter.options_like(ProfileOptions(points_per_degree=2.5, **cutter))
        assert len(exporter.write(design, other)) > 1000
    for exporter in MOTION_FORMATS.values():
        assert len(exporter.write(design, exporter.options())) > 1000
    drawing = PROFILE_FORMATS["svg"].write(design, CamDrawingOptions()).decode()
    assert "flat face, contact over" in drawing
    assert "knife edge" not in drawing


def test_the_rotation_mirrors_and_changes_no_number() -> None:
    a, b = (synthesise(question(RADIUS, law="cycloidal", rotation=r)) for r in ("ccw", "cw"))
    assert a.dimensions == b.dimensions
    assert [e.value for e in a.extremes] == [e.value for e in b.extremes]


@pytest.mark.parametrize(
    ("change", "rule"),
    [
        ({"objective": {"kind": "peak_pressure_angle"}}, "pressure_angle_given"),
        ({"limits": [{"kind": "face_width"}]}, "face_width_empty"),
        (
            {"limits": [{"kind": "face_width", "width_mm": 9.0}],
             "follower": {"kind": "translating_roller", "roller_radius_mm": 3.0}},
            "limit_does_not_suit",
        ),
    ],
)  # fmt: skip
def test_what_makes_no_sense_is_refused(change: dict[str, Any], rule: str) -> None:
    with pytest.raises(ValidationError) as caught:
        question(**{"law": "cycloidal", **change}) if "limits" not in change else _with(change)
    assert rule in [error["type"] for error in caught.value.errors()]


def _with(change: dict[str, Any]) -> None:
    body = question(law="cycloidal").model_dump(mode="json")
    type(question(law="cycloidal")).model_validate({**body, **change})


def test_a_pressure_angle_limit_and_a_cutter_hold_by_themselves() -> None:
    limits = [{"kind": "pressure_angle", "rise_deg": 1.0, "return_deg": 1.0, "dwell_deg": 1.0},
              {"kind": "cutter_radius", "radius_mm": 500.0}]  # fmt: skip
    design = synthesise(question(RADIUS, *limits, law="cycloidal"))
    assert design.status == "optimal"
    assert extreme(design, "pressure_angle_rise").value == 0.0


@settings(max_examples=6)
@given(
    st.floats(40.0, 110.0), st.floats(40.0, 110.0), st.floats(0.0, 30.0),
    st.sampled_from([None, *NAMED]), st.floats(1.5, 4.0), st.sampled_from(["jerk", "acceleration"]),
    st.booleans(),
)  # fmt: skip
def test_random_scenes_are_certified(
    up: float, down: float, least: float, law: str | None, factor: float, cap: str, outer: bool
) -> None:
    shorter = min(up, down)
    caps = {
        "jerk": jerk(32.0 * factor, shorter),
        "acceleration": acceleration(4.0 * factor, shorter),
    }
    limits: list[dict[str, Any]] = [{"kind": "profile_radius", "min_mm": least}]
    limits += [caps[cap]] if law is None else []
    limits += [{"kind": "outer_radius", "max_mm": 1e4}] if outer else []
    design = synthesise(
        question(*limits, law=law, tolerance=2e-2).model_copy(
            update={"program": _program(up, down, law)}
        )
    )
    assert design.certificate.certified
    assert all(e.holds for e in design.extremes)
    base, lower = design.dimensions["base_radius_mm"], design.certificate.lower_bound
    assert lower is not None
    assert lower <= base
    s = design.curve.derivatives(np.linspace(0.0, 2.0 * pi, 20001)[:-1])
    assert np.min(base + s[0] + s[2]) >= least


def _program(up: float, down: float, law: str | None) -> Any:
    from tests.optimise.scenes import dwell, fall, rise

    rest = 360.0 - up - down
    program = [rise(up, law=law), dwell(0.3 * rest), fall(down, law=law), dwell(0.7 * rest)]
    body = {**question().model_dump(mode="json"), "program": program}
    return type(question()).model_validate(body).program
