"""A face tilted against its slide: closed forms, another solver, honest refusals."""

from __future__ import annotations

import copy
from collections.abc import Callable
from math import cos, pi, radians, sin, tan
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError
from scipy.optimize import differential_evolution, linprog, minimize_scalar

from service.contract.examples import examples
from synthesis.design.design import Design
from synthesis.exporters import PROFILE_FORMATS
from synthesis.exporters.options import CamDrawingOptions
from synthesis.pipeline.synthesise import synthesise
from synthesis.spec.design_spec import DesignSpec
from synthesis.studies.analyse import analyse
from tests.exporters.written import written
from tests.optimise.conic.test_flat_face import LEAST, RADIUS, question
from tests.optimise.scenes import LIFT, jerk
from tests.pipeline.test_flat_face import BETA, extreme

TILT, OFFSET = 23.7, -8.3


def tilted(
    *limits: dict[str, Any], tilt: float = TILT, offset: float = OFFSET, **more: Any
) -> DesignSpec:
    face = {"kind": "translating_flat_face", "tilt_deg": tilt, "offset_mm": offset}
    return question(*limits, follower=face, **more)


def reach(design: Design, theta: np.ndarray) -> np.ndarray:
    """Where contact is along the face from the slide's line, from lines and points alone.

    The profile's support line at each angle is the face; the slide's line is x = c.
    """
    tilt, c, base = radians(TILT), OFFSET, design.dimensions["base_radius_mm"]
    s = design.curve.derivatives(theta)
    foot = np.stack([np.full(len(theta), c), (base + c * sin(tilt)) / cos(tilt) + s[0]])
    touched = np.stack([
        -sin(tilt) * (base + s[0] * cos(tilt)) + s[1] * cos(tilt) ** 2,
        cos(tilt) * (base + s[0] * cos(tilt)) + s[1] * cos(tilt) * sin(tilt),
    ])  # fmt: skip
    return np.asarray([cos(tilt), sin(tilt)] @ (touched - foot))


def test_cycloidal_law_by_hand() -> None:
    design = synthesise(tilted(RADIUS, law="cycloidal"))

    def bend(x: float) -> float:  # s + s'' on the shorter move
        s = LIFT * (x - sin(2.0 * pi * x) / (2.0 * pi))
        return s + LIFT / BETA**2 * 2.0 * pi * sin(2.0 * pi * x)

    worst = minimize_scalar(bend, bounds=(0.5, 1.0), options={"xatol": 1e-12})
    needed = LEAST - worst.fun * cos(radians(TILT))
    assert design.status == "optimal"
    assert design.dimensions["base_radius_mm"] == pytest.approx(needed, rel=3e-8)
    reported = reach(design, np.linspace(0.0, 2.0 * pi, 40001))
    assert design.dimensions["face_right_mm"] == pytest.approx(np.max(reported), abs=1e-6)
    assert design.dimensions["face_left_mm"] == pytest.approx(-np.min(reported), abs=1e-6)


@pytest.mark.parametrize("right", [12.9, 17.1])
def test_the_size_agrees_with_dense_rows_and_with_a_blind_search(right: float) -> None:
    """A positive tilt draws contact to the left as the cam grows: the right end asks for size."""
    face = {"kind": "face_width", "right_mm": right, "left_mm": 90.0}
    design = synthesise(tilted(RADIUS, face, law="polynomial_3_4_5"))
    theta = np.linspace(0.0, 2.0 * pi, 20001)
    s = design.curve.derivatives(theta)
    tilt = radians(TILT)
    at_axis = s[1] * cos(tilt) - s[0] * sin(tilt) - OFFSET / cos(tilt)
    rows = np.concatenate([
        LEAST - (s[0] + s[2]) * cos(tilt), (at_axis - right) / tan(tilt)
    ])  # fmt: skip
    rows = np.sort(rows)[-99:]  # all others are implied
    upper = (90.0 + at_axis) / tan(tilt)
    found = linprog([1.0], -np.ones((len(rows), 1)), -rows, bounds=(0.0, float(np.min(upper))))
    assert design.status == "optimal"
    assert design.dimensions["base_radius_mm"] == pytest.approx(found.fun, rel=1e-6)
    assert extreme(design, "face_right").holds
    blind = differential_evolution(
        lambda z: z[0] + 1e3 * max(np.max(rows - z[0]), 0.0), [(1.0, 300.0)], seed=3, tol=1e-12,
    )  # fmt: skip
    assert design.dimensions["base_radius_mm"] == pytest.approx(blind.fun, rel=1e-6)


def test_a_tilt_lets_a_free_law_s_cam_be_smaller_and_is_its_pressure_angle() -> None:
    limits = [RADIUS, jerk(47.0, 73.0)]
    upright, leaning = (
        synthesise(tilted(*limits, tilt=tilt, offset=0.0, tolerance=1e-2)) for tilt in (0.0, TILT)
    )
    assert upright.status == leaning.status == "optimal"
    bases = [d.dimensions["base_radius_mm"] - LEAST for d in (upright, leaning)]
    assert bases[1] == pytest.approx(bases[0] * cos(radians(TILT)), rel=2e-2)
    assert leaning.certificate.bound_valid_for == "all motion laws with a bounded jerk"


@pytest.mark.usefixtures("unexplained")
def test_contact_that_leaves_the_face_is_found_with_its_angle() -> None:
    face = {"kind": "face_width", "right_mm": 5.1}
    given_cam = tilted(RADIUS, face, law="cycloidal", base_radius_mm=83.0)
    reported = analyse(given_cam)
    assert reported.violated == ["face_right"]
    (broken,) = [e for e in reported.extremes if e.limit == "face_right"]
    design = synthesise(given_cam)
    assert design.status == "infeasible"
    assert extreme(design, "face_right") == broken
    theta = np.linspace(0.0, 2.0 * pi, 72001)
    where = reach(design, theta)
    assert broken.value == pytest.approx(np.max(where), rel=1e-7)
    assert broken.angle_deg == pytest.approx(np.degrees(theta[np.argmax(where)]), abs=1e-2)
    assert reported.remedy is not None
    (size,) = reported.remedy.sizes
    assert size.status == "optimal"
    assert size.dimensions["base_radius_mm"] > 83.0


def test_a_least_size_that_pushes_contact_off_the_face_is_named() -> None:
    face = {"kind": "face_width", "left_mm": 40.0}
    design = synthesise(
        tilted(RADIUS, face, offset=0.0, law="cycloidal", base_radius_mm={"min": 95.0})
    )
    assert design.status == "infeasible"
    assert design.conflict is not None
    fields = {r.field: r.needed for r in design.conflict.relaxations}
    assert set(fields) == {"limits/1/left_mm"}  # even the smallest cam would need more
    needed = fields["limits/1/left_mm"]
    assert needed is not None
    wider = {"kind": "face_width", "left_mm": needed * (1.0 + 1e-6)}
    mended = tilted(RADIUS, wider, offset=0.0, law="cycloidal", base_radius_mm={"min": 95.0})
    assert synthesise(mended).status == "optimal"


@pytest.mark.parametrize(("tilt", "law"), [(TILT, None), (-TILT, "cycloidal")])
def test_a_pressure_angle_below_the_tilt_cannot_be(
    tilt: float, law: str | None, explain_only: Callable[[str], None]
) -> None:
    explain_only("limits/1/rise_deg")
    limit = {"kind": "pressure_angle", "rise_deg": 19.0, "return_deg": 35.0}
    design = synthesise(tilted(RADIUS, limit, jerk(60.0, 73.0), tilt=tilt, law=law, tolerance=1e-2))
    assert design.status == "infeasible"
    assert design.conflict is not None
    assert "whatever law and size" in design.conflict.evidence
    (mend,) = [r for r in design.conflict.relaxations if r.field == "limits/1/rise_deg"]
    assert TILT <= mend.needed <= TILT * (1.0 + 1.1e-6)  # a cam may need a millionth of slack
    reported = extreme(design, "pressure_angle_rise")
    assert not reported.holds
    assert reported.value == pytest.approx(tilt, rel=1e-12)
    allowed = {"kind": "pressure_angle", "rise_deg": 24.0, "return_deg": 35.0}
    fits = synthesise(tilted(RADIUS, allowed, jerk(60.0, 73.0), tilt=tilt, law=law, tolerance=1e-2))
    assert fits.status == "optimal"


def test_a_tilt_that_nobody_could_make_is_refused() -> None:
    with pytest.raises(ValidationError, match="Give 0"):
        tilted(law="cycloidal", tilt=2e-4)


def test_the_tilt_leaves_nothing_to_choose_of_the_pressure_angle() -> None:
    with pytest.raises(ValidationError) as caught:
        tilted(law="cycloidal", objective={"kind": "peak_pressure_angle"})
    assert caught.value.errors()[0]["type"] == "pressure_angle_given"


@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize("tilt", [TILT, -66.0])
def test_the_drawing_holds_the_face(rotation: str, tilt: float) -> None:
    design = synthesise(tilted(RADIUS, law="cycloidal", tilt=tilt, rotation=rotation))
    for exporter in PROFILE_FORMATS.values():
        assert len(written(exporter, design)) > 1000
    drawing = PROFILE_FORMATS["svg"].write(design, CamDrawingOptions()).decode()
    assert "flat face, contact over" in drawing


@settings(max_examples=6)
@given(
    st.sampled_from([-1.0, 1.0]), st.floats(0.5, 60.0), st.floats(-40.0, 40.0),
    st.sampled_from([None, "cycloidal", "polynomial_5_6_7_8_9"]), st.floats(60.0, 160.0),
)  # fmt: skip
def test_random_tilts_are_certified(
    sign: float, tilt: float, c: float, law: str | None, wide: float
) -> None:
    tilt = sign * tilt
    caps = [] if law else [jerk(60.0, 73.0)]
    face = {"kind": "face_width", "right_mm": wide, "left_mm": wide}
    design = synthesise(tilted(RADIUS, face, *caps, tilt=tilt, offset=c, law=law, tolerance=2e-2))
    if not design.motion:
        assert design.conflict is not None
        assert design.conflict.limits
        return
    assert all(e.holds for e in design.extremes)
    s = design.curve.derivatives(np.linspace(0.0, 2.0 * pi, 20001)[:-1])
    lean, base = radians(tilt), design.dimensions["base_radius_mm"]
    assert np.min(base + (s[0] + s[2]) * cos(lean)) >= LEAST
    along = s[1] * cos(lean) - s[0] * sin(lean) - base * tan(lean) - c / cos(lean)
    assert np.max(abs(along)) <= wide


@pytest.mark.parametrize("cap", [1.289e6, 1.539e6, 1.594e6])
def test_a_round_that_added_hardly_any_knot_ends_no_search(cap: float) -> None:
    """Knots at single switches gained nothing; halved everywhere, they halve the gap."""
    body = copy.deepcopy(examples()["tilted-flat-face"]["value"])
    body["program"][0]["angle_deg"] += 11.0
    body["program"][3]["angle_deg"] -= 11.0
    body["limits"][3]["max_mm_per_s3"] = cap
    design = synthesise(DesignSpec.model_validate({**body, "tolerance": 5e-3}))
    assert design.status == "optimal"
