"""What limits cost, against designs that were sought again with the limit changed."""

from __future__ import annotations

from typing import Any

import pytest

from service.examples import examples
from synthesis.design import Design
from synthesis.findings import Sensitivity
from synthesis.pipeline import synthesise
from synthesis.sensitivity import sensitivities
from synthesis.spec import DesignSpec

SCENES: dict[str, dict[str, float]] = {  # fields that decide, and by what share they are moved
    "example-13-6-sized": {
        "/limits/0/rise_deg": 0.02, "/limits/0/return_deg": 0.02, "/limits/1/max_mm_per_s3": 0.03,
    },
    "flat-face": {
        "/limits/0/min_mm": 0.5, "/limits/1/left_mm": 0.02, "/limits/2/max_mm_per_s3": 0.04,
    },
    "table": {"/limits/0/rise_deg": 0.02, "/follower/offset_mm": 0.1},
    "norton-single-dwell": {"/limits/0/max_mm_per_s3": 0.02},
}  # fmt: skip


def sought(body: dict[str, Any]) -> Design:
    """To a tolerance that is small beside what the moved limits change."""
    return synthesise(DesignSpec.model_validate({**body, "tolerance": 5e-4}))


def moved(body: dict[str, Any], field: str, share: float) -> dict[str, Any]:
    """The document with one number changed."""

    def copied(at: Any, path: list[str]) -> Any:
        if not path:
            return at * (1.0 + share)
        if isinstance(at, list):
            return [copied(v, path[1:]) if str(i) == path[0] else v for i, v in enumerate(at)]
        return {k: copied(v, path[1:]) if k == path[0] else v for k, v in at.items()}

    return dict(copied(body, field.split("/")[1:]))


@pytest.mark.parametrize("name", SCENES)
def test_they_are_the_slopes_of_what_is_best(name: str) -> None:
    body = examples()[name]["value"]
    design = sought(body)
    found = sensitivities(design)
    assert found.value == design.certificate.value
    assert "multipliers" in found.evidence
    known = {each.field: each for each in found.sensitivities}
    for field, share in SCENES[name].items():
        above, below = (sought(moved(body, field, s)).certificate for s in (share, -share))
        assert above.value is not None
        assert below.value is not None
        slope = (above.value - below.value) / (2.0 * share * known[field].asked)
        assert known[field].per_unit == pytest.approx(slope, rel=0.03), field
    for field, each in known.items():
        if field not in SCENES[name]:
            assert each.per_unit == 0.0, each.words


def test_they_are_told_in_words() -> None:
    design = sought(examples()["example-13-6-sized"]["value"])
    words = {each.field: (each, each.words) for each in sensitivities(design).sensitivities}
    rise, told = words["/limits/0/rise_deg"]
    assert told == (
        f"1 deg more in /limits/0/rise_deg makes base_radius {abs(rise.per_unit):.4g} mm smaller"
    )
    jerk, told = words["/limits/1/max_mm_per_s3"]
    one_per_cent = 0.01 * jerk.per_unit * jerk.asked
    assert told.startswith("1 % more in")
    assert f"{abs(one_per_cent):.4g} mm smaller" in told
    assert words["/follower/offset_mm/max"][1].endswith("does not decide")
    assert isinstance(rise, Sensitivity)


@pytest.mark.parametrize(
    ("name", "word"),
    [
        ("undercut-limit", "not convex"),
        ("oscillating-roller", "cone program"),
        ("infeasible-on-purpose", "no certified cam"),
    ],
)
def test_where_they_are_not_known_that_is_said(name: str, word: str) -> None:
    body = examples()[name]["value"]
    found = sensitivities(synthesise(DesignSpec.model_validate({**body, "tolerance": 0.05})))
    assert found.sensitivities == []
    assert word in found.evidence
