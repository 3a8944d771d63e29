"""The motion over several turns: cam angle and time run on, joints stand once, steps add up."""

import io
import json
from xml.etree import ElementTree as ET

import numpy as np
import pytest

import synthesis as c
from synthesis.design.design import Design
from synthesis.errors import InputError
from synthesis.exporters import MOTION_FORMATS, MotionOptions
from synthesis.exporters.options import DiagramOptions
from synthesis.machines.linkages.files.shaper import FILES
from synthesis.machines.linkages.shaper import SixBarShaper
from synthesis.machines.linkages.shaper.report import analyse_shaper
from synthesis.machines.linkages.shaper.spec import ShaperSpec
from synthesis.machines.spatial.files.motion import CSV as SPATIAL_CSV
from tests.machines.spatial.drums import designed

RPM = 90.0


def design(law: str) -> Design:
    program = [
        {"kind": kind, "angle_deg": 90.0, **move}
        for kind, move in (("rise", {"lift_mm": 20.0, "law": {"kind": law}}), ("dwell", {}),
                           ("return", {"lift_mm": 20.0, "law": {"kind": law}}), ("dwell", {}))
    ]  # fmt: skip
    return c.synthesise(
        c.DesignSpec.model_validate(
            {"speed_rpm": RPM, "program": program, "base_radius_mm": 60.0, "load": LOAD,
             "follower": {"kind": "translating_roller", "roller_radius_mm": 8.0}}
        )
    )  # fmt: skip


LOAD = {"kind": "slide", "moving_mass_kg": 1.0, "spring": {"rate_n_per_mm": 5.0, "preload_n": 90.0}}


def table(made: bytes) -> dict[str, np.ndarray]:
    read = np.genfromtxt(io.BytesIO(made), delimiter=",", names=True)
    return {name: read[name] for name in read.dtype.names}


def test_turns_follow_each_other_without_a_row_twice():
    # of this law the third derivative vanishes at its ends: no row is one of two
    smooth = design("polynomial_4_5_6_7")
    one, three = (
        table(MOTION_FORMATS["csv"].write(smooth, MotionOptions(points=72, turns=n)))
        for n in (1, 3)
    )
    angle = three["theta_deg"]
    assert angle == pytest.approx(np.arange(217) * 5.0, abs=1e-9)
    assert three["time_s"] == pytest.approx(angle / 360.0 * 60.0 / RPM, rel=1e-14)
    assert one["time_s"][-1] == pytest.approx(60.0 / RPM, rel=1e-14)
    assert list(three)[-1] == "time_s"
    for name in set(one) - {"theta_deg", "time_s"}:
        assert np.array_equal(three[name], np.concatenate([one[name], *(one[name][1:],) * 2]))
    assert "contact_force_n" in three
    plain = np.loadtxt(
        io.BytesIO(MOTION_FORMATS["txt"].write(smooth, MotionOptions(points=72, turns=3)))
    )
    assert np.array_equal(plain[:, [0, -1]], np.stack([angle, three["time_s"]], axis=1))


def test_where_the_jerk_jumps_a_joint_has_its_two_sides():
    made = json.loads(
        MOTION_FORMATS["json"].write(design("cycloidal"), MotionOptions(points=72, turns=2))
    )
    columns = {each["name"]: np.array(each["values"]) for each in made["columns"]}
    joint = columns["theta_deg"] == 360.0
    assert columns["side"][joint].tolist() == [-1, 1]
    assert made["sampling"]["turns"] == 2
    assert made["rows"] == len(joint)


def test_an_indexer_goes_on_by_its_step():
    found = table(SPATIAL_CSV.write(designed("turret"), MotionOptions(points=36, turns=4)))
    at = [float(found["s_deg"][found["theta_deg"] == 360.0 * k][0]) for k in range(1, 5)]
    assert at == pytest.approx([45.0, 90.0, 135.0, 180.0], abs=1e-9)
    assert np.all(np.diff(found["s_deg"]) >= -1e-9)


def test_the_picture_runs_over_all_turns():
    drawn = MOTION_FORMATS["svg"].write(design("cycloidal"), DiagramOptions(turns=3))
    texts = [each.text for each in ET.fromstring(drawn).iter("{http://www.w3.org/2000/svg}text")]
    assert "1080" in texts
    assert "1080°" in texts
    assert "990" in texts  # every 90°


def test_too_many_rows_are_refused_with_the_turns_that_fit():
    with pytest.raises(InputError, match="at most 36000 rows, which here are 10 turns"):
        MotionOptions(points=3600, turns=11)
    with pytest.raises(InputError, match="at most 100"):
        MotionOptions(turns=101)


SHAPER = {
    "crank_mm": 125.0, "guide_mm": 600.0, "coupler_mm": 150.0, "pivot_distance_mm": 275.0,
    "ram_line_mm": 575.0, "ram_side": "left", "speed_rpm": 10.0,
}  # fmt: skip


def shaper(**more: float) -> SixBarShaper:
    spec = ShaperSpec(**SHAPER, **more)
    return analyse_shaper(spec, {n: v for n, v in SHAPER.items() if n in spec.length_ranges()})


def test_a_shaper_runs_on_at_constant_speed_only():
    csv = next(each for each in FILES if each.name == "motion.csv")
    found = table(csv.write(shaper(), MotionOptions(points=36, turns=2)))
    assert found["crank_travel_deg"] == pytest.approx(np.arange(73) * 10.0)
    assert found["ram_mm"][36:] == pytest.approx(found["ram_mm"][:37])
    assert found["time_s"][-1] == pytest.approx(12.0)
    with pytest.raises(InputError, match="nothing is said of the next"):
        csv.write(shaper(acceleration_rad_per_s2=0.1), MotionOptions(turns=2))
