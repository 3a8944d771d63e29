"""Exact curves: against the textbook's formulas, and read back by readers that are not ours."""

from __future__ import annotations

import io
import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import BSpline

from synthesis.catalogue.followers import TranslatingRoller
from synthesis.catalogue.motion import Motion, PlacedSegment
from synthesis.design.design import Design
from synthesis.errors import InputError
from synthesis.exporters import PROFILE_FORMATS
from synthesis.exporters.curves.dxf import DrawingOptions
from synthesis.exporters.curves.exact import Contour, ExactOptions
from synthesis.exporters.curves.step import SCHEMA
from synthesis.exporters.samples.cam import Cam
from synthesis.numerics.geometry.closed_spline import fit_closed_spline
from synthesis.numerics.piecewise import Piecewise
from synthesis.studies.analyse import given_cam
from tests.catalogue.followers.samples import CASES, spec
from tests.exporters.kernel import curves, points
from tests.exporters.nearest import away

SOME = np.sort(np.random.default_rng(11).uniform(0.0, 360.0, 701))


def body(design: Design, **options: Any) -> dict[str, Any]:
    return json.loads(PROFILE_FORMATS["nurbs.json"].write(design, ExactOptions(**options)))


def spline_of(reported: dict[str, Any]) -> BSpline:
    return BSpline(
        np.array(reported["knots_mm"]), np.array(reported["control_points_mm"]), reported["degree"]
    )


def plane(spline: BSpline) -> BSpline:
    return BSpline(spline.t, spline.c[:, :2], spline.k)


@pytest.mark.parametrize("tolerance_um", [1.0, 1e-3, 1e-6])
@pytest.mark.parametrize("curve", ["profile", "pitch"])
def test_it_is_as_near_to_the_true_curve_as_it_says(cam, truth, curve, tolerance_um) -> None:
    reported = body(cam, curve=curve, tolerance_um=tolerance_um)
    found = away(truth(cam).points(SOME, curve), plane(spline_of(reported)))
    assert reported["error_mm"] <= reported["tolerance_mm"] == pytest.approx(1e-3 * tolerance_um)
    assert np.max(found) <= reported["error_mm"]
    assert np.max(found) > 0.2 * reported["error_mm"]
    assert len(reported["control_points_mm"]) < {1.0: 90, 1e-3: 150, 1e-6: 300}[tolerance_um]


def test_a_cutter_runs_beside_the_profile(cam, truth) -> None:
    reported = body(cam, curve="cutter", cutter_diameter_mm=13.7)
    pitch, profile = (truth(cam).points(SOME, curve) for curve in ("pitch", "profile"))
    normal = (pitch - profile) / np.linalg.norm(pitch - profile, axis=1)[:, None]
    found = away(profile + 0.5 * 13.7 * normal, plane(spline_of(reported)))
    assert np.max(found) <= reported["error_mm"]


def test_curvature_and_sense_are_the_cam_s(cam, truth) -> None:
    reported = body(cam, curve="pitch", tolerance_um=1e-6)
    spline = plane(spline_of(reported))
    u = spline.t[0] + np.linspace(0.0, 1.0, 20_001) * reported["length_mm"]
    (x1, y1), (x2, y2) = spline(u, 1).T, spline(u, 2).T
    np.testing.assert_allclose(np.hypot(x1, y1), 1.0, atol=1e-5)  # arc length
    mirror = -1.0 if cam.rotation == "cw" else 1.0
    place = truth(cam).points(SOME, "pitch")
    near = np.argmin(np.linalg.norm(spline(u)[None] - place[::25, None], axis=2), axis=1)
    bend = -mirror * truth(cam).curves(SOME[::25])["curvature"]
    np.testing.assert_allclose((x1 * y2 - y1 * x2)[near], bend, atol=2e-4)


def test_length_and_area_are_those_of_the_curve(cam, truth) -> None:
    reported = body(cam)
    x, y = truth(cam).points(np.linspace(0.0, 360.0, 180_001)[:-1]).T
    area = 0.5 * abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
    assert reported["enclosed_area_mm2"] == pytest.approx(area, rel=1e-8)
    length = np.sum(np.hypot(x - np.roll(x, 1), y - np.roll(y, 1)))
    assert reported["length_mm"] == pytest.approx(length, rel=1e-8)


def test_the_seam_is_in_the_middle_of_the_longest_dwell(p1: Design, truth) -> None:
    first = np.array(body(p1)["control_points_mm"][0])[:2]
    np.testing.assert_allclose(first, truth(p1).points(np.array([255.0]))[0], atol=1e-12)


def test_it_is_turned_and_shifted_as_asked(unspecial: Design) -> None:
    plain, placed = body(unspecial), body(unspecial, turn_deg=-63.7, z_mm=12.125)
    a, b = (np.array(each["control_points_mm"]) for each in (plain, placed))
    turn = np.exp(1j * np.radians(-63.7))
    np.testing.assert_allclose(b[:, 0] + 1j * b[:, 1], turn * (a[:, 0] + 1j * a[:, 1]), atol=1e-12)
    assert np.all(a[:, 2] == 0.0)
    assert np.all(b[:, 2] == 12.125)


@pytest.mark.parametrize(("name", "ending"), [("step", ".step"), ("igs", ".igs")])
def test_opencascade_reads_the_same_curve(cam, name: str, ending: str, tmp_path: Path) -> None:
    options = ExactOptions(z_mm=-3.75, turn_deg=17.9)
    (curve,) = curves(PROFILE_FORMATS[name].write(cam, options), ending, tmp_path)
    known = spline_of(body(cam, z_mm=-3.75, turn_deg=17.9))
    assert curve.IsClosed()
    assert curve.Degree() == 5
    assert curve.NbPoles() == len(known.c) - curve.IsPeriodic()  # then the last one is not counted
    assert not curve.IsRational()
    u = np.linspace(known.t[0], known.t[-1], 997)
    np.testing.assert_allclose(points(curve, u), known(u), rtol=0, atol=1e-11)


def test_step_says_what_it_is(unspecial: Design) -> None:
    named = unspecial.model_copy(update={"name": "Nocke »Ö'1«"})
    text = PROFILE_FORMATS["step"].write(named, ExactOptions()).decode("ascii")
    head = text.partition("DATA;")[0]
    assert SCHEMA in head
    assert unspecial.id in head
    assert "Camwright 0.1.0" in head
    assert r"'Nocke \X2\00BB\X0\\X2\00D6\X0\''1\X2\00AB\X0\'" in head
    assert all(number in text for number in ("SI_UNIT(.MILLI.,.METRE.)", "GEOMETRIC_CURVE_SET"))


def test_iges_records_are_eighty_columns_and_counted(unspecial: Design) -> None:
    lines = PROFILE_FORMATS["igs"].write(unspecial, ExactOptions()).decode("ascii").splitlines()
    assert {len(line) for line in lines} == {80}
    sections = {letter: [line for line in lines if line[72] == letter] for letter in "SGDPT"}
    for section in sections.values():
        assert [int(line[73:]) for line in section] == list(range(1, len(section) + 1))
    counts = dict(re.findall(r"([SGDP]) +(\d+)", sections["T"][0][:72]))
    assert {k: int(v) for k, v in counts.items()} == {k: len(sections[k]) for k in "SGDP"}
    assert unspecial.id in "".join(line[:72] for line in sections["S"])
    count = len(body(unspecial)["control_points_mm"]) - 1
    assert sections["P"][0].startswith(f"126,{count},5,1,1,1,0,")  # plane, closed, no weights


def dxf(data: bytes) -> Any:
    """A drawing as ezdxf reads it."""
    import ezdxf

    return ezdxf.read(io.StringIO(data.decode()))


def entities(data: bytes, kind: str) -> list[list[tuple[int, str]]]:
    """Group codes and values of each entity of a kind, read as the format is written."""
    lines = data.decode().splitlines()
    pairs = [(int(a), b) for a, b in zip(lines[::2], lines[1::2], strict=True)]
    start = next(i for i, pair in enumerate(pairs) if pair == (2, "ENTITIES"))
    found: list[list[tuple[int, str]]] = []
    for code, value in pairs[start + 1 :]:
        if code == 0:
            found.append([])
            if value == "ENDSEC":
                break
        (found[-1] if found else []).append((code, value))
    return [entity for entity in found if entity and entity[0] == (0, kind)]


def numbers(entity: list[tuple[int, str]], code: int) -> np.ndarray:
    return np.array([float(value) for own, value in entity if own == code])


def test_a_drawing_holds_splines_on_layers(cam) -> None:
    options = DrawingOptions(curve="cutter", cutter_diameter_mm=9.1, bore_mm=11.0, z_mm=2.5)
    data = PROFILE_FORMATS["dxf"].write(cam, options)
    page = dxf(data)
    audit = page.audit()
    assert not audit.errors
    assert not audit.fixes
    assert page.header["$INSUNITS"] == 4
    assert ("Design", cam.id) in list(page.header.custom_vars)
    drawn = [(each.dxftype(), each.dxf.layer) for each in page.modelspace()]
    assert drawn == [
        ("SPLINE", "CUTTER_PATH"), ("SPLINE", "CAM_PROFILE"), ("SPLINE", "PITCH_CURVE"),
        ("CIRCLE", "BASE_CIRCLE"), ("CIRCLE", "BORE"),
    ]  # fmt: skip
    base, bore = page.modelspace().query("CIRCLE")
    assert base.dxf.radius == cam.dimensions["base_radius_mm"]
    assert bore.dxf.radius == 5.5
    written = entities(data, "SPLINE")
    for entity, curve, wide in zip(
        written, ("cutter", "profile", "pitch"), (9.1, None, None), strict=True
    ):
        known = spline_of(body(cam, curve=curve, z_mm=2.5, cutter_diameter_mm=wide))
        control = np.column_stack([numbers(entity, code) for code in (10, 20, 30)])
        np.testing.assert_allclose(control, known.c, rtol=0, atol=1e-12)
        np.testing.assert_allclose(numbers(entity, 40), known.t, rtol=0, atol=1e-12)
        np.testing.assert_array_equal(control[0], control[-1])
        assert (numbers(entity, 71), numbers(entity, 74)) == ([5], [0])  # no fit points


def test_one_curve_of_a_drawing_alone(unspecial: Design) -> None:
    options = DrawingOptions(curve="pitch", companions=False)
    page = dxf(PROFILE_FORMATS["dxf"].write(unspecial, options))
    assert [each.dxf.layer for each in page.modelspace()] == ["PITCH_CURVE"]


def test_the_order_of_classes_is_that_of_their_names(p1: Design) -> None:
    """A set has another order in every process: the bytes would differ."""
    page = dxf(PROFILE_FORMATS["dxf"].write(p1, DrawingOptions()))
    names = [each.dxf.name for each in page.classes]
    drawn = [name for name in names if name in ("ACDBPLACEHOLDER", "LAYOUT", "MATERIAL")]
    assert len(drawn) > 1
    assert drawn == sorted(drawn)


def test_a_drawing_of_arcs(cam, truth) -> None:
    options = DrawingOptions(form="arcs", companions=False, tolerance_um=2.0)
    made = PROFILE_FORMATS["dxf"].make(cam, options)
    (line,) = dxf(made.data).modelspace()
    assert line.closed
    assert len(line) < 110
    rows = np.array(line.get_points("xyb"))
    least = np.full(len(SOME), np.inf)
    place = truth(cam).points(SOME)
    place = place[:, 0] + 1j * place[:, 1]
    corner = rows[:, 0] + 1j * rows[:, 1]
    for a, b, bulge in zip(corner, np.roll(corner, -1), rows[:, 2], strict=True):
        if bulge == 0.0:
            along = np.clip(((place - a) / (b - a)).real, 0.0, 1.0)
            off = np.abs(place - a - along * (b - a))
        else:
            centre = 0.5 * (a + b) + 0.5j * (b - a) * (1.0 - bulge**2) / (2.0 * bulge)
            turn = np.angle((place - centre) / (0.5 * (a + b) - centre) * np.sign(1 - abs(bulge)))
            on = np.abs(turn) <= 2.0 * np.arctan(abs(bulge)) + 1e-9
            off = np.where(on, np.abs(np.abs(place - centre) - abs(a - centre)), np.inf)
        least = np.minimum(least, off)
    error = float(made.metadata["Curve-Error-Mm"])
    assert 0.2 * error < np.max(least) <= error <= 2e-3


@pytest.mark.parametrize(("kind", "sample"), CASES)
def test_every_curve_of_every_machine(kind: str, sample: int) -> None:
    question = spec(kind, sample)
    known = given_cam(question)
    theta = np.radians(SOME[::4])
    flanks = question.follower.flanks
    for flank in flanks:
        gap = flank.side * flank.distance
        cam = Cam(
            known.motion, question.follower.travel, 1.0, question.follower, known.size,
            question.rotation, flank, gap,
        )  # fmt: skip
        spline = fit_closed_spline(Contour.of(cam), 1e-7)
        at = cam.at(theta)
        found = away(
            np.column_stack([at.x, at.y]), BSpline(spline.knots, spline.points, spline.degree)
        )
        assert np.max(found) <= spline.error <= 1e-7


@pytest.mark.parametrize("room", [1e-9, 1e-3])
def test_a_profile_that_nearly_has_a_corner(room: float) -> None:
    """As the smallest flat-face cams have: the radius of curvature all but vanishes."""
    question = spec("translating_flat_face")
    motion = given_cam(question).motion
    s, _, bend, _ = motion.derivatives(np.linspace(0.0, 2.0 * np.pi, 200_001))
    size = (float(-np.min(s + bend)) + room,)
    follower = question.follower
    flank = follower.flanks[0]
    cam = Cam(motion, follower.travel, 1.0, follower, size, question.rotation, flank, 0.0)
    spline = fit_closed_spline(Contour.of(cam), 1e-6)
    at = cam.at(np.radians(SOME))
    found = away(np.column_stack([at.x, at.y]), BSpline(spline.knots, spline.points, 5))
    assert np.max(found) <= spline.error <= 1e-6
    assert len(spline.points) < 300


def bent(steps: tuple[float, float], roller: float) -> Cam:
    """A cam whose velocity jumps at 0° and at 360° · 0.37, and nowhere else."""
    first, second = 0.37 * 2.0 * np.pi, 0.63 * 2.0 * np.pi
    up, down = steps
    # from 0 to 1 with the slopes `up` and 0, and back with 0 and `down`: cubics
    rise = Piecewise.of([0.0, 1.0], [[0.0, up, 3.0 - 2.0 * up, up - 2.0]])
    back = Piecewise.of([0.0, 1.0], [[0.0, 0.0, 3.0 - down, down - 2.0]])
    follower = TranslatingRoller(roller_radius_mm=roller, offset_mm=3.1)
    motion = Motion.of(
        [
            PlacedSegment(0, "rise", 0.0, first, 0.0, 9.7, rise),
            PlacedSegment(1, "return", first, second, 9.7, 0.0, back),
        ]
    )
    flank = follower.flanks[0]
    gap = flank.side * flank.distance
    return Cam(motion, follower.travel, 1.0, follower, (3.1, 47.3), "ccw", flank, gap)


def test_where_velocity_jumps_the_roller_turns_on_the_spot() -> None:
    cam = bent((1.3, 0.9), 8.3)  # from falling to rising: hollow
    spline = fit_closed_spline(Contour.of(cam), 1e-7)
    _, times = np.unique(spline.knots, return_counts=True)
    assert np.max(times[1:-1]) == 4  # no corner: an arc of the roller's radius
    at = cam.at(np.array([0.0, 0.0]), np.array([True, False]))
    turn = np.linspace(0.0, 1.0, 23)[:, None]
    nx, ny = at.normal_x, at.normal_y
    normal = (1 - turn) * np.array([nx[0], ny[0]]) + turn * np.array([nx[1], ny[1]])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    arc = np.array([at.pitch_x[0], at.pitch_y[0]]) - 8.3 * normal
    found = away(arc, BSpline(spline.knots, spline.points, spline.degree))
    assert np.hypot(*(arc[0] - arc[-1])) > 0.5
    assert np.max(found) < spline.error <= 1e-7


def test_where_velocity_jumps_down_the_roller_undercuts() -> None:
    cam = bent((-0.4, -0.9), 8.3)
    with pytest.raises(InputError, match="undercut") as caught:
        Contour.of(cam)
    assert caught.value.value in ("0°", "360°")
    fit_closed_spline(Contour.of(replace(cam, gap=0.0)), 1e-6)


def test_a_knife_edge_s_corner_stays_one() -> None:
    spline = fit_closed_spline(Contour.of(bent((1.3, 0.9), 0.0)), 1e-7)
    knots, times = np.unique(spline.knots, return_counts=True)
    assert spline.error <= 1e-7
    ends = spline.at(np.array([knots[0], knots[-1]]), 1)
    assert abs(np.linalg.det(ends)) > 0.05
    assert np.max(times[1:-1]) <= 4


def test_a_curve_that_runs_backwards_is_refused_with_its_place(build) -> None:
    sharp = build(prime=34.0, offset=11.3, roller=27.0)
    with pytest.raises(InputError, match="undercut") as caught:
        body(sharp)
    assert caught.value.field == "/curve"
    assert 0.0 < float(caught.value.value.rstrip("°")) < 360.0
    assert body(sharp, curve="pitch")["error_mm"] <= 1e-6


def test_a_cutter_that_does_not_fit_is_refused(build) -> None:
    with pytest.raises(InputError, match="no cutter larger than") as caught:
        body(build(), curve="cutter", cutter_diameter_mm=400.0)
    assert caught.value.field == "/cutter_diameter_mm"


@pytest.mark.parametrize("tolerance", [0.0, -1.0, 1e-7, 1e4, float("nan")])
@pytest.mark.parametrize("options", [ExactOptions, DrawingOptions])
def test_tolerances_that_make_no_sense(options: Any, tolerance: float) -> None:
    with pytest.raises(InputError, match="at least 1e-06 and at most 1000") as caught:
        options(tolerance_um=tolerance)
    assert caught.value.field == "/tolerance_um"
