"""What splines through written points do: against a roller that is run over them by touch."""

from __future__ import annotations

import importlib
import io
import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from synthesis import Design, DesignSpec, synthesise
from synthesis.exporters import PROFILE_FORMATS, PointOptions, ProfileOptions
from synthesis.exporters.fidelity.measure import CurveSamples, fidelities, follower_motion
from synthesis.exporters.samples.cam import Cam
from tests.exporters.test_flanks import CLOSURES, question
from tests.exporters.test_points import away, points

CUBIC = ("periodic", "not-a-knot", "natural")


def reported(design: Design, **options: Any) -> dict[str, dict[str, Any]]:
    data = PROFILE_FORMATS["fidelity.json"].write(design, PointOptions(**options))
    return {each["reader"]: each for each in json.loads(data)["readers"]}


def drawn(design: Design, reader: str, **options: Any) -> tuple[CubicSpline, float]:
    """The curve of a reader of the text file, and its length."""
    ring = points(design, closed=True, **options)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(ring, axis=0).T))])
    return CubicSpline(along, ring, bc_type=reader), float(along[-1])


class ByTouch:
    """The roller of a translating follower rests on a curve: nothing of it is inside."""

    def __init__(self, design: Design, curve: CubicSpline, length: float) -> None:
        self.curve, self.sign = curve, -1.0 if design.rotation == "cw" else 1.0
        self.along = np.linspace(0.0, length, 40001)
        self.points = curve(self.along)
        self.e, self.radius = design.dimensions["offset_mm"], design.dimensions["roller_radius_mm"]

    def height(self, theta: float) -> float:
        """Of the roller's centre over the axis."""

        def over(points: np.ndarray) -> np.ndarray:
            x, y = self.sign * points[..., 0], points[..., 1]
            x, y = (
                x * math.cos(theta) - y * math.sin(theta),
                x * math.sin(theta) + y * math.cos(theta),
            )
            room = self.radius**2 - (x - self.e) ** 2
            return np.where(room > 0.0, y + np.sqrt(np.maximum(room, 0.0)), -np.inf)

        best = min(max(int(np.argmax(over(self.points))), 1), len(self.along) - 2)
        bracket = self.along[best - 1], self.along[best + 1]
        found = minimize_scalar(
            lambda t: -float(over(self.curve(t))), bounds=bracket, method="bounded",
            options={"xatol": 1e-11},
        )  # fmt: skip
        return -float(found.fun)

    def acceleration(self, theta: float, step: float = 4e-4) -> float:
        before, at, after = (self.height(theta + k * step) for k in (-1.0, 0.0, 1.0))
        return (before - 2.0 * at + after) / step**2


@pytest.mark.parametrize("reader", ["periodic", "not-a-knot"])  # natural is worst in its corner
def test_the_acceleration_error_is_that_of_a_roller_run_by_touch(
    reader: str, unspecial: Design, truth
) -> None:
    """Where it is said to be worst, the second difference of positions shows it."""
    options = {"points": 120, "decimals": 2, "start_deg": 61.7}
    found = reported(unspecial, **options)[reader]
    touch = ByTouch(unspecial, *drawn(unspecial, reader, **options))
    omega = unspecial.speed_rpm * math.pi / 30.0
    beside = found["acceleration_at_deg"] + np.array([-0.03, 0.03])  # it may jump there
    true = truth(unspecial).motion(beside)[2]
    shown = [touch.acceleration(math.radians(degrees)) for degrees in beside]
    error = np.max(np.abs(shown - true)) * omega**2
    assert error == pytest.approx(found["acceleration_mm_per_s2"], rel=0.05)
    peak = np.max(np.abs(truth(unspecial).motion(np.linspace(0.01, 360, 7200))[2])) * omega**2
    assert found["acceleration_part"] == pytest.approx(
        found["acceleration_mm_per_s2"] / peak, rel=2e-3
    )
    curve, length = drawn(unspecial, reader, **options)
    ends = np.array([[0.0], [length]])
    (ax, ay), (bx, by) = curve(ends, 1)[:, 0]
    corner = math.degrees(abs(math.atan2(ax * by - ay * bx, ax * bx + ay * by)))
    assert found["seam_corner_deg"] == pytest.approx(corner, rel=1e-3, abs=1e-9)
    for degrees in (33.1, 140.3, 262.9):  # nowhere else it is more
        near = math.radians(degrees)
        other = touch.acceleration(near) - truth(unspecial).motion(np.array([degrees]))[2, 0]
        assert abs(other) * omega**2 <= 1.05 * found["acceleration_mm_per_s2"]


@pytest.mark.parametrize("reader", [*CUBIC, "polyline"])
@pytest.mark.parametrize("curve", ["profile", "pitch"])
def test_the_form_error_is_the_distance_from_the_true_curve(
    reader: str, curve: str, unspecial: Design, truth
) -> None:
    options = {"points": 90, "curve": curve, "decimals": 3}
    found = reported(unspecial, **options)[reader]["form_um"]
    true = truth(unspecial).points(np.linspace(0.0, 360.0, 7201)[:-1], curve)
    if reader == "polyline":
        ring = points(unspecial, **options)
        far = away(true, ring).max()
    else:
        spline, length = drawn(unspecial, reader, **options)
        far = away(spline(np.linspace(0.0, length, 3001)), true).max()
    assert found == pytest.approx(1e3 * far, rel=0.03)


@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize(
    ("closure", "curve"),
    [("ring", "profile"), ("groove", "inner"), ("groove", "outer"), ("pair", "counter"),
     ("pair", "counter_pitch"), ("pair", "cutter"), ("flat", "profile"), ("swinging", "profile")],
)  # fmt: skip
def test_on_the_true_curve_the_follower_moves_as_designed(
    designs, closure: str, curve: str, rotation: str
) -> None:
    """Guessed 0.3° off, it finds its angle, displacement, velocity and acceleration."""
    design = designs[closure, rotation]
    options = {"curve": curve, "cutter_diameter_mm": 17.0 if curve == "cutter" else None}
    cam = Cam.of(design, ProfileOptions(**options))
    theta = np.linspace(0.01, 6.2, 333)
    at = cam.at(theta)
    (x, y), mirror = cam.place(at), -1.0 if rotation == "cw" else 1.0
    bend = at.curvature / (1.0 - at.curvature * cam.gap)
    known = CurveSamples(mirror * x, y, at.normal_y, -mirror * at.normal_x, bend)
    found = follower_motion(cam, known, theta + 0.005 * np.cos(5.0 * theta))
    np.testing.assert_allclose(found.theta, theta, rtol=0.0, atol=1e-12)
    for order, values in enumerate((found.s, found.v, found.a)):
        right = at.s[order]
        np.testing.assert_allclose(values, right, rtol=0.0, atol=1e-11 * np.abs(right).max())


@pytest.fixture(scope="module")
def designs() -> dict[tuple[str, str], Design]:
    found = {}
    for rotation in ("ccw", "cw"):
        for name, closure in CLOSURES.items():
            found[name, rotation] = synthesise(question(closure, rotation))
        body = question(CLOSURES["ring"], rotation).model_dump(mode="json", exclude_none=True)
        body["limits"] = []
        flat = {"kind": "translating_flat_face", "tilt_deg": 7.0}
        found["flat", rotation] = synthesise(DesignSpec.model_validate({**body, "follower": flat}))
        swinging = {"kind": "oscillating_flat_face", "centre_distance_mm": 120.0}
        for segment in body["program"]:
            if "lift_mm" in segment:
                segment["lift_deg"] = 0.5 * segment.pop("lift_mm")
        found["swinging", rotation] = synthesise(
            DesignSpec.model_validate({**body, "follower": swinging})
        )
    return found


def test_neither_place_nor_sense_of_the_points_matters(unspecial: Design) -> None:
    plain = reported(unspecial, points=200)
    turned = reported(unspecial, points=200, turn_deg=41.3, direction="ccw", z_mm=4.0)
    other = reported(unspecial, points=200, turn_deg=41.3, direction="cw")
    assert turned == other
    for reader, values in plain.items():
        for name in ("form_um", "velocity_mm_per_s", "acceleration_part"):
            found, right = turned[reader][name], values[name]
            assert found == (right and pytest.approx(right, rel=1e-2, abs=1e-6))


def test_points_past_the_end_take_a_natural_spline_s_ends_away(unspecial: Design) -> None:
    """In motion the natural ends are wrong by far; twenty points away nothing is left of it."""
    bare = reported(unspecial, points=720, start_deg=50.0)
    over = reported(unspecial, points=720, start_deg=50.0, overlap_points=40)
    at_seam = reported(unspecial, points=720)
    part = "acceleration_part"
    assert bare["natural"][part] > 0.2
    assert at_seam["natural"][part] > 0.1  # the base circle is not straight either
    assert over["natural"][part] == pytest.approx(over["periodic"][part], rel=1e-3)
    assert over["natural"][part] < 0.05 * bare["natural"][part]
    assert bare["natural"]["acceleration_at_deg"] == pytest.approx(50.0, abs=0.5)


def test_decimals_cost_more_the_denser_the_points(unspecial: Design) -> None:
    """Rounding by half a micron counts by the squared distance: much more for ten times more."""
    one, ten = (
        reported(unspecial, points_per_degree=density, decimals=3, curve="pitch")["periodic"]
        for density in (1.0, 10.0)
    )
    ratio = ten["acceleration_part"] / one["acceleration_part"]
    assert 30.0 < ratio < 200.0
    # and on the profile the roller no longer reaches the ground of the waves
    waves = reported(unspecial, points_per_degree=10.0, decimals=3)["periodic"]
    assert waves["acceleration_part"] is None


def test_a_corner_of_the_motion_has_no_finite_acceleration(build) -> None:
    program = [
        {"kind": "rise", "angle_deg": 120, "lift_mm": 9.9, "law": {"kind": "constant_velocity"}},
        {"kind": "return", "angle_deg": 140, "lift_mm": 9.9, "law": {"kind": "constant_velocity"}},
        {"kind": "dwell", "angle_deg": 100},
    ]
    for found in reported(build(program, limits=[])).values():
        assert found["acceleration_part"] is None


def test_a_polygon_without_hollows_rolls_round_its_corners(build, truth) -> None:
    """On an edge s'' is that of a straight line, on a corner that of a circle of the roller's
    radius: far off, but finite, and the smaller the roller the more."""
    program = [
        {"kind": "rise", "angle_deg": 180, "lift_mm": 2.0, "law": {"kind": "cycloidal"}},
        {"kind": "return", "angle_deg": 180, "lift_mm": 2.0, "law": {"kind": "cycloidal"}},
    ]
    design = build(program, limits=[], prime=60.0, offset=0.0)
    found = reported(design, points=180)["polyline"]
    # a circle of radius R seen on a corner: s'' = X − X²/Rr with X the centre's height, less s''
    height = 60.0 + 1.0
    guess = (height**2 / 10.0 - height) * (10.0 * math.pi / math.pi) ** 2
    assert found["acceleration_mm_per_s2"] == pytest.approx(guess, rel=0.1)


def test_the_block_names_what_it_measured(unspecial: Design) -> None:
    data = PROFILE_FORMATS["fidelity.json"].write(unspecial, PointOptions(points=101, decimals=4))
    body = json.loads(data)
    ring = np.loadtxt(
        io.BytesIO(PROFILE_FORMATS["txt"].write(unspecial, PointOptions(points=101, decimals=4)))
    )
    assert body["points"] == len(ring)
    assert body["decimals"] == 4
    assert body["sampling"]["points"] == 101
    assert [each["reader"] for each in body["readers"]] == ["polyline", *CUBIC]


def test_the_form_error_of_few_points(p1: Design, truth) -> None:
    options = {"points": 36}
    true = truth(p1).points(np.linspace(0.0, 360.0, 7201)[:-1])
    spline, length = drawn(p1, "periodic", **options)
    far = 1e3 * away(spline(np.linspace(0.0, length, 2001)), true).max()
    assert reported(p1, **options)["periodic"]["form_um"] == pytest.approx(far, rel=0.01)


def test_the_page_on_files_tells_what_is_measured() -> None:
    body = json.loads(Path("openapi/examples/fixed-laws.json").read_text())["value"]
    design = synthesise(DesignSpec.model_validate(body))
    row = r"^\| (\d+) per degree \| (\d+) \| (.*?) \| (.*?) \| (.*?) \| (.*?) µm \|$"
    rows = re.findall(row, Path("docs/files.md").read_text(), re.MULTILINE)
    assert len(rows) == 7
    for density, decimals, form, acceleration, natural, straight in rows:
        found = reported(design, points_per_degree=float(density), decimals=int(decimals))
        limit = form.startswith("<")
        number = float(form.strip("< ").removesuffix(" µm"))
        off = found["periodic"]["form_um"]
        assert off < number if limit else off == pytest.approx(number, rel=0.06)
        for reader, text in (("periodic", acceleration), ("natural", natural)):
            part = found[reader]["acceleration_part"]
            told_part = None if text == "infinite" else float(text.removesuffix(" %")) / 100.0
            assert part == (told_part and pytest.approx(told_part, rel=0.1))
        assert found["polyline"]["form_um"] == pytest.approx(float(straight), rel=0.05)


def test_a_cutter_round_a_cam_of_an_oscillating_face() -> None:
    """The face touches the profile; the cutter's path is as far from it as the cutter is large."""
    file = Path(__file__).parents[2] / "openapi" / "examples" / "oscillating-flat-face.json"
    design = synthesise(DesignSpec.model_validate(json.loads(file.read_text())["value"]))
    for diameter in (6.0, 400.0):
        path = reported(design, points=720, curve="cutter", cutter_diameter_mm=diameter)["periodic"]
        assert path["acceleration_part"] < 2e-3


def test_the_worst_is_found_where_joints_lie_between_points(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A law of its own has knots anywhere; all intervals measured closely have the same errors."""
    body = json.loads(Path("openapi/examples/windows-and-points.json").read_text())["value"]
    design = synthesise(DesignSpec.model_validate(body))
    cases: tuple[dict[str, Any], ...] = ({}, {"points": 90, "decimals": 4, "overlap_points": 8})
    found = [reported(design, **options) for options in cases]
    module = importlib.import_module(fidelities.__module__)
    monkeypatch.setattr(module, "COARSE", module.FINE)
    assert found == [reported(design, **options) for options in cases]
