"""What limits cost, against designs that were sought again with the limit changed."""

from __future__ import annotations

import sys
from functools import cache
from typing import Any

import pytest

from service.contract.examples import examples
from synthesis.design.analysis import Sensitivities, Sensitivity
from synthesis.design.design import Design
from synthesis.pipeline.synthesise import synthesise
from synthesis.spec.design_spec import DesignSpec
from synthesis.studies.sensitivity import sensitivities
from synthesis.studies.sensitivity.sensitivities import spec_numbers

CLOSE, COARSE = 5e-4, 4e-3  # tolerances to which designs are sought
CONE, LOCAL = "cone program", "IPOPT"
# how they are known, and fields that decide, by what share they are moved
SCENES: dict[str, tuple[str, dict[str, float]]] = {
    "example-13-6-sized": (CONE, {
        "/limits/0/rise_deg": 0.02, "/limits/0/return_deg": 0.02, "/limits/1/max_mm_per_s3": 0.03,
    }),
    "windows-and-points": (CONE, {
        "/limits/0/rise_deg": 0.02, "/limits/0/return_deg": 0.02, "/limits/1/max_mm_per_s3": 0.1,
        "/program/0/windows/0/velocity_mm_per_s": 0.02, "/program/2/points/0/travel_mm": 2e-3,
        "/program/2/points/1/travel_mm": 2e-3, "/program/2/points/1/tolerance_mm": 0.1,
    }),
    "table": (CONE, {"/limits/0/rise_deg": 0.02, "/follower/offset_mm": 0.1}),
    "norton-single-dwell": (CONE, {"/limits/0/max_mm_per_s3": 0.02}),
    "p3-sized": (LOCAL, {"/limits/0/rise_deg": 0.01, "/limits/0/return_deg": 0.01}),
    "least-pressure-angle": (LOCAL, {"/base_radius_mm/max": 0.02}),
}  # fmt: skip
# not all that decide: designs of these take longer, and are sought less closely
PARTLY: dict[str, tuple[str, dict[str, float]]] = {
    "flat-face": (CONE, {"/limits/1/left_mm": 0.02}),
    "oscillating-flat-face": (LOCAL, {"/limits/1/rise_deg": 0.02}),
    "undercut-limit": (LOCAL, {"/limits/2/min_mm": 0.03}),
    "oscillating-roller": (LOCAL, {"/follower/centre_distance_mm": 0.01}),
}


def sought(body: dict[str, Any], tolerance: float = CLOSE) -> Design:
    """To a tolerance that is small beside what the moved limits change."""
    return synthesise(DesignSpec.model_validate({**body, "proof": "quick", "tolerance": tolerance}))


def moved(body: dict[str, Any], field: str, share: float) -> dict[str, Any]:
    """The document with one number changed."""

    def copied(at: Any, path: list[str]) -> Any:
        if not path:
            return at * (1.0 + share)
        if isinstance(at, list):
            return [copied(v, path[1:]) if str(i) == path[0] else v for i, v in enumerate(at)]
        return {k: copied(v, path[1:]) if k == path[0] else v for k, v in at.items()}

    return dict(copied(body, field.split("/")[1:]))


def value(body: dict[str, Any], field: str, share: float, tolerance: float = CLOSE) -> float:
    """The best with one number moved."""
    found = sought(moved(body, field, share), tolerance).certificate.value
    assert found is not None
    return found


def tolerance(name: str) -> float:
    """To which the designs of a scene are sought."""
    return COARSE if name in PARTLY else CLOSE


@cache
def known(name: str) -> Sensitivities:
    design = sought(examples()[name]["value"], tolerance(name))
    return to(design, *PARTLY[name][1]) if name in PARTLY else sensitivities(design)


def to(design: Design, *fields: str) -> Sensitivities:
    """To some numbers alone: each takes designs of its own."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            sys.modules[sensitivities.__module__], "spec_numbers",
            lambda spec: (number for number in spec_numbers(spec) if number.pointer in fields),
        )  # fmt: skip
        return sensitivities(design)


@pytest.mark.parametrize("name", [*SCENES, *PARTLY])
def test_they_are_the_slopes_of_what_is_best(name: str) -> None:
    body, found = examples()[name]["value"], known(name)
    method, fields = (SCENES | PARTLY)[name]
    assert method in found.evidence
    assert found.unconfirmed == []
    reported = {each.field: each for each in found.sensitivities}
    for field, share in fields.items():
        more, less = (value(body, field, move, tolerance(name)) for move in (share, -share))
        rise = more - less
        assert reported[field].per_unit == pytest.approx(
            rise / (2.0 * share * reported[field].requested), rel=0.07
        )
    for field, each in reported.items():
        if name in SCENES and field not in fields:
            assert each.per_unit == 0.0, each.sentence


def test_they_are_told_in_words() -> None:
    words = {
        each.field: (each, each.sentence) for each in known("example-13-6-sized").sensitivities
    }
    rise, reported = words["/limits/0/rise_deg"]
    assert rise.per_unit is not None
    assert reported == (
        f"1 deg more in /limits/0/rise_deg makes base_radius {abs(rise.per_unit):.4g} mm smaller"
    )
    jerk, reported = words["/limits/1/max_mm_per_s3"]
    assert jerk.per_unit is not None
    one_per_cent = 0.01 * jerk.per_unit * jerk.requested
    assert reported.startswith("1 % more in")
    assert f"{abs(one_per_cent):.4g} mm smaller" in reported
    assert words["/follower/offset_mm/max"][1].endswith("has no influence")
    assert isinstance(rise, Sensitivity)


def test_a_limit_that_just_begins_to_bind_has_two_slopes() -> None:
    body = examples()["fixed-laws"]["value"]
    best = sought(body).dimensions["offset_mm"]
    touching = {**body, "follower": {**body["follower"], "offset_mm": {"min": -25.0, "max": best}}}
    design, field = sought(touching), "/follower/offset_mm/max"
    (found,) = (one for one in sensitivities(design).sensitivities if one.field == field)
    lost = value(touching, field, -1e-3) - value(touching, field, 0.0)
    assert found.per_unit is None
    assert found.per_unit_more == 0.0
    assert found.per_unit_less == pytest.approx(-lost / (1e-3 * best), rel=0.01)
    assert "more changes nothing; 1 mm less makes base_radius 1.43 mm larger" in found.sentence


def test_a_number_at_the_end_of_what_makes_sense_has_one_side() -> None:
    body = moved(examples()["flat-face"]["value"], "/limits/0/min_mm", -1.0)
    design = synthesise(DesignSpec.model_validate(body))
    found = {each.field: each for each in sensitivities(design).sensitivities}["/limits/0/min_mm"]
    assert found.per_unit_less is None
    assert found.per_unit_more == pytest.approx(1.0, rel=1e-4)  # Rb + s + s'' ≥ min
    assert "less has no cam" in found.sentence


def test_what_would_move_a_chosen_number_is_not_told() -> None:
    found = to(sought(examples()["free-arm"]["value"], COARSE), "/limits/0/rise_deg")
    assert found.unconfirmed == ["/limits/0/rise_deg"]
    assert "would move with these" in found.evidence


def test_a_radius_that_is_given_is_itself_whatever_else_may_move() -> None:
    """No cone program knows that it may not be smaller: the offset would seem to decide."""
    body = {**examples()["fixed-laws"]["value"], "base_radius_mm": 493.0}
    found = sensitivities(synthesise(DesignSpec.model_validate(body)))
    reported = {each.field: each.per_unit for each in found.sensitivities}
    assert reported.pop("/base_radius_mm") == pytest.approx(1.0, rel=1e-6)
    assert set(reported.values()) == {0.0}
    assert found.unconfirmed == []


@pytest.mark.usefixtures("unexplained")
def test_without_a_cam_there_are_none() -> None:
    found = sensitivities(sought(examples()["infeasible-on-purpose"]["value"], 0.05))
    assert found.sensitivities == []
    assert "no certified cam" in found.evidence


def test_out_of_time_what_is_not_known_is_listed() -> None:
    found = sensitivities(sought(examples()["p2-sized"]["value"]), deadline=0.0)
    assert found.sensitivities == []
    assert found.evidence
