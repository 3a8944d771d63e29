"""Cylinders made small where undercut decides."""

from __future__ import annotations

from math import radians, tan
from typing import Any

import pytest

from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.pipeline import synthesise_spatial
from tests.machines.spatial.drums import SAMPLES


def sized(law: str, *limits: dict[str, Any]) -> SpatialDesign:
    """The slide's cam with its cylinder free."""
    sample = SAMPLES["slide in a groove"]
    steps = [step | ({"law": {"kind": law}} if "law" in step else {})
             for step in sample.body["program"]]  # fmt: skip
    machine = sample.body["machine"] | {"cylinder_radius_mm": {"min": 15.0, "max": 300.0}}
    return synthesise_spatial(sample.spec(program=steps, machine=machine, limits=list(limits)))


def pressure_angle(degrees: float) -> dict[str, Any]:
    return {"kind": "pressure_angle", "max_deg": degrees}


def test_where_undercut_decides_the_cylinder_is_as_large_as_it_has_to_be() -> None:
    found = sized("modified_sine", pressure_angle(76.0))
    undercut = next(each for each in found.extremes if each.quantity == "undercut")
    assert found.status == "feasible"
    assert undercut.value is not None
    assert 0.0 < undercut.value < 1e-5
    assert found.certificate.gap is not None
    assert found.certificate.gap > 0.05  # the bound knows the pressure angle only


@pytest.mark.parametrize("upper", [{}, {"max": 7e5}, {"max": 3e6}])
def test_cylinders_ten_thousand_times_the_stroke_are_not_excluded(upper: dict[str, float]) -> None:
    """The radius grows with 1/tan α: at 0.004° it is 469 m, and larger than most are drawn."""
    sample = SAMPLES["slide in a groove"]
    steps = [step | ({"law": {"kind": "cycloidal"}} if "law" in step else {})
             for step in sample.body["program"]]  # fmt: skip
    machine = sample.body["machine"] | {"cylinder_radius_mm": {"min": 1.0, **upper}}
    radii = {}
    for degrees in (4.0, 0.004):
        spec = sample.spec(program=steps, machine=machine, limits=[pressure_angle(degrees)])
        found = synthesise_spatial(spec)
        assert found.status != "infeasible"
        radii[degrees] = found.dimensions["cylinder_radius_mm"] * tan(radians(degrees))
    assert radii[0.004] == pytest.approx(radii[4.0], rel=0.05)


def test_what_no_cylinder_that_can_be_named_keeps_is_infeasible() -> None:
    refused = sized("cycloidal", pressure_angle(1e-6))
    assert refused.status == "infeasible"
    with pytest.raises(ValueError, match="at most 1000000"):
        SAMPLES["slide in a groove"].spec(
            machine=SAMPLES["slide in a groove"].body["machine"]
            | {"cylinder_radius_mm": {"min": 1.5e6}}
        )
