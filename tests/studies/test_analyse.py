"""Analysis of given cams, against textbook formulas on a fine grid."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest

from synthesis import DesignSpec, analyse
from synthesis.design.analysis import Analysis, CurveSummary
from synthesis.errors import InputError, TimeBudgetExceeded
from synthesis.exporters import PICTURES, PictureOptions
from synthesis.studies.analyse import as_design
from synthesis.units import rad_per_s
from tests.studies.cams import PRESSURE, Textbook, program, roller, spec

pytestmark = pytest.mark.usefixtures("coarse_conflicts")


@cache
def given() -> Analysis:
    """Of the cam that most tests look at."""
    return analyse(spec())


def curve(found: Analysis, name: str, over: str = "turn") -> CurveSummary:
    (one,) = (c for c in found.curves if (c.curve, c.over) == (name, over))
    return one


def extreme(found: Analysis, name: str) -> Any:
    (one,) = (e for e in found.extremes if e.limit == name)
    return one


def test_extremes_of_every_curve_are_those_of_the_textbook() -> None:
    question = spec()
    found, book = given(), Textbook(question)
    omega = rad_per_s(question.speed_rpm)
    names = ("displacement", "velocity", "acceleration", "jerk")
    expected = {name: book.s[k] * omega**k for k, name in enumerate(names)}
    expected |= {"pressure_angle": book.alpha, "pitch_curvature": book.curvature}
    for name, values in expected.items():
        one, scale = curve(found, name), np.max(np.abs(values))
        for peak, best in ((one.largest, np.max(values)), (one.smallest, np.min(values))):
            assert peak is not None
            assert peak.value == pytest.approx(best, abs=2e-4 * scale)
            beside = np.argmin(np.abs(book.degrees - peak.angle_deg))
            near = values[max(beside - 1, 0) : beside + 2]
            assert np.min(np.abs(near - peak.value)) < 3e-4 * scale, (name, peak)
    assert curve(found, "convex_radius").smallest.value == pytest.approx(
        1.0 / np.max(book.curvature) - 9.3, abs=1e-5
    )
    assert curve(found, "hollow_radius").smallest.value == pytest.approx(
        -1.0 / np.min(book.curvature) + 9.3, rel=1e-5
    )


def test_without_a_dwell_none_is_summed_up() -> None:
    moves = [each | {"angle_deg": 180.0} for each in program() if each["kind"] != "dwell"]
    angles = [each for each in analyse(spec(program=moves)).curves if each.unit == "deg"]
    assert [each.over for each in angles] == ["turn", "rise", "return"]


def test_a_broken_limit_says_by_how_much_and_where() -> None:
    found, book = given(), Textbook(spec())
    rise = book.degrees <= 73.3
    k = int(np.argmax(book.alpha * rise))
    broken = extreme(found, "pressure_angle_rise")
    assert not found.holds
    assert found.violated[0] == "pressure_angle_rise"
    assert broken.value == pytest.approx(book.alpha[k], abs=1e-6)
    assert broken.angle_deg == pytest.approx(book.degrees[k], abs=0.01)
    assert broken.margin == pytest.approx(31.7 - book.alpha[k], abs=1e-6)


@pytest.mark.parametrize("offset", ["kept", "free"])
def test_the_size_that_mends_it_is_the_smallest(offset: str) -> None:
    found = given()
    (size,) = (s for s in found.remedy.sizes if s.offset == offset)
    base, e = size.dimensions["base_radius_mm"], size.dimensions["offset_mm"]
    assert size.base_radius_change_mm == pytest.approx(base - 21.9)
    assert size.offset_change_mm == pytest.approx(e - 7.1)
    if offset == "kept":
        assert e == 7.1
    mended = spec(base_radius_mm=base, follower=roller(9.3, e))
    assert analyse(mended).holds
    tried = [e] if offset == "kept" else np.linspace(-30.0, 30.0, 25)
    for other in tried:
        smaller = spec(base_radius_mm=base * (1.0 - 1e-6), follower=roller(9.3, float(other)))
        assert Textbook(smaller, 20_001).alpha.max() > 31.7 or broken_on_return(smaller)


def broken_on_return(question: DesignSpec) -> bool:
    book = Textbook(question, 20_001)
    back = (book.degrees >= 114.5) & (book.degrees <= 203.4)
    return bool(np.min(book.alpha[back]) < -43.1)


def test_a_cam_that_holds_has_nothing_to_mend() -> None:
    found = analyse(spec(base_radius_mm=61.3))
    assert found.holds
    assert (found.violated, found.remedy, found.undercut) == ([], None, None)
    assert [jump.curve for jump in found.jumps] == []
    for one in found.curves:
        assert one.infinite_deg == []


@pytest.mark.usefixtures("unexplained")
def test_undercut_is_found_where_the_curvature_is_largest(request: pytest.FixtureRequest) -> None:
    question = spec(base_radius_mm=2.6, limits=[], follower=roller(17.9, -4.3))
    found, book = analyse(question), Textbook(question)
    k = int(np.argmax(book.curvature))
    radius = 1.0 / book.curvature[k]
    assert radius < 17.9
    assert found.undercut.kind == "undercut"
    assert found.undercut.angle_deg == pytest.approx(book.degrees[k], abs=0.01)
    assert found.undercut.pitch_radius_mm == pytest.approx(radius, rel=1e-6)
    assert found.undercut.excess_mm == pytest.approx(17.9 - radius, rel=1e-4)
    assert found.violated == ["profile_radius"]
    request.getfixturevalue("unmended")
    kept = found.remedy.sizes[0]
    base = kept.dimensions["base_radius_mm"]
    again = {"limits": [], "follower": roller(17.9, -4.3)}
    assert analyse(spec(base_radius_mm=base, **again)).undercut is None
    assert analyse(spec(base_radius_mm=base * (1.0 - 1e-5), **again)).undercut is not None


@pytest.mark.usefixtures("unmended")
def test_a_roller_as_large_as_the_radius_makes_a_cusp() -> None:
    before = curve(analyse(spec(limits=[])), "convex_radius").smallest
    radius = before.value + 9.3
    found = analyse(spec(limits=[], base_radius_mm=31.2 - radius, follower=roller(radius)))
    assert found.undercut.kind == "cusp"
    assert found.undercut.angle_deg == pytest.approx(before.angle_deg, abs=1e-3)


@pytest.mark.usefixtures("unmended")
def test_jumps_are_one_sided() -> None:
    question = spec(program=program("parabolic", "simple_harmonic"))
    found, omega = analyse(question), rad_per_s(137.0)
    beta, back = math.radians(73.3), math.radians(88.9)
    a, b = 4.0 * 23.7 / beta**2 * omega**2, math.pi**2 * 23.7 / 2.0 / back**2 * omega**2
    expected = {
        0.0: (0.0, a), 36.65: (a, -a), 73.3: (-a, 0.0), 114.5: (0.0, -b), 203.4: (b, 0.0),
    }  # fmt: skip
    jumps = [jump for jump in found.jumps if jump.curve == "acceleration"]
    assert [jump.angle_deg for jump in jumps] == pytest.approx(list(expected), abs=1e-9)
    for jump, (before, after) in zip(jumps, expected.values(), strict=True):
        assert jump.before == pytest.approx(before, rel=1e-9, abs=1e-6)
        assert jump.after == pytest.approx(after, rel=1e-9, abs=1e-6)
        assert jump.jump == jump.after - jump.before
    bent = [jump for jump in found.jumps if jump.curve == "pitch_curvature"]
    assert [jump.angle_deg for jump in bent] == [jump.angle_deg for jump in jumps]
    for peak in (curve(found, "acceleration").largest, curve(found, "acceleration").smallest):
        assert peak is not None
        there = [jump for jump in jumps if abs(jump.angle_deg - peak.angle_deg) < 1e-9]
        for jump in there:  # the parabolic law is constant: it may be named inside as well
            at = {"left": jump.before, "right": jump.after}
            assert at[peak.side] == pytest.approx(peak.value, rel=1e-9)
        assert there or peak.side == "both"
    largest = curve(found, "acceleration").largest
    assert largest.value == pytest.approx(max(a, b), rel=1e-9)
    assert curve(found, "jerk").infinite_deg == [jump.angle_deg for jump in jumps]


@pytest.mark.usefixtures("unmended")
def test_a_jump_of_the_velocity_breaks_the_pitch_curve() -> None:
    found = analyse(spec(program=program("constant_velocity", "constant_velocity"), limits=[]))
    slope = 23.7 / math.radians(73.3) * rad_per_s(137.0)
    first = next(jump for jump in found.jumps if jump.curve == "velocity")
    assert (first.angle_deg, first.before) == (0.0, 0.0)
    assert first.after == pytest.approx(slope, rel=1e-9)
    assert found.undercut.kind == "corner"
    assert found.undercut.angle_deg in (73.3, 114.5)  # at the dwell's ends it turns convexly
    assert curve(found, "pitch_curvature").infinite_deg == [0.0, 73.3, 114.5, 203.4]
    assert curve(found, "velocity").largest.value == pytest.approx(slope, rel=1e-9)


@pytest.mark.usefixtures("unmended")
@pytest.mark.parametrize("law", ["simple_harmonic", "cubic_2_3"])
def test_a_peak_at_a_jump_is_on_its_side(law: str) -> None:
    """Laws whose accelerations are largest at their ends, where they jump to those of dwells."""
    found = analyse(spec(program=program(law, law), limits=[]))
    largest, smallest = curve(found, "acceleration").largest, curve(found, "acceleration").smallest
    # the rise is the shorter one: it starts with the largest and ends with the smallest
    assert (largest.angle_deg, largest.side) == (0.0, "right")
    assert (smallest.angle_deg, smallest.side) == (73.3, "left")
    later = [program(law, law)[k] for k in (1, 2, 3, 0)]
    turned = curve(analyse(spec(program=later, limits=[])), "acceleration")
    assert (turned.largest.angle_deg, turned.largest.side) == (pytest.approx(286.7), "right")
    assert turned.smallest.side == "left"
    assert turned.smallest.angle_deg % 360.0 == 0.0
    # where nothing jumps, and inside a law, there is one side
    assert curve(found, "velocity").largest.side == "both"


@pytest.mark.usefixtures("unmended")
def test_a_hollow_corner_is_no_undercut_and_a_later_convex_one_is() -> None:
    first_a_dwell = [program("constant_velocity", "constant_velocity")[k] for k in (3, 0, 1, 2)]
    found = analyse(spec(program=first_a_dwell, limits=[]))
    assert found.undercut.kind == "corner"
    assert found.undercut.angle_deg in (pytest.approx(156.6 + 73.3), pytest.approx(156.6 + 114.5))


def test_peaks_are_enclosed() -> None:
    found = analyse(spec(base_radius_mm=61.3))
    for one in found.curves:
        for peak in filter(None, (one.largest, one.smallest)):
            assert peak.width <= 1e-9 * max(abs(peak.value), 1.0)
    assert curve(found, "jerk").largest.width > 0.0
    assert curve(found, "pressure_angle").largest.width > 0.0


def test_a_clockwise_cam_is_the_mirror_image() -> None:
    one, other = given(), analyse(spec(rotation="cw"))
    same = {"name", "holds", "dimensions", "violated", "extremes", "curves", "jumps", "remedy"}
    assert one.model_dump(include=same) == other.model_dump(include=same)


def test_a_limit_that_no_size_mends() -> None:
    found = analyse(spec(limits=[{"kind": "acceleration", "max_mm_per_s2": 900.0}]))
    assert [size.status for size in found.remedy.sizes] == ["infeasible", "infeasible"]
    (alone,) = (r for r in found.remedy.relaxations if r.limit == "acceleration")
    needed = max(
        abs(peak.value) for peak in (curve(found, "acceleration").largest,
                                     curve(found, "acceleration").smallest)
    )  # fmt: skip
    assert needed <= alone.needed <= needed * (1.0 + 2e-4)


@pytest.mark.parametrize(
    ("changes", "field", "value"),
    [
        ({"base_radius_mm": None}, "/base_radius_mm", None),
        ({"base_radius_mm": {"min": 30.0}}, "/base_radius_mm", {"min": 30.0, "max": None}),
        (
            {"follower": {"kind": "translating_roller", "roller_radius_mm": 9.3}},
            "/follower/offset_mm", None,
        ),
        ({"program": program(back="spline")}, "/program/2/law", "spline"),
    ],
)  # fmt: skip
def test_what_is_left_free_is_named(changes: dict[str, Any], field: str, value: Any) -> None:
    with pytest.raises(InputError) as caught:
        analyse(spec(**changes))
    assert (caught.value.field, caught.value.value) == (field, value)
    assert "given in full" in caught.value.rule
    assert "/v1/designs" in caught.value.remedy


@pytest.mark.usefixtures("unmended")
def test_a_range_of_one_value_is_given() -> None:
    found = analyse(spec(base_radius_mm={"min": 21.9, "max": 21.9}))
    assert found.dimensions == analyse(spec()).dimensions


@pytest.mark.usefixtures("unmended")
def test_a_knife_edge_is_not_undercut() -> None:
    found = analyse(spec(follower=roller(0.0), limits=[PRESSURE]))
    assert found.undercut is None
    assert found.dimensions["prime_radius_mm"] == pytest.approx(21.9)


def test_time_that_has_run_out_is_said() -> None:
    with pytest.raises(TimeBudgetExceeded):
        analyse(spec(), deadline=-1.0)


def test_undercut_under_a_flat_face_is_measured_on_the_face() -> None:
    """ρ = Rb + s + s'', typed again; cycloidal, so s'' is least at three quarters of the rise."""
    lift, angle, base = 20.3, 80.0, 25.7
    law = {"kind": "cycloidal"}
    program = [
        {"kind": "rise", "angle_deg": angle, "lift_mm": lift, "law": law},
        {"kind": "dwell", "angle_deg": 31.0},
        {"kind": "return", "angle_deg": 95.0, "lift_mm": lift, "law": law},
        {"kind": "dwell", "angle_deg": 154.0},
    ]
    body = {
        "program": program,
        "follower": {"kind": "translating_flat_face"},
        "base_radius_mm": base,
    }
    x = np.linspace(0.0, 1.0, 200_001)
    s = lift * (x - np.sin(2.0 * np.pi * x) / (2.0 * np.pi))
    bend = lift * 2.0 * np.pi * np.sin(2.0 * np.pi * x) / np.radians(angle) ** 2
    least = float(np.min(base + s + bend))
    assert least < 0.0
    found = analyse(DesignSpec.model_validate(body))
    assert found.self_crossing is None
    assert found.undercut is not None
    assert found.undercut.kind == "undercut"
    assert found.undercut.pitch_radius_mm == pytest.approx(least, abs=1e-7)
    assert found.remedy is not None
    (size,) = found.remedy.sizes
    assert size.base_radius_change_mm == pytest.approx(-least, rel=1e-6)
    larger = DesignSpec.model_validate(body | {"base_radius_mm": base - least + 0.01})
    assert analyse(larger).undercut is None


def test_the_report_of_an_analysis_links_to_no_proof() -> None:
    page = PICTURES["report.html"].write(as_design(given()), PictureOptions())
    assert b"Certificate" in page
    assert b"proof.json" not in page
