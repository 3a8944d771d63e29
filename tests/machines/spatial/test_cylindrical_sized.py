"""Cylinders made small where undercut decides."""

from __future__ import annotations

from typing import Any

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
