"""CSV and JSON, read back by other readers and held against formulas typed again."""

from __future__ import annotations

import csv
import io
import json
import math
from typing import Any

import numpy as np
import pytest

from synthesis.design.design import Design, SplineCurve
from synthesis.exporters import MOTION_FORMATS, PROFILE_FORMATS, MotionOptions, ProfileOptions
from synthesis.exporters.samples.columns import Column
from synthesis.exporters.tables import JsonOptions
from synthesis.exporters.tables import _json_column as _column

PER_DEGREE = 2.7  # 972 steps of 0.37037…°
PROFILE_HEADER = (
    "theta_deg,s_mm,v_mm_per_s,a_mm_per_s2,j_mm_per_s3,x_mm,y_mm,pressure_angle_deg,"
    "pitch_curvature_per_mm,profile_radius_mm,side"
)
MOTION_HEADER = (
    "theta_deg,s_mm,v_mm_per_s,a_mm_per_s2,j_mm_per_s3,ds_mm_per_rad,d2s_mm_per_rad2,"
    "d3s_mm_per_rad3,side,time_s"
)

Table = dict[str, np.ndarray]


def from_csv(data: bytes) -> Table:
    rows = list(csv.reader(io.StringIO(data.decode("utf-8"), newline="")))
    return {name: np.array([float(row[k]) for row in rows[1:]]) for k, name in enumerate(rows[0])}


def from_json(data: bytes) -> Table:
    def no_constant(word: str) -> float:
        raise AssertionError(f"{word} is not JSON")

    body = json.loads(data, parse_constant=no_constant)
    return {
        column["name"]: np.array(
            [math.inf if value is None else value for value in column["values"]], dtype=float
        )
        for column in body["columns"]
    }


READERS = {"csv": from_csv, "json": from_json}


def profile(name: str, design: Design, **options: Any) -> Table:
    options.setdefault("points_per_degree", PER_DEGREE)
    exporter = PROFILE_FORMATS[name]
    return READERS[name](exporter.write(design, exporter.options(**options)))


def motion(name: str, design: Design, points_per_degree: float = PER_DEGREE) -> Table:
    return READERS[name](MOTION_FORMATS[name].write(design, MotionOptions(points_per_degree)))


def agree(found: np.ndarray, right: np.ndarray) -> None:
    """To 1e-12, near zeros of the column's peak."""
    np.testing.assert_allclose(found, right, rtol=1e-12, atol=1e-12 * np.max(np.abs(right)))


@pytest.mark.parametrize("name", READERS)
@pytest.mark.parametrize("curve", ["profile", "pitch"])
def test_profile(name: str, curve: str, cam: Design, truth) -> None:
    table = profile(name, cam, curve=curve)
    right = truth(cam).curves(table["theta_deg"], table["side"])
    s = truth(cam).motion(table["theta_deg"], table["side"])
    omega = cam.speed_rpm * math.pi / 30.0
    for k, column in enumerate(["s_mm", "v_mm_per_s", "a_mm_per_s2", "j_mm_per_s3"]):
        agree(table[column], s[k] * omega**k)
    agree(table["x_mm"], right[f"{curve}_x"])
    agree(table["y_mm"], right[f"{curve}_y"])
    agree(table["pressure_angle_deg"], right["pressure_angle"])
    agree(table["pitch_curvature_per_mm"], right["curvature"])
    # where the flank is nearly straight the radius is without bound: compare its inverse
    roller = cam.dimensions["roller_radius_mm"]
    agree(1.0 / (table["profile_radius_mm"] + roller), right["curvature"])


@pytest.mark.parametrize("name", READERS)
def test_motion(name: str, cam: Design, truth) -> None:
    table = motion(name, cam)
    s = truth(cam).motion(table["theta_deg"], table["side"])
    omega = cam.speed_rpm * math.pi / 30.0
    physical = ["s_mm", "v_mm_per_s", "a_mm_per_s2", "j_mm_per_s3"]
    per_radian = ["s_mm", "ds_mm_per_rad", "d2s_mm_per_rad2", "d3s_mm_per_rad3"]
    for k in range(4):
        agree(table[physical[k]], s[k] * omega**k)
        agree(table[per_radian[k]], s[k])


def test_both_formats_say_the_same(cam: Design) -> None:
    for read in (profile, motion):
        one, other = read("csv", cam), read("json", cam)
        assert list(one) == list(other)
        for name in one:
            np.testing.assert_array_equal(one[name], other[name])


def test_the_plain_table_is_the_csv_without_its_header(cam: Design) -> None:
    options = MotionOptions(PER_DEGREE)
    plain = np.loadtxt(io.BytesIO(MOTION_FORMATS["txt"].write(cam, options)), ndmin=2)
    table = from_csv(MOTION_FORMATS["csv"].write(cam, options))
    assert np.array_equal(plain, np.column_stack(list(table.values())))


def test_printed_points_of_example_13_6(p1: Design) -> None:
    """The rows of the book's table that stand at true angles: 360° (see reference-problems)."""
    table = profile("csv", p1, points_per_degree=1.0)
    last = {name: values[-1] for name, values in table.items()}
    assert last["theta_deg"] == 360.0
    assert (round(last["x_mm"], 2), round(last["y_mm"], 2)) == (16.67, 47.14)
    pitch = profile("csv", p1, points_per_degree=1.0, curve="pitch")
    assert (round(pitch["x_mm"][-1], 2), round(pitch["y_mm"][-1], 2)) == (20.0, 56.57)


def test_a_clockwise_cam_is_the_mirror_image(build) -> None:
    one = profile("csv", build(rotation="ccw", offset=13.7))
    other = profile("csv", build(rotation="cw", offset=13.7))
    np.testing.assert_array_equal(other["x_mm"], -one["x_mm"])
    for name in one:
        if name != "x_mm":
            np.testing.assert_array_equal(other[name], one[name])


def test_form_of_the_csv(cam: Design) -> None:
    for data, header in [
        (PROFILE_FORMATS["csv"].write(cam, ProfileOptions()), PROFILE_HEADER),
        (MOTION_FORMATS["csv"].write(cam, MotionOptions()), MOTION_HEADER),
    ]:
        text = data.decode("ascii")
        assert "\r" not in text
        assert " " not in text
        assert text.endswith("\n")
        assert text.splitlines()[0] == header
        for line in text.splitlines()[1:]:
            for name, cell in zip(header.split(","), line.split(","), strict=True):
                # the shortest that reads back; a side is a whole number
                assert cell == repr(int(cell) if name == "side" else float(cell))


def test_numpy_reads_it(p1: Design) -> None:
    data = PROFILE_FORMATS["csv"].write(p1, ProfileOptions())
    table = np.loadtxt(io.BytesIO(data), delimiter=",", skiprows=1)
    assert table.shape == (1440 + 1 + 3, 11)  # 360° too, and the three inner jumps twice


@pytest.mark.parametrize("per_degree", [1.0, 4.0, 2.7, 1 / 3, 1e-6, 20.0])
def test_uniform_angles(per_degree: float, cam: Design) -> None:
    angles = motion("csv", cam, per_degree)["theta_deg"]
    steps = max(math.ceil(360.0 * per_degree - 1e-9), 36)
    for k in range(steps + 1):
        assert np.min(np.abs(angles - 360.0 * k / steps)) < 1e-10
    assert angles[0] == 0.0
    assert angles[-1] == 360.0
    assert np.all(np.diff(angles) >= 0.0)
    assert np.diff(angles).max() <= 360.0 / steps + 1e-9


def test_borders_are_hit_exactly(unspecial: Design) -> None:
    table = motion("csv", unspecial, 1.0)
    for border in (17.3, 89.2, 137.55, 161.0, 262.7):
        assert border in table["theta_deg"]


def test_two_rows_only_where_a_derivative_jumps(unspecial: Design) -> None:
    table = motion("csv", unspecial, 1.0)
    jumps = table["d3s_mm_per_rad3"]
    doubled = np.flatnonzero(np.diff(table["theta_deg"]) == 0.0)
    np.testing.assert_array_equal(np.flatnonzero(table["side"] == -1), doubled)
    np.testing.assert_array_equal(np.flatnonzero(table["side"] == 1), doubled + 1)
    assert np.all(np.abs(jumps[doubled] - jumps[doubled + 1]) > 1e-3)
    # every knot of the two splines (6 inner ones each), and 5 borders of segments; the seam of
    # two dwells at cam angle 0 is no jump
    assert len(doubled) == 2 * 6 + 5
    assert (table["side"][0], table["side"][-1]) == (0, 0)


def test_a_jump_at_cam_angle_0_is_shown_by_the_two_ends(p1: Design) -> None:
    table = motion("json", p1)
    assert (table["side"][0], table["side"][-1]) == (1, -1)
    assert table["d3s_mm_per_rad3"][0] > 1000.0
    assert table["d3s_mm_per_rad3"][-1] == 0.0


def test_a_smooth_joint_has_one_row(build) -> None:
    """Quartic splines that end at rest with no jerk: no derivative up to the third jumps."""
    rest = SplineCurve(
        degree=4,
        knots=[0.0, 0.2, 0.5, 0.8, 1.0],
        coefficients=[0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0],
    )
    program = [
        {"kind": "rise", "angle_deg": 100, "lift_mm": 11, "law": {"kind": "spline"}},
        {"kind": "dwell", "angle_deg": 50},
        {"kind": "return", "angle_deg": 90, "lift_mm": 11, "law": {"kind": "spline"}},
        {"kind": "dwell", "angle_deg": 120},
    ]
    table = motion("csv", build(program, limits=[], spline=rest))
    assert not table["side"].any()
    assert np.all(np.diff(table["theta_deg"]) > 0.0)


def test_rounding_is_no_jump(build) -> None:
    """A straight line written as a cubic spline: s'' vanishes but for rounding at the knots."""
    knots = [0.0, 0.1, 0.3, 0.4, 0.7, 0.9, 1.0]
    full = [0.0] * 3 + knots + [1.0] * 3
    line = [sum(full[k + 1 : k + 4]) / 3.0 for k in range(len(knots) + 2)]
    program = [
        {"kind": "rise", "angle_deg": 100, "lift_mm": 11, "law": {"kind": "spline"}},
        {"kind": "return", "angle_deg": 260, "lift_mm": 11, "law": {"kind": "spline"}},
    ]
    spline = SplineCurve(degree=3, knots=knots, coefficients=line)
    table = motion("csv", build(program, roller=0.0, limits=[], spline=spline))
    assert np.any(table["d2s_mm_per_rad2"] != 0.0)
    assert list(table["theta_deg"][table["side"] != 0]) == [0.0, 100.0, 100.0, 360.0]


def test_what_the_json_tells(unspecial: Design) -> None:
    body = json.loads(PROFILE_FORMATS["json"].write(unspecial, JsonOptions(curve="pitch")))
    assert body["design"] == {
        "id": unspecial.id,
        "name": "unspecial",
        "engine_version": "0.1.0",
        "status": "feasible",
        "certified": True,
    }
    assert body["rotation"] == "cw"
    assert "the cam turns clockwise; the rows run round it counter-clockwise" in body["frame"]
    assert body["curve"] == "pitch"
    assert body["dimensions"] == unspecial.dimensions
    assert body["sampling"]["points_per_degree"] == 4.0
    assert {column["type"] for column in body["columns"]} == {"number", "integer"}
    for column in body["columns"]:
        assert len(column["values"]) == body["rows"]
        assert column["unit"]
        assert column["meaning"]
    reported = json.loads(MOTION_FORMATS["json"].write(unspecial, MotionOptions()))
    assert [segment["kind"] for segment in reported["segments"]][:3] == ["dwell", "rise", "dwell"]
    assert reported["segments"][1]["spline"]["degree"] == 3


@pytest.mark.parametrize("name", ["<&\"'> \\ \n\t ü 凸轮", "", "x" * 200])
def test_names_survive(name: str, build) -> None:
    body = json.loads(PROFILE_FORMATS["json"].write(build(name=name), JsonOptions(1.0)))
    assert body["design"]["name"] == name


def test_a_straight_flank_has_an_infinite_radius() -> None:
    column = Column("profile_radius_mm", "mm", "", np.array([1.5, math.inf]))
    assert json.loads(_column(column))["values"] == [1.5, None]


def test_the_fidelity_in_a_table_is_that_of_its_curve(unspecial: Design) -> None:
    """Unrounded, so that it agrees with a point file of many decimals."""
    options = {"points": 300, "curve": "pitch"}
    table = json.loads(PROFILE_FORMATS["json"].write(unspecial, JsonOptions(**options)))
    inside = table["fidelity"]
    exporter = PROFILE_FORMATS["fidelity.json"]
    question = exporter.options(decimals=13, **options)
    beside = json.loads(exporter.write(unspecial, question))
    assert inside["points"] == beside["points"]
    for one, other in zip(inside["readers"], beside["readers"], strict=True):
        assert one["form_um"] == pytest.approx(other["form_um"], rel=1e-3)
    bare = json.loads(PROFILE_FORMATS["json"].write(unspecial, JsonOptions(fidelity=False)))
    assert "fidelity" not in bare
