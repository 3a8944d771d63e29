"""Random specs with a load, from fixed seeds: sensible machines, their limits tight and open.

Every force is a share of the inertia force of the sharpest move, so that springs, contact limits
and torque limits bind in some specs, are out of reach in others, and matter to nobody in the rest.
"""

from __future__ import annotations

from math import pi, radians, sqrt, tan
from typing import Any

import numpy as np

from tests.hard.random_specs import Random, Spec, a_range, between, chance, pick, rate, spread

SEED = 20_271_123
COUNT = 500
STEEL = 206e3 / (1.0 - 0.3**2)  # E/(1 − ν²) of steel [MPa]
SHAPES = [
    ["rise", "dwell", "return", "dwell"],
    ["rise", "return", "dwell"],
    ["rise", "dwell", "return", "dwell"],
    ["rise", "return"],
    ["dwell", "rise", "dwell", "return"],
    ["return", "dwell", "rise"],
    ["rise", "dwell", "rise", "return", "dwell"],
]
NAMED = ["cycloidal", "modified_sine", "modified_trapezoid", "polynomial_4_5_6_7"]


def a_program(r: Random, lift: float, unit: str) -> list[Spec]:
    """Rises that add up to the lift and one return, on splines but for now and then a law."""
    kinds = list(pick(r, SHAPES))
    weights = np.array([between(r, 0.6, 1.6) for _ in kinds])
    angles = np.round(360.0 * weights / weights.sum(), 2)
    angles[int(np.argmax(angles))] += 360.0 - angles.sum()
    rises = kinds.count("rise")
    low = 1.0 if rises == 1 else between(r, 0.3, 0.7)
    lifts = [lift * low, lift * (1.0 - low)]
    named = chance(r, 0.1)
    found = []
    for kind, angle in zip(kinds, angles, strict=True):
        segment: Spec = {"kind": kind, "angle_deg": round(float(angle), 6)}
        if kind != "dwell":
            segment[f"lift_{unit}"] = lifts.pop(0) if kind == "rise" else lift
            segment["law"] = {"kind": "spline"}
            if named and chance(r, 0.5):
                segment["law"] = {"kind": pick(r, NAMED)}
            elif chance(r, 0.1):
                segment["law"]["smoothness"] = int(r.integers(2, 5))
        found.append(segment)
    return found


# -- followers: each with a length and an estimate of the least base radius [mm] -----------------


def slide_roller(r: Random, lift: float) -> tuple[Spec, float]:
    roller = lift * spread(r, 0.2, 1.5)
    found: Spec = {"kind": "translating_roller", "roller_radius_mm": roller}
    if chance(r, 0.4):
        e = lift * between(r, -0.4, 0.4)
        found["offset_mm"] = pick(r, [e, {"min": min(e, -e), "max": max(e, -e)}])
    if chance(r, 0.2):
        found["closure"] = pick(
            r,
            [
                {"kind": "groove", "clearance_mm": 0.005 * roller},
                {"kind": "conjugate", "roller_radius_mm": roller, "offset_mm": 0.0},
                {"kind": "force", "contact": "inside", "rim_mm": 0.4 * roller},
            ],
        )
    return found, lift


def slide_face(r: Random, lift: float) -> tuple[Spec, float]:
    found: Spec = {"kind": "translating_flat_face"}
    if chance(r, 0.25):
        found["tilt_deg"] = between(r, -20.0, 20.0)
    return found, lift


def arm_roller(r: Random, swing: float) -> tuple[Spec, float]:
    arm = spread(r, 40.0, 200.0)
    roller = arm * between(r, 0.08, 0.25)
    d = arm * between(r, 1.0, 1.5)
    found: Spec = {
        "kind": "oscillating_roller",
        "arm_mm": arm,
        "roller_radius_mm": roller,
        "sense": pick(r, ["opposite", "same"]),
        "centre_distance_mm": pick(r, [d, d, {"min": 0.95 * d, "max": 1.2 * d}, None]),
    }
    if chance(r, 0.15):
        found["closure"] = {"kind": "groove", "clearance_mm": 0.005 * roller}
    return found, arm * radians(swing)


def arm_face(r: Random, swing: float) -> tuple[Spec, float]:
    d = spread(r, 60.0, 250.0)
    found: Spec = {
        "kind": "oscillating_flat_face",
        "face_offset_mm": d * between(r, -0.05, 0.05),
        "centre_distance_mm": d,
        "sense": pick(r, ["opposite", "same"]),
    }
    return found, d * radians(swing)


FOLLOWERS = [
    (slide_roller, "mm", 0.5),
    (slide_face, "mm", 0.15),
    (arm_roller, "deg", 0.25),
    (arm_face, "deg", 0.1),
]


def least_radius(follower: Spec, stroke: float, angle: float) -> float:
    """A rough guess of the least base radius at 35° of pressure angle, as tight sizes go by it."""
    if "flat_face" in follower["kind"]:
        return 3.0 * stroke / angle**2
    prime = max(1.8 * stroke / angle / tan(radians(35.0)) - 0.5 * stroke, 0.2 * stroke)
    distance = follower.get("centre_distance_mm")
    if follower["kind"] == "oscillating_roller" and isinstance(distance, float):
        prime = max(prime, 1.05 * abs(distance - follower["arm_mm"]))
    return max(prime - follower["roller_radius_mm"], 0.1 * stroke)


# -- loads ---------------------------------------------------------------------------------------


def a_process(r: Random, force: float, *, steady: bool) -> list[tuple[float, float]]:
    """Cam angle and force: a constant, straight lines, or a jump."""
    if steady:
        return [(0.0, force)]
    first, second = sorted(round(between(r, 5.0, 355.0), 1) for _ in range(2))
    high, low = force * between(r, 0.1, 1.0), force * between(r, 0.0, 0.1)
    return list(
        pick(
            r,
            [
                [(0.0, high)],
                [(first, low), (second, high)],
                [(first, low), (first, high), (second, high), (second, low)],
            ],
        )
    )


def a_spring(r: Random, names: tuple[str, str], values: tuple[float, float]) -> Spec:
    """Given, but for one in ten that is left free in part."""
    spring: Spec = dict(zip(names, values, strict=True))
    if chance(r, 0.1):
        name = pick(r, list(names))
        spring[name] = pick(r, [{"min": 0.2 * spring[name], "max": 3.0 * spring[name]}, None])
        if spring[name] is None:
            del spring[name]
    return spring


def a_load(
    r: Random,
    follower: Spec,
    unit: str,
    lift: float,
    segments: list[Spec],
    speed: float,
    *,
    steady: bool,
) -> tuple[Spec, float, float]:
    """The load, its largest drive and its largest torque on the shaft, about [N or N m, N m].

    Of an arm mass is a moment of inertia and force is a moment; the displacement is in rad.
    """
    omega, stroke = speed * pi / 30.0, lift if unit == "mm" else radians(lift)
    sharpest = max(
        segment[f"lift_{unit}"] / lift / radians(segment["angle_deg"]) ** 2
        for segment in segments
        if segment["kind"] != "dwell"
    )
    metres = stroke * 1e-3 if unit == "mm" else stroke
    mass = spread(r, 0.2, 8.0) if unit == "mm" else spread(r, 0.002, 0.2)
    inertia = 6.0 * mass * metres * sharpest * omega**2
    preload, stiff = inertia * spread(r, 0.05, 5.0), inertia / stroke * spread(r, 0.05, 5.0)
    push = 0.0
    load: Spec = {"kind": "slide", "moving_mass_kg": mass}
    names = ("rate_n_per_mm", "preload_n")
    angle, force, damping = "angle_deg", "force_n", "damping_n_s_per_m"
    if unit == "deg":
        load = {"kind": "arm", "moment_of_inertia_kg_m2": mass}
        names = ("rate_n_m_per_rad", "preload_n_m")
        force, damping = "moment_n_m", "damping_n_m_s_per_rad"
    closure = follower.get("closure", {})
    both_ways = closure.get("kind") in ("groove", "conjugate")
    if not both_ways or chance(r, 0.5):
        load["spring"] = a_spring(r, names, (stiff, preload))
    if chance(r, 0.25):
        load[damping] = inertia / (metres * omega) * spread(r, 0.005, 0.3)
    if chance(r, 0.25):
        push = inertia * spread(r, 0.1, 2.0)
        load["process"] = [
            {angle: at, force: value} for at, value in a_process(r, push, steady=steady)
        ]
    if unit == "mm" and chance(r, 0.25):
        load["rise_from_vertical_deg"] = pick(r, [0.0, 30.0, 90.0, 180.0])
    if chance(r, 0.1):
        load["speeds"] = {"min_rpm": 0.3 * speed, "max_rpm": 1.1 * speed}
    if follower["kind"] == "translating_roller" and not closure and chance(r, 0.2):
        load["friction"] = {"coefficient": between(r, 0.02, 0.15)}
        if chance(r, 0.5):
            load["friction"] |= {"overhang_mm": 1.5 * lift, "bearing_length_mm": 2.0 * lift}
    load["contact"] = {"width_mm": spread(r, 5.0, 40.0)}
    if "roller" in follower["kind"] and chance(r, 0.2):
        load["bearing"] = {"dynamic_rating_n": 1e4}
    largest = inertia + preload + stiff * stroke + push
    torque = largest * metres * 1.8 * sqrt(sharpest)
    return load, largest, torque


def force_limits(
    r: Random, follower: Spec, unit: str, largest: float, torque: float, radius: float, load: Spec
) -> list[Spec]:
    """Limits on forces, from well below what such a machine has to well above."""
    lever = follower.get("arm_mm") or follower.get("centre_distance_mm") or 1e3
    force = largest if unit == "mm" else largest * 1e3 / float(lever)
    found: list[Spec] = []
    both_ways = follower.get("closure", {}).get("kind") in ("groove", "conjugate")
    if chance(r, 0.6):
        limit: Spec = {"kind": "contact_force"}
        if not both_ways and chance(r, 0.75):
            limit["min_n"] = pick(r, [0.0, 0.0, 0.02 * force])
        if len(limit) == 1 or chance(r, 0.25):
            limit["max_n"] = force * spread(r, 0.5, 3.0)
        found.append(limit)
    if chance(r, 0.4):
        curvature = 1.0 / max(radius, 1.0) + 1.0 / follower.get("roller_radius_mm", 1e9)
        width = load["contact"]["width_mm"]
        pressure = sqrt(force * curvature * STEEL / (2.0 * pi * width))
        found.append({"kind": "hertz_pressure", "max_mpa": pressure * spread(r, 0.5, 2.0)})
    if chance(r, 0.25):
        found.append({"kind": "camshaft_torque", "max_n_m": torque * spread(r, 0.3, 3.0)})
    return found


# -- the whole -----------------------------------------------------------------------------------


def an_objective(r: Random, follower: Spec) -> Any:
    if chance(r, 0.65):
        return {"kind": "base_radius"}
    one = pick(r, ["peak_drive_force", "peak_drive_force", "peak_acceleration", "peak_jerk",
                   "rms_acceleration", "peak_pressure_angle"])  # fmt: skip
    if one == "peak_pressure_angle":
        face = follower["kind"] == "translating_flat_face"
        return [{"kind": "base_radius"}, {"kind": "peak_jerk" if face else one}]
    return pick(r, [{"kind": one}, [{"kind": "base_radius"}, {"kind": one}]])


def loaded_spec(number: int) -> Spec:
    """The loaded spec of a number, the same at every call."""
    r = np.random.default_rng([SEED, number])
    shares = np.array([share for *_, share in FOLLOWERS])
    make, unit, _ = FOLLOWERS[int(r.choice(len(FOLLOWERS), p=shares / shares.sum()))]
    lift = spread(r, 5.0, 50.0) if unit == "mm" else between(r, 8.0, 35.0)
    follower, stroke = make(r, lift)
    segments = a_program(r, lift, unit)
    speed = spread(r, 30.0, 600.0)
    moves = [segment for segment in segments if segment["kind"] != "dwell"]
    radius = least_radius(follower, stroke, min(radians(s["angle_deg"]) for s in moves))
    objective = an_objective(r, follower)
    steady = "peak_drive_force" in str(objective)
    load, largest, torque = a_load(r, follower, unit, lift, segments, speed, steady=steady)
    limits = force_limits(r, follower, unit, largest, torque, radius, load)
    if follower["kind"] == "translating_flat_face":
        limits.append({"kind": "profile_radius", "min_mm": 0.5 * radius * between(r, 0.1, 1.0)})
    else:
        ends = {name: round(between(r, 25.0, 45.0), 1) for name in ("rise_deg", "return_deg")}
        limits.append({"kind": "pressure_angle", **ends})
    thorough = chance(r, 0.4)
    if thorough or chance(r, 0.8):
        cap = rate(r, segments, unit, 3, speed, 34.0)
        limits.append({"kind": "jerk", f"max_{unit}_per_s3": cap})
    if chance(r, 0.25):
        cap = rate(r, segments, unit, 2, speed, 4.4)
        limits.append({"kind": "acceleration", f"max_{unit}_per_s2": cap})
    if "roller" in follower["kind"] and chance(r, 0.25):
        limits.append({"kind": "profile_radius", "min_mm": 0.5 * radius * between(r, 0.1, 1.0)})
    tight = radius * between(r, 0.8, 1.3)
    spec: Spec = {
        "name": f"loaded {number}",
        "speed_rpm": round(speed, 2),
        "rotation": pick(r, ["ccw", "cw"]),
        "program": segments,
        "follower": follower,
        "load": load,
        "limits": limits,
        "objective": objective,
        "base_radius_mm": pick(
            r, [None, None, None, {"max": tight}, {"max": tight}, a_range(r, tight, 4.0 * tight)]
        ),
        "tolerance": pick(r, [0.005, 0.02, 0.05]),
        "proof": "thorough" if thorough else "quick",
        "time_budget_s": 3.0 if thorough else 1.0,
    }
    return spec
