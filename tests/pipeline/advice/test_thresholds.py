"""Each threshold from both sides: what is said a little below it and a little above."""

from __future__ import annotations

from math import pi, sqrt
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from synthesis import DesignSpec, analyse, synthesise
from synthesis.catalogue.limits.motion import Acceleration
from synthesis.design.design import Design
from synthesis.optimise.strategy.unmodelled_limits import IN_PROOF
from synthesis.pipeline.advice import with_warnings
from tests.pipeline.advice.bad_cams import angles, cam, program, slide

Spec = dict[str, Any]
LIFT, RISE = 30.0, pi / 2.0  # mm, rad: of the plain cam


def harmonic(jump: float) -> Spec:
    """A simple harmonic whose acceleration jumps so far [m/s²]: π²h/(2β²) ω²."""
    omega = sqrt(jump / (pi**2 * LIFT / (2.0 * RISE**2) * 1e-3))
    return cam(70.0, speed_rpm=omega * 30.0 / pi, program=program(law="simple_harmonic"))


def line(jump: float) -> Spec:
    """A straight line whose velocity jumps so far [m/s]: h/β ω."""
    omega = jump / (LIFT / RISE * 1e-3)
    return cam(70.0, speed_rpm=omega * 30.0 / pi, program=program(law="constant_velocity"))


def solid(share: float) -> Spec:
    """A spring of which the coils touch at so many times its largest compression, 20 + 30 mm."""
    return cam(70.0, load=slide(1.0, 5.0, 100.0, solid_mm=50.0 * share))


def ringing(periods: float) -> Spec:
    """A train with so many periods in the shortest move, of a quarter of a second."""
    limit = {"kind": "residual_vibration", "natural_frequency_hz": 4.0 * periods, "max_mm": 30.0}
    return cam(70.0, limits=[limit])


def rolling(product: float) -> Spec:
    """A roller of 20 mm whose diameter times speed is this [mm/min]; all but a circle."""
    # on the prime circle it turns (Rp/Rr − 1) times as fast as the cam; on top by a little more
    top = (80.0 + 0.01) / 10.0 - 1.0
    return cam(70.0, speed_rpm=product / 20.0 / top, program=program(0.01, 160.0), limits=[])


def stroke(share: float) -> Spec:
    """A stroke of this share of the roller radius of 10 mm."""
    return cam(40.0, program=program(10.0 * share))


def faced(lift: float, angle: float, radius: float, **more: Any) -> Spec:
    """A flat face whose base radius follows from the least radius of the profile."""
    limits = [{"kind": "profile_radius", "min_mm": radius}]
    follower = {"kind": "translating_flat_face"}
    return cam(None, program=program(lift, angle), follower=follower, limits=limits, **more)


def deepest(lift: float, angle: float) -> float:
    """Largest −(s + s'') of a cycloidal rise: base radius less least radius [mm]."""
    s, _, bend = cycloidal(lift, angle)
    return float(np.max(-(s + bend)))


def cycloidal(lift: float, angle: float) -> tuple[Any, Any, Any]:
    """s, s', s'' of a cycloidal rise, finely [mm over rad]."""
    x, beta = np.linspace(0.0, 1.0, 20_001), np.deg2rad(angle)
    s = lift * (x - np.sin(2.0 * pi * x) / (2.0 * pi))
    rate = lift / beta * (1.0 - np.cos(2.0 * pi * x))
    return s, rate, lift * 2.0 * pi / beta**2 * np.sin(2.0 * pi * x)


def room(share: float) -> Spec:
    """A base circle that leaves room for a shaft of this share of the stroke of 20 mm."""
    base = 0.5 * (1.75 * share * 20.0 + 6.35)
    return faced(20.0, 140.0, base - deepest(20.0, 140.0))


def walled(share: float) -> Spec:
    """A base radius of this share of the reach of the keyway of a 40 mm bore, 12 by 3.3 mm."""
    reach = float(np.hypot(6.0, 20.0 + 3.3))
    body = {"thickness_mm": 10.0, "bore_mm": 40.0}
    return cam(reach * share, body=body, program=program(5.0, 140.0))


CAST_IRON = {"thickness_mm": 10.0, "density_kg_per_m3": 7200.0}


def torque(shaft: float, **more: Any) -> Spec:
    """A force whose largest torque needs a shaft of this diameter; the base radius is 40 mm."""
    moment = 40.0 * pi * shaft**3 / 16.0  # N mm; the law is steepest in its middle: 2 h/β
    force = moment / (2.0 * 10.0 / np.deg2rad(120.0))
    return faced(10.0, 120.0, 40.0 - deepest(10.0, 120.0), load=slide(0.0, 0.0, force), **more)


def steep(degrees: float, **more: Any) -> Spec:
    """A radial cam whose largest pressure angle is this: Rp = max(s'/tan α − s)."""
    s, rate, _ = cycloidal(LIFT, 90.0)
    prime = float(np.max(rate / np.tan(np.deg2rad(degrees)) - s))
    return cam(prime - 2.0, 2.0, **more)


def in_line(degrees: float, **more: Any) -> Spec:
    """An arm that all but points at the axis as it starts: tan α = (l − d cos ψ)/(d sin ψ)."""
    arm, distance, tangent = 100.0, 60.0, np.tan(np.deg2rad(degrees))

    def excess(angle: float) -> float:
        return float(arm - distance * np.cos(angle) - tangent * distance * np.sin(angle))

    start = float(brentq(excess, 1e-6, 0.5))
    prime = sqrt(arm**2 + distance**2 - 2.0 * arm * distance * np.cos(start))
    follower = {
        "kind": "oscillating_roller", "arm_mm": arm, "centre_distance_mm": distance,
        "roller_radius_mm": 10.0,
    }  # fmt: skip
    return cam(prime - 10.0, follower=follower, program=program(10.0, unit="deg"), **more)


def sharp(ratio: float) -> Spec:
    """A radial cam whose pitch curve's least convex radius is this many roller radii of 20 mm."""
    s, rate, bend = cycloidal(20.0, 60.0)

    def excess(prime: float) -> float:
        x = prime + s
        curvature = (x * x + 2.0 * rate * rate - x * bend) / (x * x + rate * rate) ** 1.5
        return 1.0 / float(np.max(curvature)) - 20.0 * ratio

    prime = float(brentq(excess, 25.0, 400.0))
    return cam(prime - 20.0, 20.0, program=program(20.0, 60.0), limits=angles(80.0))


def roller(radius: float = 10.0, **closure: Any) -> Spec:
    return {
        "kind": "translating_roller", "roller_radius_mm": radius, "offset_mm": 0.0,
        "closure": closure,
    }  # fmt: skip


RISE_MEANT = [{"kind": "pressure_angle", "rise_deg": 80.0}]
GROOVE = roller(2.0, kind="groove")
RING = roller(kind="force", contact="inside")


def jamming(coefficient: float) -> Spec:
    """A guide of no overhang; at 45° it locks from a friction of 1 on."""
    return steep(45.0, load={**slide(), "friction": {"coefficient": coefficient}})


def floating(reserve: float) -> Spec:
    """A spring without rate that holds to so many times the speed."""
    peak = 2.0 * pi * LIFT / RISE**2 * (10.0 * pi) ** 2 * 1e-3  # m/s² of the cycloidal at 300 rpm
    return cam(70.0, speed_rpm=300.0, load=slide(2.0, 0.0, 2.0 * peak * reserve**2))


def pressed(pressure: float, **contact: Any) -> Spec:
    """All but a circle of 70 mm under a roller of 10 mm, pressed so hard [MPa]; steel, by Hertz."""
    line, elastic = 5.0, 206e3 / (1.0 - 0.3**2)  # mm, MPa
    force = pressure**2 * pi * line * (2.0 / elastic) / (1.0 / 70.0 + 1.0 / 10.0)
    load = {**slide(0.0, 0.0, force), "contact": {"width_mm": line, **contact}}
    return cam(70.0, load=load, shaft_diameter_mm=40.0, program=program(0.001, 160.0))


CERAMIC = {"elastic_modulus_mpa": 310e3, "poisson_ratio": 0.3}
EDGES: list[tuple[str, Spec, str | None]] = [
    ("jumps", harmonic(0.97), "note"), ("jumps", harmonic(0.99), "caution"),
    ("jumps", line(0.0099), "note"), ("jumps", line(0.0101), "caution"),
    ("jumps", line(0.099), "caution"), ("jumps", line(0.101), "stop"),
    ("spring_solid", solid(0.999), "stop"), ("spring_solid", solid(1.001), "caution"),
    ("spring_solid", solid(1.099), "caution"), ("spring_solid", solid(1.101), "note"),
    ("spring_solid", solid(1.149), "note"), ("spring_solid", solid(1.151), None),
    ("contact_pressure", pressed(1499.0), None),
    ("contact_pressure", pressed(1501.0), "note"), ("contact_pressure", pressed(3999.0), "note"),
    ("contact_pressure", pressed(4001.0), "stop"),
    ("contact_pressure", pressed(4500.0, cam=CERAMIC), "stop"),
    ("contact_pressure", pressed(4500.0, cam=CERAMIC, follower=CERAMIC), None),
    ("contact_pressure", pressed(500.0) | {"body": {"thickness_mm": 4.99}}, "caution"),
    ("contact_pressure", pressed(500.0) | {"body": {"thickness_mm": 5.0}}, None),
    ("knife_edge", cam(70.0, 0.001), None), ("knife_edge", cam(70.0, 0.0), "caution"),
    ("knife_edge", faced(20.0, 140.0, 20.0), None),
    ("period_ratio", ringing(2.99), "note"), ("period_ratio", ringing(3.01), None),
    ("roller_speed", rolling(0.99e5), None), ("roller_speed", rolling(1.01e5), "note"),
    ("roller_speed", rolling(2.49e5), "note"), ("roller_speed", rolling(2.51e5), "caution"),
    ("unit_suspicion", stroke(0.0099), "caution"), ("unit_suspicion", stroke(0.0101), None),
    ("unit_suspicion", cam(None, limits=angles(1.59)), "caution"),
    ("unit_suspicion", cam(None, limits=angles(1.61)), None),
    ("hub", room(0.0999), "stop"), ("hub", room(0.1001), "caution"),
    ("hub", room(0.1999), "caution"), ("hub", room(0.2001), None),
    ("hub", torque((80.0 - 6.35) / 1.75 * 0.999), None),
    ("hub", torque((80.0 - 6.35) / 1.75 * 1.001), "note"),
    ("hub", torque((80.0 - 6.35) / 1.75 * 1.001, body=CAST_IRON), "caution"),
    ("hub", torque((80.0 / 0.9 - 6.35) / 1.75 * 0.999), "note"),
    ("hub", torque((80.0 / 0.9 - 6.35) / 1.75 * 1.001), "caution"),
    ("hub", torque(79.9), "caution"), ("hub", torque(80.1), "stop"),
    ("hub", walled(0.999), "caution"), ("hub", walled(1.001), None),
    ("pressure_angle", steep(29.99), None), ("pressure_angle", steep(30.01), "note"),
    ("pressure_angle", steep(37.9), "note"), ("pressure_angle", steep(38.1), "caution"),
    ("pressure_angle", steep(44.9, limits=RISE_MEANT), None),
    ("pressure_angle", steep(45.1, limits=RISE_MEANT), "note"),
    ("pressure_angle", steep(69.9, limits=RISE_MEANT), "note"),
    ("pressure_angle", steep(70.1, limits=RISE_MEANT), "caution"),
    ("pressure_angle", steep(40.0, limits=RISE_MEANT, follower=GROOVE), "caution"),
    ("hub", cam(110.0, follower=RING, load=slide(0.0, 0.0, 1e7)), None),
    ("spring_solid", cam(110.0, follower=RING, load=slide(0.1, 5.0, 250.0, solid_mm=58.0)), None),
    ("spring_solid", cam(110.0, follower=RING, load=slide(0.1, 5.0, 250.0, solid_mm=57.0)), "note"),
    ("lift_to_base_radius", faced(20.0, 140.0, 2.0), None),
    ("lift_to_base_radius",
     cam(None, program=program(20.0, 120.0), limits=[{"kind": "profile_radius", "min_mm": 5.0}]),
     "note"),
    ("contact_force", jamming(0.9), None), ("contact_force", jamming(1.1), "stop"),
    ("pressure_angle", steep(69.9), "caution"), ("pressure_angle", steep(70.1), "stop"),
    ("pressure_angle", in_line(89.2), "caution"), ("pressure_angle", in_line(89.4), "stop"),
    ("pressure_angle", in_line(89.4, limits=angles(89.9)), None),
    ("sharp_nose", sharp(2.001), None), ("sharp_nose", sharp(1.999), "note"),
    ("sharp_nose", sharp(1.251), "note"), ("sharp_nose", sharp(1.249), "caution"),
    ("sharp_nose", sharp(1.011), "caution"), ("sharp_nose", sharp(1.009), "stop"),
    ("contact_force", floating(0.999), "stop"), ("contact_force", floating(1.001), "note"),
    ("contact_force", floating(1.094), "note"), ("contact_force", floating(1.097), None),
]  # fmt: skip


@pytest.mark.parametrize(("code", "body", "severity"), EDGES)
def test_a_rule_speaks_from_its_threshold_on(code: str, body: Spec, severity: str | None) -> None:
    design = synthesise(DesignSpec.model_validate(body))
    said = [one.severity for one in design.warnings if one.code == code]
    assert said[:1] == ([] if severity is None else [severity])


@pytest.fixture(scope="module")
def calm() -> Design:
    """A chosen law of which nothing is to be said."""
    design = synthesise(DesignSpec.model_validate(cam(70.0, program=program(law="spline"))))
    assert design.warnings == []
    return design


@pytest.mark.parametrize(
    ("acceleration", "jerk", "limited", "severity"),
    [
        (1.99, 3.99, False, "none"), (2.01, 1.0, False, "caution"), (1.0, 4.01, False, "caution"),
        (2.01, 1.0, True, "none"), (1.0, 4.01, True, "note"), (1.0, 10.1, True, "caution"),
    ],
)  # fmt: skip
def test_peaks_are_compared_with_the_reference_law(
    calm: Design, acceleration: float, jerk: float, limited: bool, severity: str
) -> None:
    assert calm.motion_summary is not None
    moves = []
    for move in calm.motion_summary.moves:
        assert move.reference is not None
        usual = move.reference.coefficients
        own = {"Ca": acceleration * usual.Ca, "Cj": jerk * usual.Cj}
        coefficients = move.coefficients.model_copy(update=own)
        moves.append(move.model_copy(update={"coefficients": coefficients}))
    summary = calm.motion_summary.model_copy(update={"moves": moves})
    limits = [Acceleration(max_mm_per_s2=1e6)] if limited else []
    spec = calm.spec.model_copy(update={"limits": limits})
    rough = calm.model_copy(update={"motion_summary": summary, "spec": spec})
    assert with_warnings(rough).severity == severity


NEEDS_JERK = IN_PROOF.format("jerk")


@pytest.mark.parametrize(
    ("status", "gap", "proof", "valid_for", "said"),
    [
        ("feasible", 0.01, "auto", NEEDS_JERK, ["limits/jerk"]),
        ("feasible", 0.01, "auto", IN_PROOF.format("jerk or acceleration"), ["limits/jerk"]),
        ("feasible", 0.01, "auto", "all laws", []),
        ("feasible", 0.0009, "auto", NEEDS_JERK, []),
        ("feasible", 0.01, "quick", NEEDS_JERK, []),
        ("optimal", 0.01, "auto", NEEDS_JERK, []),
    ],
)
def test_a_gap_is_told_where_something_closes_it(
    calm: Design, status: str, gap: float, proof: str, valid_for: str, said: list[str]
) -> None:
    certificate = calm.certificate.model_copy(update={"gap": gap, "bound_valid_for": valid_for})
    spec = calm.spec.model_copy(update={"proof": proof})
    changes = {"status": status, "certificate": certificate, "spec": spec}
    judged = with_warnings(calm.model_copy(update=changes))
    assert [one.field for one in judged.warnings if one.code == "gap_open"] == said


@pytest.mark.usefixtures("unmended")
def test_of_undercut_the_certificate_speaks_and_no_rule() -> None:
    given = cam(20.0, 20.0, program=program(30.0, 40.0))
    found = analyse(DesignSpec.model_validate(given))
    assert "profile_radius" in found.violated
    assert "sharp_nose" not in {one.code for one in found.warnings}
