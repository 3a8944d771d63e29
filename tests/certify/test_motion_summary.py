"""The motion in numbers: against closed forms of the literature and quadrature by other routes."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from numpy.polynomial import Polynomial

import synthesis as c
from synthesis.catalogue.laws import LAWS
from synthesis.catalogue.laws.figures import figures
from synthesis.design.summary import MotionSummary
from synthesis.numerics.polynomial_extrema import product
from tests.numerics.test_polynomial_extrema import by_roots

RPM, LIFT, RISE, RETURN = 200.0, 45.0, 120.0, 100.0


ROLLER = {"kind": "translating_roller", "roller_radius_mm": 16.0, "offset_mm": 0.0}
PRESSURE_ANGLE = {"kind": "pressure_angle", "rise_deg": 30.0, "return_deg": 45.0}
JERK = [PRESSURE_ANGLE, {"kind": "jerk", "max_mm_per_s3": 2e7}]


def specification(*laws: str, **fields) -> c.DesignSpec:
    """A rise and a return by these laws between dwells, on a cam of 90 mm, but for ``fields``."""
    moves = [{"lift_mm": LIFT, "law": {"kind": law}} for law in laws or ("spline", "spline")]
    program = [
        {"kind": "rise", "angle_deg": RISE, **moves[0]},
        {"kind": "dwell", "angle_deg": 60.0},
        {"kind": "return", "angle_deg": RETURN, **moves[1]},
        {"kind": "dwell", "angle_deg": 80.0},
    ]
    given = {
        "speed_rpm": RPM, "program": program, "follower": ROLLER, "base_radius_mm": 90.0,
        "proof": "quick",
    }  # fmt: skip
    return c.DesignSpec.model_validate({**given, **fields})


def summary(*laws: str) -> MotionSummary:
    """Of a rise and a return by these laws."""
    found = c.synthesise(specification(*laws)).motion_summary
    assert found is not None
    return found


# Closed forms (VDI 2143-1; Norton, Cam Design and Manufacturing Handbook): peaks where the next
# derivative vanishes, mean squares by hand. Of the 3-4-5 polynomial v a = 1800 u³ (1 − 2x) with
# u = x (1 − x) is largest at u = 3/14.
PI = math.pi
MODIFIED_SINE = {
    "Cv": 4.0 * PI / (4.0 + PI), "Ca": 4.0 * PI**2 / (4.0 + PI), "Cj": 16.0 * PI**3 / (4.0 + PI),
}  # fmt: skip
CYCLOIDAL = {
    "Cv": 2.0, "Ca": 2.0 * PI, "Cj": 4.0 * PI**2, "Cva": 3.0 * math.sqrt(3.0) / 2.0 * PI,
    "Ea": 2.0 * PI**2, "Ej": 8.0 * PI**4,
}  # fmt: skip
POLYNOMIAL_3_4_5 = {
    "Cv": 15.0 / 8.0, "Ca": 10.0 / math.sqrt(3.0), "Cj": 60.0, "Ea": 120.0 / 7.0, "Ej": 720.0,
    "Cva": 1800.0 * 27.0 / 2744.0 / math.sqrt(7.0),
}  # fmt: skip


@pytest.mark.parametrize(
    ("law", "known"),
    [
        ("modified_sine", MODIFIED_SINE),
        ("cycloidal", CYCLOIDAL),
        ("polynomial_3_4_5", POLYNOMIAL_3_4_5),
    ],
)
def test_coefficients_are_those_of_the_literature(law, known):
    found = summary(law, law).moves
    for move in found:
        for name, value in known.items():
            assert getattr(move.coefficients, name) == pytest.approx(value, rel=1e-12), name
    assert [move.reference.law for move in found] == ["modified_sine", "modified_sine"]
    assert found[0].reference.coefficients.Ca == pytest.approx(MODIFIED_SINE["Ca"], rel=1e-12)


def test_jumps_of_acceleration_make_jerk_infinite():
    """Constant accelerations ±4h/T²: jumps of that size at both ends and twice it in the middle."""
    found = summary("parabolic", "cycloidal")
    rise, back = found.moves
    peak = 4.0 * LIFT * (RPM * 6.0 / RISE) ** 2  # mm/s²
    assert (rise.acceleration.largest.value, rise.acceleration.smallest.value) == pytest.approx(
        (peak, -peak), rel=1e-12
    )
    assert rise.acceleration.jumps == 3
    jump = rise.acceleration.largest_jump
    assert (jump.value, jump.angle_deg) == pytest.approx((-2.0 * peak, 0.5 * RISE), rel=1e-12)
    assert rise.jerk.rms is None
    assert (rise.coefficients.Cj, rise.coefficients.Ej) == (None, None)
    assert rise.coefficients.Ea == pytest.approx(16.0, rel=1e-12)
    assert found.jerk.rms is None
    assert found.acceleration.jumps == 3
    assert back.coefficients.Cj == pytest.approx(CYCLOIDAL["Cj"], rel=1e-12)
    assert back.acceleration.jumps == 0
    assert back.acceleration.largest_jump is None


def test_jumps_of_velocity_make_acceleration_infinite():
    found = summary("constant_velocity", "cycloidal").moves[0]
    speed = LIFT * RPM * 6.0 / RISE
    assert found.velocity.jumps == 2
    assert abs(found.velocity.largest_jump.value) == pytest.approx(speed, rel=1e-12)
    assert found.velocity.rms == pytest.approx(speed, rel=1e-12)
    infinite = found.coefficients
    assert (infinite.Ca, infinite.Cj, infinite.Cva, infinite.Ea) == (None,) * 4
    assert found.acceleration.rms is None


def test_a_splines_figures_are_those_of_its_polynomials():
    """Peaks by numpy's roots, rms by antiderivatives of squares, signs of a return, the turn's."""
    design = c.synthesise(specification("spline", "spline", limits=JERK))
    found, motion = design.motion_summary, design.curve
    omega = RPM * 2.0 * PI / 60.0
    squares = dict.fromkeys(range(1, 4), 0.0)
    for move in found.moves:
        segment = motion.segments[move.segment]
        curve = segment.placed()
        for order, name in enumerate(("velocity", "acceleration", "jerk"), start=1):
            expected, own = getattr(move, name), 0.0
            high, low = by_roots(curve, order)
            assert expected.largest.value == pytest.approx(high * omega**order, rel=1e-10)
            assert expected.smallest.value == pytest.approx(
                low * omega**order, rel=1e-10, abs=1e-9 * high * omega**order
            )
            for row, start, end, origin in zip(
                curve.poly, curve.breaks[:-1], curve.breaks[1:], curve.origins, strict=True
            ):
                square = (Polynomial(row).deriv(order) ** 2).integ()
                own += float(square(end - origin) - square(start - origin))
            squares[order] += own
            rms = math.sqrt(own / segment.angle) * omega**order
            assert expected.rms == pytest.approx(rms, rel=1e-10)
        h, beta = abs(segment.lift), segment.angle
        high, low = by_roots(product(curve, 1, 2), 0)
        cva = max(high, -low) * beta**3 / h**2
        assert move.coefficients.Cva == pytest.approx(cva, rel=1e-10)
        assert move.coefficients.Ej == pytest.approx(
            (move.jerk.rms / omega**3) ** 2 * beta**6 / h**2, rel=1e-10
        )
    assert found.moves[1].velocity.largest.value == 0.0
    assert found.acceleration.rms == pytest.approx(
        math.sqrt(squares[2] / (2.0 * PI)) * omega**2, rel=1e-10
    )
    assert found.jerk.largest.value <= JERK[1]["max_mm_per_s3"]
    peaks = [move.acceleration.smallest for move in found.moves]
    assert found.acceleration.smallest == min(peaks, key=lambda peak: peak.value)


@pytest.mark.parametrize(
    ("kinds", "expected"),
    [
        ("rise dwell return dwell", [("modified_sine", "R-R")] * 2),
        ("rise return dwell", [("polynomial_3_4_5_6", "R-U"), ("polynomial_3_4_5_6", "U-R")]),
        ("rise return", [("simple_harmonic", "U-U")] * 2),
        ("rise dwell=0 return dwell", [("polynomial_3_4_5_6", e) for e in ("R-U", "U-R")]),
    ],
)
def test_the_reference_suits_the_ends(kinds, expected):
    words = kinds.split()
    program = []
    for word in words:
        kind, _, angle = word.partition("=")
        segment = {"kind": kind, "angle_deg": float(angle or 0.0) if angle else None}
        if kind != "dwell":
            segment |= {"lift_mm": 10.0, "law": {"kind": "spline"}}
        program.append(segment)
    free = [segment for segment in program if segment["angle_deg"] is None]
    for segment in free:
        segment["angle_deg"] = 360.0 / len(free)
    found = c.synthesise(specification(program=program, limits=JERK)).motion_summary
    assert [(m.reference.law, m.reference.ends) for m in found.moves] == expected
    known = {"polynomial_3_4_5_6": 6.0, "simple_harmonic": 0.5 * PI**2}
    for move in found.moves:
        expected_peak = known.get(move.reference.law, MODIFIED_SINE["Ca"])
        assert move.reference.coefficients.Ca == pytest.approx(expected_peak, rel=1e-12)


def test_between_motions_the_reference_meets_the_states():
    """R-G and G-R beside a constant velocity, by the polynomial of degree 5 with these ends."""
    program = [
        {"kind": "rise", "angle_deg": 60.0, "lift_mm": 10.0, "law": {"kind": "polynomial_5"}},
        {"kind": "rise", "angle_deg": 60.0, "lift_mm": 20.0, "law": {"kind": "constant_velocity"}},
        {"kind": "rise", "angle_deg": 60.0, "lift_mm": 10.0, "law": {"kind": "polynomial_5"}},
        {"kind": "return", "angle_deg": 180.0, "lift_mm": 40.0, "law": {"kind": "polynomial_5"}},
    ]
    found = c.synthesise(specification(program=program)).motion_summary
    assert [move.reference.ends for move in found.moves] == ["U-G", "G-G", "G-U", "U-U"]
    own, reference = found.moves[0].coefficients, found.moves[0].reference
    assert reference.law == "polynomial_5"
    assert reference.coefficients == own  # the law is that polynomial, between these states


def test_what_rounding_leaves_of_an_opposite_velocity_is_none():
    """A polynomial from a constant velocity to rest ends at some 1e-14 mm/s."""
    example = Path(__file__).parents[2] / "openapi" / "examples" / "constant-velocity.json"
    spec = c.DesignSpec.model_validate(json.loads(example.read_text())["value"])
    moves = c.synthesise(spec.model_copy(update={"proof": "quick"})).motion_summary.moves
    assert moves[-1].velocity.smallest.value == pytest.approx(-558.8, rel=1e-12)
    assert moves[-1].velocity.largest.value == 0.0


def test_an_arms_figures_are_in_degrees():
    program = [
        {"kind": "rise", "angle_deg": 120.0, "lift_deg": 15.0, "law": {"kind": "cycloidal"}},
        {"kind": "dwell", "angle_deg": 60.0},
        {"kind": "return", "angle_deg": 120.0, "lift_deg": 15.0, "law": {"kind": "cycloidal"}},
        {"kind": "dwell", "angle_deg": 60.0},
    ]
    arm = {
        "kind": "oscillating_roller", "roller_radius_mm": 8.0, "arm_mm": 90.0,
        "centre_distance_mm": 110.0,
    }  # fmt: skip
    design = c.synthesise(specification(program=program, follower=arm, base_radius_mm=40.0))
    velocity = design.motion_summary.velocity
    assert velocity.unit == "deg/s"
    assert velocity.largest.value == pytest.approx(2.0 * 15.0 * RPM * 6.0 / 120.0, rel=1e-12)
    assert velocity.largest.angle_deg == pytest.approx(60.0, abs=1e-6)


@pytest.mark.parametrize("kind", LAWS)
def test_no_sample_of_a_law_is_beyond_its_figures(kind):
    """Peaks, C_va and mean squares of every law, its inflection moved, against 40,000 samples."""
    law = LAWS[kind]
    if hasattr(law, "inflection"):
        law = law.model_copy(update={"inflection": 0.4})
    curve = law.curve("rise")
    found = figures(curve)
    count = 40_000
    x = (np.arange(count) + 0.5) / count
    g = curve.derivatives(x, 3)
    for order in (1, 2, 3):
        assert found.peak(order) >= np.abs(g[order]).max() * (1.0 - 1e-12)
        assert found.peak(order) == pytest.approx(np.abs(g[order]).max(), rel=3e-3, abs=1e-12)
        mean = float(np.mean(g[order] ** 2))
        assert found.mean_squares[order - 1] == pytest.approx(mean, rel=1e-5, abs=1e-20)
    product = np.abs(g[1] * g[2]).max()
    assert found.product_peak >= product * (1.0 - 1e-12)
    assert found.product_peak == pytest.approx(product, rel=1e-3, abs=1e-12)


@pytest.mark.parametrize("continuity", [2, 3, 4])
def test_a_spline_that_starts_from_rest_never_moves_back(continuity):
    """Its control points are rounded: a velocity of −1e-18 lifts a radian is none."""
    spec = specification("spline", "spline", limits=[PRESSURE_ANGLE], continuity=continuity)
    found = c.synthesise(spec).motion_summary
    rise, back = (move.velocity for move in found.moves)
    assert rise.smallest.value == 0.0
    assert back.largest.value == 0.0
