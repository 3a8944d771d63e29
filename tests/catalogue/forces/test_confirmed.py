"""Forces of every family once more, in ball arithmetic from the bare mechanism."""

from __future__ import annotations

import pytest

from synthesis import confirm, synthesise
from tests.catalogue.forces.loads import edged, loaded


@pytest.mark.parametrize(
    ("kind", "sample"),
    [
        ("translating_roller", 0), ("translating_roller", 2), ("translating_roller", 3),
        ("translating_flat_face", 1), ("oscillating_roller", 7), ("oscillating_flat_face", 1),
    ],
)  # fmt: skip
def test_limits_on_forces_are_confirmed(kind: str, sample: int) -> None:
    limits = [{"kind": "contact_force", "max_n": 2e4}, {"kind": "camshaft_torque", "max_n_m": 900}]
    if not edged(kind, sample):
        limits.append({"kind": "hertz_pressure", "max_mpa": 2e3})
    design = synthesise(loaded(kind, sample, limits=limits))
    found = confirm(design)
    forces = ("contact_force", "camshaft_torque", "hertz_pressure")
    lines = [line for line in found.lines if line.limit.startswith(forces)]
    assert len(lines) >= len(limits)
    for line in lines:
        assert line.agrees, line
        assert line.holds
        assert line.value is not None
