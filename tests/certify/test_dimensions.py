"""The size against the spec's ranges."""

import math

import pytest

from synthesis.certify import certify_size
from synthesis.spec.design_spec import DesignSpec


def spec_of(**changed) -> DesignSpec:
    body = {
        "program": [
            {"kind": "rise", "angle_deg": 100.0, "lift_mm": 11.3, "law": {"kind": "cycloidal"}},
            {"kind": "dwell", "angle_deg": 60.0},
            {"kind": "return", "angle_deg": 90.0, "lift_mm": 11.3, "law": {"kind": "cycloidal"}},
            {"kind": "dwell", "angle_deg": 110.0},
        ],
        "follower": {
            "kind": "translating_roller", "roller_radius_mm": 8.9,
            "offset_mm": {"min": -4.0, "max": 7.0},
        },
        "base_radius_mm": {"min": 20.0, "max": 40.0},
    }  # fmt: skip
    return DesignSpec.model_validate({**body, **changed})


def size_of(base: float, e: float) -> tuple[float, float]:
    return e, math.sqrt((base + 8.9) ** 2 - e**2)


def judged(spec: DesignSpec, base: float, e: float) -> dict:
    return {extreme.limit: extreme for extreme in certify_size(spec, size_of(base, e))}


def test_inside():
    found = judged(spec_of(), 31.7, 5.1)
    assert all(extreme.holds for extreme in found.values())
    assert found["base_radius"].field == "base_radius_mm"
    assert found["base_radius"].margin == pytest.approx(8.3)
    assert found["base_radius"].bound == 40.0
    assert found["offset"].field == "follower/offset_mm"
    assert found["offset"].margin == pytest.approx(1.9)


@pytest.mark.parametrize(
    ("base", "e", "limit"),
    [(19.9999, 0.0, "base_radius"), (40.0001, 0.0, "base_radius"), (30.0, 7.0001, "offset"),
     (30.0, -4.0001, "offset")],
)  # fmt: skip
def test_outside(base, e, limit):
    found = judged(spec_of(), base, e)
    assert [name for name, extreme in found.items() if not extreme.holds] == [limit]
    assert found[limit].margin == pytest.approx(-1e-4)


def test_a_fixed_dimension_is_met_to_rounding():
    spec = spec_of(base_radius_mm=33.3)
    assert judged(spec, 33.3, 1.7)["base_radius"].holds
    assert judged(spec, 33.3 * (1.0 + 1e-14), 1.7)["base_radius"].holds
    for off in (1e-11, -1e-11):
        assert not judged(spec, 33.3 * (1.0 + off), 1.7)["base_radius"].holds


def test_an_open_range_has_nothing_to_show():
    spec = spec_of(base_radius_mm=None)
    assert "base_radius" not in judged(spec, 33.3, 1.7)
    spec = spec_of(base_radius_mm={"min": 20.0})
    assert judged(spec, 33.3, 1.7)["base_radius"].bound == 20.0
