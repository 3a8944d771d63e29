"""A cam that cuts itself: what an analysis says of it, and what a design does about it."""

from __future__ import annotations

import math
from typing import Any

import pytest

from synthesis import DesignSpec, analyse, synthesise
from synthesis.catalogue.motion import Motion
from synthesis.design.design import Design
from tests.certify.crossing import brute

BASE = 0.51
CLEAR = 0.934  # the base radius at which the roots of the lobe come apart


def lobe(**changes: Any) -> DesignSpec:
    """A roller of 7.6 mm over a high lobe whose root is thin where the base radius is small."""
    body: dict[str, Any] = {
        "program": [
            {"kind": "rise", "angle_deg": 66, "lift_mm": 57, "law": {"kind": "polynomial_4_5_6_7"}},
            {"kind": "dwell", "angle_deg": 9},
            {"kind": "return", "angle_deg": 58, "lift_mm": 57, "law": {"kind": "cycloidal"}},
            {"kind": "dwell", "angle_deg": 227},
        ],
        "follower": {"kind": "translating_roller", "roller_radius_mm": 7.6, "offset_mm": 1.3},
        "base_radius_mm": BASE,
        "limits": [],
    }
    return DesignSpec.model_validate(body | changes)


def crossing(found: Design) -> Any:
    return next(e for e in found.extremes if e.limit == "self_crossing")


@pytest.mark.usefixtures("unmended")
def test_an_analysis_names_both_angles_and_the_depth() -> None:
    question = lobe()
    found = analyse(question)
    assert found.violated == ["self_crossing"]
    assert found.undercut is None
    reported = found.self_crossing
    assert reported is not None
    motion, s0 = Motion.of(question.placed_segments()), math.sqrt((BASE + 7.6) ** 2 - 1.3**2)
    seen = brute(motion, 1.3, s0, 7.6)
    close = brute(motion, 1.3, s0, 7.6, (seen.profile, seen.roller, 6e-3))
    assert reported.depth_mm == pytest.approx(7.6 - close.distance, abs=1e-6)
    assert reported.profile_deg == pytest.approx(math.degrees(close.profile), abs=0.01)
    assert reported.roller_deg == pytest.approx(math.degrees(close.roller), abs=0.01)


@pytest.mark.usefixtures("unexplained")
def test_a_larger_cam_mends_it(request: pytest.FixtureRequest) -> None:
    found = analyse(lobe())
    assert found.remedy is not None
    for size in found.remedy.sizes:
        assert size.status == "feasible"
        assert size.dimensions["base_radius_mm"] == pytest.approx(CLEAR, rel=0.02)
    request.getfixturevalue("unmended")
    kept = found.remedy.sizes[0].dimensions["base_radius_mm"]
    larger = analyse(lobe(base_radius_mm=kept))
    assert larger.holds
    assert larger.self_crossing is None
    assert analyse(lobe(base_radius_mm=0.99 * kept)).self_crossing is not None


def test_a_design_grows_until_it_does_not_cross_itself() -> None:
    found = synthesise(lobe(base_radius_mm={"min": 0.4, "max": 60}))
    assert found.status == "feasible"
    assert crossing(found).holds
    assert found.dimensions["base_radius_mm"] == pytest.approx(CLEAR, rel=5e-3)
    # the bound stays that of the question as asked, which knows nothing of crossing
    assert found.certificate.lower_bound == pytest.approx(0.4)
    assert found.certificate.gap == pytest.approx(1.0 - 0.4 / found.dimensions["base_radius_mm"])
    (ranged,) = (e for e in found.extremes if e.limit == "base_radius")
    assert ranged.bound == 0.4


@pytest.mark.usefixtures("unexplained")
def test_a_design_that_may_not_grow_is_refused_for_it() -> None:
    found = synthesise(lobe(base_radius_mm={"min": 0.4, "max": 0.7}))
    assert found.status == "unsolved"
    assert not crossing(found).holds
    assert found.conflict is not None
    assert "self crossing" in found.conflict.limits
    assert "self_crossing" in found.conflict.evidence


def test_later_objectives_of_a_grown_cam_keep_no_bound() -> None:
    objective = [{"kind": "base_radius"}, {"kind": "peak_acceleration"}]
    found = synthesise(lobe(base_radius_mm={"min": 0.4, "max": 60}, objective=objective))
    assert found.status == "feasible"
    assert [proof.lower_bound for proof in found.certificate.other_objectives] == [None]
    assert found.certificate.lower_bound == pytest.approx(0.4)
