"""Electronic cams, read back by parsers that know the format only."""

from __future__ import annotations

import json
import re
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import BPoly, CubicSpline

from synthesis import DesignSpec, synthesise
from synthesis.design.design import Design
from synthesis.errors import InputError
from synthesis.exporters import MOTION_FORMATS

NUMBER = r"(-?\d+(?:\.\d+)?(?:e-?\d+)?)"
OPTIONS: dict[str, Any] = {
    "points": 250, "start_deg": 12.5, "master_per_turn": 65536.0, "slave_per_unit": 2e4,
    "decimals": 0,
}  # fmt: skip


def written(name: str, design: Design, **options: Any) -> str:
    exporter = MOTION_FORMATS[name]
    return exporter.write(design, exporter.options(**options)).decode("ascii")


def from_pairs(text: str) -> np.ndarray:
    return np.array([line.split(";") for line in text.splitlines()], float)


def from_sew(text: str) -> np.ndarray:
    count, _, rows = text.partition("\n")
    table = from_pairs(rows)
    assert int(count) == len(table)
    return table


def from_kollmorgen(text: str) -> np.ndarray:
    lines = text.splitlines()
    assert lines[:2] == ["CYCLIC;YES;", "TABLE_BEGIN;;"]
    assert lines[-1] == "TABLE_END;;"
    assert all(line.endswith(";SPLINE") for line in lines[2:-1])
    return from_pairs("\n".join(line.removesuffix(";SPLINE") for line in lines[2:-1]))


def from_rockwell(text: str) -> np.ndarray:
    lines = [line for line in text.splitlines() if not line.startswith("//")]
    pattern = rf"Cam\[(\d+)\].Master := {NUMBER}; Cam\[\1\].Slave := {NUMBER}; "
    found = [re.fullmatch(pattern + r"Cam\[\1\].SegmentType := 1;", line) for line in lines]
    rows = np.array([each.groups() for each in found], float)
    assert rows[:, 0].tolist() == list(range(len(lines)))
    assert f"Cam : CAM[{len(lines)}]" in text
    return rows[:, 1:]


def from_twincat(text: str) -> np.ndarray:
    declared = re.search(r"CamPoints : ARRAY\[1\.\.(\d+)\] OF MC_MotionFunctionPoint := \[", text)
    pattern = (
        r"\(PointIndex := (\d+), FunctionType := MOTIONFUNCTYPE_POLYNOM5_MM, PointType := "
        rf"MOTIONPOINTTYPE_MOTION, RelIndexNextPoint := 1, MasterPos := {NUMBER}, SlavePos := "
        rf"{NUMBER}, SlaveVelo := {NUMBER}, SlaveAcc := {NUMBER}, SlaveJerk := 0.0\)(?:,|\n    \];)"
    )
    rows = np.array(re.findall(pattern, text), float)
    assert rows[:, 0].tolist() == list(range(1, int(declared[1]) + 1))
    return rows[:, 1:]


def from_codesys(text: str) -> np.ndarray:
    pattern = rf"\(dX := {NUMBER}, dY := {NUMBER}, dV := {NUMBER}, dA := {NUMBER}\)"
    rows = np.array(re.findall(pattern, text), float)
    cam = re.search(rf"byType := 3, nElements := (\d+), xStart := {NUMBER}, xEnd := {NUMBER}", text)
    assert int(cam[1]) == len(rows)
    assert f"ARRAY[0..{len(rows) - 1}] OF SMC_CAMXYVA" in text
    assert [float(cam[2]), float(cam[3])] == rows[[0, -1], 0].tolist()
    return rows


READERS = {
    "cam.csv": from_pairs, "sew.txt": from_sew, "kollmorgen.csv": from_kollmorgen,
    "rockwell.st": from_rockwell, "twincat.st": from_twincat, "codesys.st": from_codesys,
}  # fmt: skip


@pytest.mark.parametrize("name", READERS)
def test_rows_are_the_motion_in_the_drive_s_units(name: str, cam: Design, truth) -> None:
    rows = READERS[name](written(name, cam, **OPTIONS))
    assert rows.shape[0] == 251
    assert rows[0, 0] == 0.0
    assert rows[-1, 0] == 65536.0
    np.testing.assert_array_equal(rows[0, 1:], rows[-1, 1:])
    degrees = (12.5 + rows[:-1, 0] * 360.0 / 65536.0) % 360.0
    right = truth(cam).motion(degrees, side=1)
    np.testing.assert_allclose(rows[:-1, 1], 2e4 * right[0], rtol=0.0, atol=0.5001)
    for order in range(1, rows.shape[1] - 1):
        expected = 2e4 * right[order] * (2.0 * np.pi / 65536.0) ** order
        atol = 1e-11 * np.abs(expected).max()
        np.testing.assert_allclose(rows[:-1, 1 + order], expected, rtol=1e-9, atol=atol)


def test_an_arm_s_table_is_in_degrees() -> None:
    body = {
        "program": [
            {"kind": "rise", "angle_deg": 170, "lift_deg": 14.5, "law": {"kind": "cycloidal"}},
            {"kind": "return", "angle_deg": 190, "lift_deg": 14.5, "law": {"kind": "cycloidal"}},
        ],
        "follower": {"kind": "oscillating_roller", "arm_mm": 70.0, "roller_radius_mm": 8.0,
                     "centre_distance_mm": 90.0},
        "limits": [{"kind": "pressure_angle", "rise_deg": 40.0, "return_deg": 45.0}],
    }  # fmt: skip
    design = synthesise(DesignSpec.model_validate(body))
    rows = from_pairs(written("cam.csv", design))
    assert rows[:, 1].max() == pytest.approx(14.5, abs=1e-3)
    assert "slave 1 units a deg." in written("twincat.st", design)


def test_rows_that_rounding_makes_the_same_are_refused(cam: Design) -> None:
    with pytest.raises(InputError, match="not all different") as caught:
        written("cam.csv", cam, points=1000, decimals=0)
    assert caught.value.field == "/decimals"


def test_fidelity_is_that_of_the_rows_as_they_are_read(cam: Design, truth) -> None:
    """The curves through what stands in the files, against the book's formulas, more densely."""
    options = {"points": 120, "decimals": 2, "start_deg": 33.0}
    reported = {each["reader"]: each for each in
            json.loads(written("fidelity.json", cam, **options))["readers"]}  # fmt: skip
    rows = from_twincat(written("twincat.st", cam, **options))
    x, y, v, a = rows.T
    y[-1] = y[0]
    curves = {
        "periodic cubic": CubicSpline(x, y, bc_type="periodic"),
        "natural cubic": CubicSpline(x, y, bc_type="natural"),
        "quintic": BPoly.from_derivatives(x, np.column_stack([y, v, a])),
    }
    at = np.linspace(0.0, 360.0, 24001)[1:-1:2]
    right = truth(cam).motion((33.0 + at) % 360.0)
    omega = cam.speed_rpm * np.pi / 30.0
    for name, curve in curves.items():
        for order, key in enumerate(("displacement_mm", "velocity_mm_per_s",
                                     "acceleration_mm_per_s2")):  # fmt: skip
            unit = (180.0 / np.pi) ** order
            worst = np.max(np.abs(curve(at, order) * unit - right[order])) * omega**order
            assert reported[name][key] == pytest.approx(worst, rel=0.02)
    linear = np.max(np.abs(np.interp(at, x, y) - right[0]))
    assert reported["linear"]["displacement_mm"] == pytest.approx(linear, rel=0.02)
    assert reported["linear"]["acceleration_part"] is None
