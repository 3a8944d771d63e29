"""Hard cases by name: what is asked, what must come out, and why it is hard.

``expect`` is one of
    optimal              certified, and the gap within the tolerance
    certified            certified, optimal or only feasible
    refused: <limit>     infeasible, and the conflict or the certificate names the limit
    error: <type>        a spec that makes no sense
    late                 the time budget ends first
``value`` is the exact value of the first objective where it is known, met within ``tolerance``.
A new family joins by rows at the end.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, radians, sqrt, tan
from typing import Any

Spec = dict[str, Any]

OMEGA = 10.0
RPM = OMEGA * 30.0 / pi
H, RISE, DWELL, RETURN = 27.3, 61.0, 31.0, 67.0
BETA = radians(RISE)
FREE: Spec = {"kind": "spline"}
CYCLOIDAL: Spec = {"kind": "cycloidal"}
ROLLER: Spec = {"kind": "translating_roller", "roller_radius_mm": 9.0}
CENTRAL = ROLLER | {"offset_mm": 0.0}
EDGE: Spec = {"kind": "translating_roller", "roller_radius_mm": 0.0, "offset_mm": 0.0}
FACE: Spec = {"kind": "translating_flat_face"}
ANGLES: Spec = {"kind": "pressure_angle", "rise_deg": 30.0, "return_deg": 45.0}


@dataclass(frozen=True)
class Case:
    """A spec, what must come out of it, and why that is not easy."""

    expect: str
    why: str
    spec: Spec
    value: float | None = None


def moves(
    lift: float = H, rise: float = RISE, dwell: float = DWELL, back: float = RETURN,
    law: Spec = FREE, law_back: Spec | None = None,
) -> list[Spec]:  # fmt: skip
    """Rise, dwell, return, dwell."""
    return [
        {"kind": "rise", "angle_deg": rise, "lift_mm": lift, "law": law},
        {"kind": "dwell", "angle_deg": dwell},
        {"kind": "return", "angle_deg": back, "lift_mm": lift, "law": law_back or law},
        {"kind": "dwell", "angle_deg": 360.0 - rise - dwell - back},
    ]


def steps(count: int, law: Spec, still: bool = False) -> list[Spec]:
    """Up in ``count`` steps and down in as many, of unequal lifts and angles."""
    weights = [1.0 + 0.3 * ((7 * i) % 5) for i in range(count)]
    share = 170.0 / sum(weights)
    each = 2 if still else 1
    found: list[Spec] = []
    for kind in ("rise", "return"):
        for weight in weights:
            angle = round(share * weight / each, 6)
            found.append({"kind": kind, "angle_deg": angle, "lift_mm": 1.7 * weight, "law": law})
            if still:
                found.append({"kind": "dwell", "angle_deg": angle})
    rest = 360.0 - sum(segment["angle_deg"] for segment in found)
    return [*found, {"kind": "dwell", "angle_deg": rest}]


def scene(*limits: Spec, **changes: Any) -> Spec:
    """P1's kind of motion with free laws at sizes that are nothing special."""
    return {
        "speed_rpm": RPM, "program": moves(), "follower": ROLLER, "limits": list(limits),
        "tolerance": 1e-2, "proof": "quick",
    } | changes  # fmt: skip


def jerk(factor: float, lift: float = H, beta: float = BETA, omega: float = OMEGA) -> Spec:
    """A cap of ``factor`` h/β³ of the rise."""
    return {"kind": "jerk", "max_mm_per_s3": factor * lift / beta**3 * omega**3}


def acceleration(factor: float, lift: float = H, beta: float = BETA) -> Spec:
    return {"kind": "acceleration", "max_mm_per_s2": factor * lift / beta**2 * OMEGA**2}


def velocity(factor: float, lift: float = H, beta: float = BETA) -> Spec:
    return {"kind": "velocity", "max_mm_per_s": factor * lift / beta * OMEGA}


def radius(least: float) -> Spec:
    return {"kind": "profile_radius", "min_mm": least}


def aim(kind: str) -> Spec:
    return {"kind": kind}


def fixed(base: float, **changes: Any) -> Spec:
    """The same with given laws and a given size."""
    return scene(program=moves(law=CYCLOIDAL), follower=CENTRAL, base_radius_mm=base) | changes


# where the peaks of given laws are known, limits can be made to touch them to the last digit
CYCLOIDAL_JERK = 4.0 * pi**2  # h/β³
CYCLOIDAL_ACCELERATION = 2.0 * pi  # h/β²
TOUCH = 1e-9
# a parabolic law's ρ = Rb + s + s'' is least just behind its middle, where s'' jumps to −4h/β²
PARABOLIC_FACE = H / 2.0 - 4.0 * H / BETA**2


LAWS: dict[str, Case] = {
    "rise of 1°": Case("certified", "scaled s''' is 1.9e5 times the lift",
        scene(ANGLES, jerk(48.0, 0.37, radians(1.0)), program=moves(0.37, 1.0, 13.1, 1.0))),
    "rise of 1°, law given": Case("certified", "tan α needs a base radius of 60 lifts",
        scene(ANGLES, program=moves(0.37, 1.0, 13.1, 1.0, CYCLOIDAL))),
    "jerk cap 1e-3 above the least": Case("optimal", "the motion is settled to 1e-3",
        scene(ANGLES, jerk(32.0 * 1.001, H), program=moves(back=RISE))),
    "jerk cap exactly the least": Case("optimal", "one law alone meets it",
        scene(ANGLES, jerk(32.0), program=moves(back=RISE))),
    "jerk cap 1e-9 above the least": Case("optimal", "no solver has room",
        scene(ANGLES, jerk(32.0 * (1 + TOUCH)), program=moves(back=RISE))),
    "jerk cap 1e-9 below the least": Case("refused: jerk", "infeasible by 1e-9",
        scene(ANGLES, jerk(32.0 * (1 - TOUCH)), program=moves(back=RISE))),
    "jerk cap 10 % below the least": Case("refused: jerk", "",
        scene(ANGLES, jerk(28.8), program=moves(back=RISE))),
    "jerk cap far above any use": Case("certified", "rows of 1e12 beside rows of 1",
        scene(ANGLES, jerk(1e9))),
    "least jerk": Case("optimal", "exactly 32 h/β³", scene(objective=aim("peak_jerk"),
        program=moves(back=RISE), base_radius_mm=300.0, follower=CENTRAL),
        32.0 * H / BETA**3 * OMEGA**3),
    "least rms jerk": Case("optimal", "the 3-4-5 law", scene(objective=aim("rms_jerk"),
        program=moves(back=RISE), base_radius_mm=300.0, follower=CENTRAL),
        sqrt(720.0 * 2.0 * BETA / (2.0 * pi)) * H / BETA**3 * OMEGA**3),
    "least acceleration under a jerk cap": Case("optimal", "5 h/β² at 50 h/β³",
        scene(jerk(50.0), objective=aim("peak_acceleration"), program=moves(back=RISE),
              base_radius_mm=300.0, follower=CENTRAL), 5.0 * H / BETA**2 * OMEGA**2),
    "least acceleration alone": Case("certified", "4 h/β² is not reached by any jerk",
        scene(objective=aim("peak_acceleration"), program=moves(back=RISE), base_radius_mm=300.0,
              follower=CENTRAL)),
    "acceleration cap below 4 h/β²": Case("refused: acceleration", "",
        scene(ANGLES, acceleration(3.9), program=moves(back=RISE))),
    "acceleration cap alone": Case("certified", "the jerk is unbounded",
        scene(ANGLES, acceleration(5.0), program=moves(back=RISE))),
    "velocity cap alone": Case("certified", "neither jerk nor acceleration is bounded",
        scene(ANGLES, velocity(1.3), program=moves(back=RISE), tolerance=5e-2)),
    "velocity cap below 1 h/β": Case("refused: velocity", "no law is slower than a straight line",
        scene(ANGLES, velocity(0.98), program=moves(back=RISE))),
    "velocity cap exactly h/β": Case("refused: velocity", "only a straight line, which is not C2",
        scene(ANGLES, velocity(1.0), program=moves(back=RISE))),
    "three caps at once": Case("optimal", "v, a and j all bind",
        scene(ANGLES, velocity(1.7), acceleration(5.5), jerk(60.0), program=moves(back=RISE))),
    "overshoot allowed": Case("certified", "the law need not be monotone",
        scene(ANGLES, jerk(48.0), program=moves(law={"kind": "spline", "overshoot": True}))),
    "C3": Case("certified", "quartic", scene(ANGLES, jerk(60.0),
        program=moves(law={"kind": "spline", "smoothness": 3}))),
    "C4": Case("certified", "quintic", scene(ANGLES, jerk(60.0),
        program=moves(law={"kind": "spline", "smoothness": 4}))),
    "rise and return without dwell": Case("certified", "velocity 0 at the turn, not acceleration",
        scene(ANGLES, jerk(48.0), program=moves(dwell=0.0))),
    "nothing but rise and return": Case("certified", "every joint moves", scene(ANGLES, program=[
        {"kind": "rise", "angle_deg": 161.0, "lift_mm": H, "law": FREE},
        {"kind": "return", "angle_deg": 199.0, "lift_mm": H, "law": FREE}])),
    "free rise, parabolic return": Case("certified", "a free law next to a jump",
        scene(ANGLES, program=moves(dwell=0.0, law_back={"kind": "parabolic"}))),
    "very short beside very long": Case("certified", "0.5° beside 300°", scene(program=[
        {"kind": "rise", "angle_deg": 0.5, "lift_mm": 0.01, "law": FREE},
        {"kind": "rise", "angle_deg": 150.0, "lift_mm": H, "law": FREE},
        {"kind": "return", "angle_deg": 200.0, "lift_mm": H + 0.01, "law": FREE},
        {"kind": "dwell", "angle_deg": 9.5}], base_radius_mm={"min": 0.1})),
    "20 segments, free": Case("certified", "ten joints in motion",
        scene(ANGLES, program=[*steps(9, FREE), {"kind": "dwell", "angle_deg": 0.0}],
              tolerance=1e-1)),
    "40 segments, given": Case("certified", "many small pieces",
        scene(ANGLES, program=steps(19, CYCLOIDAL), tolerance=5e-2)),
    "40 segments with dwells, free": Case("certified", "twenty laws at once",
        scene({"kind": "pressure_angle", "rise_deg": 60.0, "return_deg": 60.0},
              program=steps(9, FREE, True), tolerance=5e-2)),
    "hundreds of knots": Case("certified", "a tolerance of 1e-4",
        scene(ANGLES, jerk(48.0), tolerance=1e-4)),
    "dwell of 0° everywhere": Case("certified", "segments without extent", scene(ANGLES, program=[
        {"kind": "dwell", "angle_deg": 0.0}, *moves(dwell=0.0), {"kind": "dwell", "angle_deg": 0.0},
        {"kind": "dwell", "angle_deg": 0.0}])),
    "acceleration cap on a law that jumps": Case("certified", "finite on both sides of a jump",
        scene(ANGLES, acceleration(4.0 * (1 + TOUCH)),
              program=moves(back=RISE, law={"kind": "parabolic"}))),
    "acceleration cap 1e-9 below a parabolic law's": Case("refused: acceleration", "by 1e-9",
        scene(ANGLES, acceleration(4.0 * (1 - TOUCH)),
              program=moves(back=RISE, law={"kind": "parabolic"}))),
    "jerk cap on a parabolic law": Case("refused: jerk", "its jerk is infinite",
        scene(jerk(1e6), program=moves(law={"kind": "parabolic"}))),
    "jerk cap on a harmonic law": Case("refused: jerk", "infinite at its ends only",
        scene(jerk(1e6), program=moves(law={"kind": "simple_harmonic"}))),
    "acceleration cap on constant velocity": Case("refused: acceleration", "v jumps",
        scene(acceleration(1e6), program=moves(law={"kind": "constant_velocity"}),
              follower=EDGE)),
    "jerk cap exactly a given law's": Case("refused: jerk", "margin 0 is not above the enclosure",
        fixed(60.0, limits=[jerk(CYCLOIDAL_JERK)], program=moves(back=RISE, law=CYCLOIDAL))),
    "jerk cap 1e-9 above a given law's": Case("optimal", "1e-9 suffices for a proof",
        fixed(60.0, limits=[jerk(CYCLOIDAL_JERK * (1 + TOUCH))],
              program=moves(back=RISE, law=CYCLOIDAL))),
    "jerk cap 1e-9 below a given law's": Case("refused: jerk", "by 1e-9",
        fixed(60.0, limits=[jerk(CYCLOIDAL_JERK * (1 - TOUCH))],
              program=moves(back=RISE, law=CYCLOIDAL))),
    "the same limit three times": Case("optimal", "dependent rows",
        scene(ANGLES, ANGLES, ANGLES, jerk(48.0), jerk(48.0))),
    "two pressure angles": Case("optimal", "the sharper one counts",
        scene(ANGLES, {"kind": "pressure_angle", "rise_deg": 25.0}, jerk(48.0))),
}  # fmt: skip


def dwell_base(deg: float, e: float, roller: float) -> float:
    """Base radius whose dwell just keeps a pressure angle: |e| = tan α s0."""
    s0 = abs(e) / tan(radians(deg))
    return sqrt(e * e + s0 * s0) - roller


SIZES: dict[str, Case] = {
    "lift a millionth of the base radius": Case("optimal", "s beside Rb has ten digits left",
        scene(objective=aim("peak_jerk"), program=moves(0.0000531, back=RISE),
              base_radius_mm=53.1, follower=CENTRAL), 32.0 * 0.0000531 / BETA**3 * OMEGA**3),
    "lift a millionth, given law": Case("optimal", "", fixed(53.1,
        program=moves(0.0000531, law=CYCLOIDAL), limits=[ANGLES])),
    "lift ten times the base radius": Case("optimal", "",
        scene(program=moves(173.0, 100.0, 30.0, 110.0, CYCLOIDAL), base_radius_mm=17.3,
              follower=EDGE,
              limits=[{"kind": "pressure_angle", "rise_deg": 75.0, "return_deg": 75.0}])),
    "lift ten times the base radius, steeper": Case("optimal", "",
        scene(program=moves(173.0, 60.0, 30.0, 60.0, CYCLOIDAL), base_radius_mm=17.3,
              follower=CENTRAL)),
    "3 µm": Case("optimal", "every length 1e-4 of usual",
        scene(ANGLES, jerk(48.0, 0.003), program=moves(0.003),
              follower={"kind": "translating_roller", "roller_radius_mm": 0.001})),
    "3 m": Case("optimal", "every length 100 times usual",
        scene(ANGLES, jerk(48.0, 3000.0), program=moves(3000.0),
              follower={"kind": "translating_roller", "roller_radius_mm": 1000.0})),
    "1e-3 rpm": Case("optimal", "jerk cap of 1e-12", scene(ANGLES,
        jerk(48.0, omega=1e-3 * pi / 30), speed_rpm=1e-3)),
    "1e6 rpm": Case("optimal", "jerk cap of 1e18", scene(ANGLES,
        jerk(48.0, omega=1e6 * pi / 30), speed_rpm=1e6)),
    "1°/80°": Case("optimal", "slopes 300 times apart", scene(
        {"kind": "pressure_angle", "rise_deg": 1.0, "return_deg": 80.0}, jerk(48.0))),
    "5°/70°, law given": Case("optimal", "the start of the rise binds too", scene(
        {"kind": "pressure_angle", "rise_deg": 5.0, "return_deg": 70.0},
        program=moves(law=CYCLOIDAL))),
    "89.9° on both sides": Case("certified", "slope 573: nearly no limit", scene(
        {"kind": "pressure_angle", "rise_deg": 89.9, "return_deg": 89.9}, jerk(48.0))),
    "0.01° on the rise": Case("certified", "a cam of 5000 lifts", scene(
        {"kind": "pressure_angle", "rise_deg": 0.01, "return_deg": 0.01},
        program=moves(law=CYCLOIDAL), follower=CENTRAL, base_radius_mm={"max": 1e7})),
    "offset nearly the prime radius": Case("optimal", "s0 a thousandth of Rp",
        fixed(38.0, follower=ROLLER | {"offset_mm": 46.99997},
              program=moves(10.0, law=CYCLOIDAL))),
    "offset nearly the prime radius, steep": Case("refused: profile radius", "s' passes e: a loop",
        fixed(38.0, follower=ROLLER | {"offset_mm": 46.99997})),
    "offset equal to the prime radius": Case("error: offset_beyond_prime_radius", "s0 = 0",
        fixed(38.0, follower=ROLLER | {"offset_mm": 47.0})),
    "offset fixed at its range's end": Case("optimal", "a range of one value", scene(ANGLES,
        jerk(48.0), follower=ROLLER | {"offset_mm": {"min": 7.0, "max": 7.0}})),
    "offset range away from the best": Case("optimal", "the bound binds", scene(ANGLES,
        jerk(48.0), follower=ROLLER | {"offset_mm": {"min": -20.0, "max": -12.0}})),
    "base radius as small as it gets": Case("certified", "nothing binds but undercut", scene(
        program=moves(law=CYCLOIDAL))),
    "dwell limit touches": Case("certified", "|e|/s0 = tan 20° exactly, 1e-9 more is asked",
        fixed(dwell_base(20.0 * (1 - 1e-9), 15.0, 9.0),
              follower=ROLLER | {"offset_mm": 15.0},
              limits=[{"kind": "pressure_angle", "dwell_deg": 20.0}])),
    "dwell limit touches from the wrong side": Case("refused: pressure angle dwell", "by 1e-8",
        fixed(dwell_base(20.0 * (1 + 1e-8), 15.0, 9.0),
              follower=ROLLER | {"offset_mm": 15.0},
              limits=[{"kind": "pressure_angle", "dwell_deg": 20.0}])),
    "outer radius just touching": Case("certified", "Rb + h to 1e-9",
        fixed(40.0, limits=[{"kind": "outer_radius", "max_mm": (40.0 + H) * (1 + TOUCH)}])),
    "outer radius 1e-9 too small": Case("refused: outer radius", "by 1e-9",
        fixed(40.0, limits=[{"kind": "outer_radius", "max_mm": (40.0 + H) * (1 - TOUCH)}])),
    "outer radius and pressure angle exclude each other": Case("refused: ", "two limits at odds",
        scene(ANGLES, jerk(48.0), {"kind": "outer_radius", "max_mm": 45.0})),
    "base radius below a limit's need": Case("refused: pressure angle", "fixed too small",
        scene(ANGLES, jerk(48.0), base_radius_mm=15.0, follower=CENTRAL)),
    "knife edge": Case("optimal", "no roller, no undercut", scene(ANGLES, jerk(48.0),
        follower={"kind": "translating_roller", "roller_radius_mm": 0.0})),
    "roller larger than the cam": Case("certified", "Rr of ten lifts", scene(ANGLES, jerk(48.0),
        follower={"kind": "translating_roller", "roller_radius_mm": 273.0})),
    "cusp: profile radius 0 on the dwell": Case("certified", "nearly no base circle",
        fixed(1e-3, program=moves(0.5, 165.0, 10.0, 170.0, CYCLOIDAL))),
    "dwell as sharp as asked": Case("certified", "Rb = least radius, less 1e-9", fixed(
        40.0, limits=[radius(40.0 * (1 - TOUCH))], program=moves(0.5, 165.0, 10.0, 170.0,
        CYCLOIDAL))),
    "dwell 1e-9 sharper than asked": Case("refused: profile radius", "Rb < least radius by 1e-9",
        fixed(40.0, limits=[radius(40.0 * (1 + TOUCH))], program=moves(0.5, 165.0, 10.0, 170.0,
              CYCLOIDAL))),
    "curvature binds": Case("certified", "not convex", scene(ANGLES, jerk(48.0), radius(12.0))),
    "radius asked for is that of the cam": Case("certified", "all but the nose is a circle",
        scene(jerk(64.0), radius(60.0), program=moves(3.0), follower=CENTRAL)),
    "cutter larger than any hollow": Case("certified", "the cam has to be convex", scene(
        ANGLES, {"kind": "cutter_radius", "radius_mm": 1e6}, program=moves(law=CYCLOIDAL),
        base_radius_mm={"max": 2000.0})),
    "cutter larger than any hollow, small cam": Case("refused: cutter radius", "", fixed(
        40.0, limits=[{"kind": "cutter_radius", "radius_mm": 500.0}])),
    "cutter as large as the roller": Case("optimal", "fits everywhere: no limit at all", scene(
        ANGLES, jerk(48.0), {"kind": "cutter_radius", "radius_mm": 9.0})),
    "cutter a hair larger than the roller": Case("certified", "1/(Rg − Rr) = 1e6", scene(
        ANGLES, jerk(48.0), {"kind": "cutter_radius", "radius_mm": 9.000001})),
    "constant velocity on a roller": Case("refused: profile radius", "an outward corner",
        fixed(60.0, program=moves(law={"kind": "constant_velocity"}))),
    "constant velocity on a knife edge": Case("optimal", "a corner is no undercut there",
        fixed(60.0, program=moves(law={"kind": "constant_velocity"}), follower=EDGE)),
}  # fmt: skip


def fixed_face(base: float, law: Spec, *limits: Spec) -> Spec:
    return scene(*limits, program=moves(law=law, back=RISE), follower=FACE, base_radius_mm=base)


BORDER = -PARABOLIC_FACE  # base radius at which a parabolic cam is pointed: ρ = 0

FACES: dict[str, Case] = {
    "undercut exactly on the border": Case("refused: profile radius", "ρ = 0: margin 0",
        fixed_face(BORDER, {"kind": "parabolic"})),
    "undercut 1e-9 inside": Case("optimal", "ρ = 4e-8 mm", fixed_face(BORDER * (1 + TOUCH),
        {"kind": "parabolic"})),
    "undercut by 1e-9": Case("refused: profile radius", "ρ = −4e-8 mm",
        fixed_face(BORDER * (1 - TOUCH), {"kind": "parabolic"})),
    "face sized for no undercut": Case("optimal", "the size is known in closed form",
        scene(program=moves(law={"kind": "parabolic"}, back=RISE), follower=FACE), BORDER),
    "face sized for a radius": Case("optimal", "the same and 7 mm",
        scene(radius(7.0), program=moves(law={"kind": "parabolic"}, back=RISE), follower=FACE),
        BORDER + 7.0),
    "face with free laws": Case("optimal", "jerk and radius bind", scene(jerk(48.0), radius(5.0),
        follower=FACE)),
    "face without any limit": Case("certified", "undercut alone", scene(follower=FACE)),
    "face too narrow": Case("refused: face width", "2 h/β is not reached by any law", scene(
        jerk(60.0), {"kind": "face_width", "width_mm": 2.0 * H / BETA}, follower=FACE)),
    "face just wide enough": Case("certified", "2 Cv h/β of a cycloidal law, 1e-9 more",
        scene({"kind": "face_width", "width_mm": 4.0 * H / BETA * (1 + TOUCH)},
              program=moves(law=CYCLOIDAL, back=RISE), follower=FACE)),
    "face 1e-9 too narrow": Case("refused: face width", "by 1e-9",
        scene({"kind": "face_width", "width_mm": 4.0 * H / BETA * (1 - TOUCH)},
              program=moves(law=CYCLOIDAL, back=RISE), follower=FACE)),
    "face on constant velocity": Case("refused: profile radius", "contact would leap",
        fixed_face(200.0, {"kind": "constant_velocity"})),
    "face, 3 µm": Case("optimal", "", scene(jerk(48.0, 0.003), radius(0.001),
        program=moves(0.003), follower=FACE)),
    "face, 1e6 rpm": Case("optimal", "", scene(jerk(48.0, omega=1e6 * pi / 30), radius(5.0),
        speed_rpm=1e6, follower=FACE)),
    "face, rise of 1°": Case("optimal", "Rb of 2 m", scene(jerk(48.0, 0.37, radians(1.0)),
        program=moves(0.37, 1.0, 13.1, 1.0), follower=FACE, base_radius_mm={"max": 1e5})),
    "face, rise of 1°, size left open": Case("refused: jerk", "open: up to 1e4 strokes",
        scene(jerk(48.0, 0.37, radians(1.0)), program=moves(0.37, 1.0, 13.1, 1.0),
              follower=FACE)),
    "face, outer radius just touching": Case("certified", "Rb + h", scene(
        {"kind": "outer_radius", "max_mm": (300.0 + H) * (1 + TOUCH)}, follower=FACE,
        base_radius_mm=300.0, program=moves(law=CYCLOIDAL))),
}  # fmt: skip


OBJECTIVES: dict[str, Case] = {
    "jerk first, then size": Case("certified", "the second has nothing but the tolerance", scene(
        ANGLES, objective=[aim("peak_jerk"), aim("base_radius")])),
    "size first, then acceleration": Case("certified", "", scene(
        ANGLES, jerk(60.0), objective=[aim("base_radius"), aim("rms_acceleration")])),
    "the same objective twice": Case("certified", "nothing is left to gain", scene(
        ANGLES, jerk(60.0), objective=[aim("base_radius"), aim("base_radius")])),
    "least pressure angle in a given size": Case("certified", "quasi-convex", scene(
        jerk(48.0), objective=aim("peak_pressure_angle"), base_radius_mm={"max": 45.0})),
    "least pressure angle of a cam without end": Case("error: no_best_pressure_angle", "",
        scene(jerk(48.0), objective=aim("peak_pressure_angle"))),
    "base radius fixed, base radius wanted": Case("certified", "nothing to choose but laws",
        scene(ANGLES, jerk(48.0), base_radius_mm=60.0)),
    "a budget of 1 ms": Case("late", "not even the first stage", scene(
        ANGLES, jerk(48.0), radius(12.0), tolerance=1e-6, time_budget_s=1e-3)),
    "a tolerance that cannot be met": Case("certified", "1e-6 with curvature", scene(
        ANGLES, jerk(48.0), radius(12.0), tolerance=1e-6, time_budget_s=60.0)),
}  # fmt: skip


def wrong(**changes: Any) -> Spec:
    return scene(ANGLES, **changes)


NONSENSE: dict[str, Case] = {
    "angles that leave a gap": Case("error: program_angles", "by 1e-5°",
        wrong(program=[*moves()[:3], {"kind": "dwell", "angle_deg": 360.0 - 159.0 - 1e-5}])),
    "angles within rounding": Case("certified", "1e-7° is forgiven", wrong(
        program=[*moves(law=CYCLOIDAL)[:3],
                 {"kind": "dwell", "angle_deg": 360.0 - 159.0 - 1e-7}])),
    "lifts that do not cancel": Case("error: program_lift", "by 1e-6", wrong(
        program=[moves()[0] | {"lift_mm": H * (1 + 1e-6)}, *moves()[1:]])),
    "lifts that cancel but for rounding": Case("certified", "by 1e-12", wrong(
        program=[moves(law=CYCLOIDAL)[0] | {"lift_mm": H * (1 + 1e-12)},
                 *moves(law=CYCLOIDAL)[1:]])),
    "no motion": Case("error: program_still", "", wrong(
        program=[{"kind": "dwell", "angle_deg": 360.0}])),
    "negative base radius": Case("error: base_radius_positive", "", wrong(base_radius_mm=-1.0)),
    "empty range": Case("error: range_empty", "",
        wrong(base_radius_mm={"min": 50.0, "max": 49.0})),
    "lift in degrees for a slide": Case("error: lift_does_not_suit", "", wrong(
        program=[{k if k != "lift_mm" else "lift_deg": v for k, v in segment.items()}
                 for segment in moves()])),
    "face width for a roller": Case("error: limit_does_not_suit", "", wrong(
        limits=[{"kind": "face_width", "width_mm": 40.0}])),
    "roller for a face": Case("error: extra_forbidden", "", wrong(
        follower=FACE | {"roller_radius_mm": 3.0}, limits=[])),
    "angle of 0° for a rise": Case("error: greater_than", "", wrong(
        program=[moves()[0] | {"angle_deg": 0.0}, *moves()[1:]])),
    "infinite lift": Case("error: finite_number", "", wrong(
        program=[moves()[0] | {"lift_mm": float("inf")}, *moves()[1:]])),
    "cap that is not a number": Case("error: finite_number", "", wrong(
        limits=[{"kind": "jerk", "max_mm_per_s3": float("nan")}])),
    "101 segments": Case("error: too_long", "", wrong(
        program=[{"kind": "dwell", "angle_deg": 360.0 / 101}] * 101)),
}  # fmt: skip


CASES: dict[str, Case] = LAWS | SIZES | FACES | OBJECTIVES | NONSENSE
