"""Random specs from fixed seeds: sensible ones and mad ones, over everything that can be asked.

A new follower, law, limit or segment joins by a row in the tables below.
"""

from __future__ import annotations

from math import pi, tau
from typing import Any

import numpy as np

SEED = 20_260_914
COUNT = 2_000
Spec = dict[str, Any]
Random = np.random.Generator

RESTS = [
    "parabolic", "simple_harmonic", "cycloidal", "modified_trapezoid", "modified_sine",
    "mcv50_makino", "cv50_half_sine", "cv50_modified_trapezoid", "scca_cv20", "cubic_2_3",
    "polynomial_3_4_5", "polynomial_4_5_6_7", "polynomial_5_6_7_8_9", "polynomial_6_7_8_9_10_11",
    "peisakh_11", "gutman_1_3", "freudenstein_1_3", "freudenstein_1_3_5", "cv50_parabolic",
    "cv50_haversine", "constant_velocity",
]  # fmt: skip
TURNS = ["double_harmonic", "polynomial_3_4_5_6", "kloomok_muffley_8"]


def between(r: Random, low: float, high: float) -> float:
    return float(r.uniform(low, high))


def spread(r: Random, low: float, high: float) -> float:
    """Even over orders of magnitude."""
    return float(np.exp(r.uniform(np.log(low), np.log(high))))


def chance(r: Random, share: float) -> bool:
    return bool(r.random() < share)


def pick(r: Random, items: list[Any]) -> Any:
    return items[int(r.integers(len(items)))]


# -- motion --------------------------------------------------------------------------------------


def a_law(r: Random, free: float) -> Spec:
    if chance(r, free):
        law: Spec = {"kind": "spline"}
        if chance(r, 0.3):
            law["smoothness"] = int(r.integers(2, 5))
        if chance(r, 0.15):
            law["overshoot"] = True
        return law
    if chance(r, 0.1):
        return {"kind": pick(r, TURNS), "turn": pick(r, ["top", "bottom"])}
    if chance(r, 0.1):
        parts = r.dirichlet([1.0, 1.0, 1.0, 0.5])
        b, c, d = (0.0 if part < 2e-3 else round(float(part), 6) for part in parts[:3])
        return {"kind": "scca", "b": b, "c": c, "d": d}
    law = {"kind": pick(r, RESTS)}
    if chance(r, 0.2):
        law["inflection"] = round(between(r, 0.05, 0.95), 3)
    return law


def shapes(r: Random) -> list[str]:
    """The kinds of the segments."""
    plain = [
        ["rise", "dwell", "return", "dwell"],
        ["rise", "return", "dwell"],
        ["rise", "return"],
        ["dwell", "rise", "dwell", "return"],
        ["rise", "rise", "return", "dwell"],
        ["rise", "dwell", "rise", "dwell", "return", "return", "dwell"],
        ["return", "dwell", "rise"],
    ]
    if chance(r, 0.9):
        return list(pick(r, plain[:1] if chance(r, 0.4) else plain))
    many: list[str] = []
    for _ in range(int(r.integers(2, 6))):
        many += ["rise", "dwell", "return"]
    return many


def program(r: Random, lift: float, unit: str, free: float) -> list[Spec]:
    kinds = shapes(r)
    still = kinds.index("dwell") if chance(r, 0.1) and "dwell" in kinds else -1
    weights = spread(r, 0.2, 3.0) * r.dirichlet([2.0] * len(kinds)) + 0.02
    if still >= 0:
        weights[still] = 0.0
    if chance(r, 0.05):
        weights[int(r.integers(len(kinds)))] = 0.002
    angles = np.round(360.0 * weights / weights.sum(), 3)
    angles[int(np.argmax(angles))] += 360.0 - angles.sum()
    ups = [i for i, kind in enumerate(kinds) if kind == "rise"]
    downs = [i for i, kind in enumerate(kinds) if kind == "return"]
    shares = {}
    for group in (ups, downs):
        parts = r.dirichlet([4.0] * len(group)) if len(group) > 1 else [1.0]
        shares |= {i: float(part) for i, part in zip(group, parts, strict=True)}
    every = a_law(r, free)
    same, found = chance(r, 0.5), []
    for i, kind in enumerate(kinds):
        segment: Spec = {"kind": kind, "angle_deg": round(float(angles[i]), 9)}
        if kind != "dwell":
            segment[f"lift_{unit}"] = max(lift * shares[i], 1e-6)
            segment["law"] = every if same else a_law(r, free)
            if chance(r, 0.03):
                gained = segment[f"lift_{unit}"] * (1.0 if kind == "rise" else -1.0)
                segment = {"kind": "constant_velocity", "angle_deg": segment["angle_deg"],
                           f"lift_{unit}": gained}  # fmt: skip
        found.append(segment)
    return found


# -- followers -----------------------------------------------------------------------------------


def a_range(r: Random, low: float, high: float) -> Any:
    """A number, a range, an open end, or nothing."""
    a, b = sorted((spread(r, low, high), spread(r, low, high)))
    return pick(r, [a, {"min": a, "max": b}, {"min": a}, {"max": b}, None, None])


def closure(r: Random, roller: float, second: Spec) -> Spec | None:
    if chance(r, 0.75):
        return None
    wide = {"kind": "groove", "clearance_mm": roller * between(r, 0.0, 0.02)}
    inside = {"kind": "force", "contact": "inside", "rim_mm": roller * between(r, 0.0, 0.5)}
    return pick(r, [wide, inside, second])


def translating_roller(r: Random, stroke: float) -> Spec:
    roller = pick(r, [0.0, *[stroke * spread(r, 0.02, 3.0) for _ in range(6)]])
    found: Spec = {"kind": "translating_roller", "roller_radius_mm": roller}
    if chance(r, 0.6):
        e = stroke * between(r, -1.0, 1.0)
        found["offset_mm"] = pick(r, [e, 0.0, {"min": min(e, 0.3 * e), "max": max(e, 0.3 * e)}])
    if (kept := closure(r, roller, {
        "kind": "conjugate", "roller_radius_mm": roller * between(r, 0.5, 1.5),
        "offset_mm": stroke * between(r, -0.2, 0.2),
        "distance_mm": pick(r, [None, stroke * spread(r, 3.0, 20.0)])})) is not None:  # fmt: skip
        found["closure"] = kept
    return found


def translating_flat_face(r: Random, stroke: float) -> Spec:
    found: Spec = {"kind": "translating_flat_face"}
    if chance(r, 0.3):
        found["tilt_deg"] = between(r, -30.0, 30.0)
    if chance(r, 0.3):
        found["offset_mm"] = stroke * between(r, -1.0, 1.0)
    return found


def oscillating_flat_face(r: Random, stroke: float) -> Spec:
    d = spread(r, 20.0, 300.0)
    return {
        "kind": "oscillating_flat_face",
        "face_offset_mm": pick(r, [0.0, d * between(r, -0.2, 0.2)]),
        "centre_distance_mm": pick(r, [d, d, d, {"min": 0.9 * d, "max": 1.3 * d}]),
        "sense": pick(r, ["opposite", "same"]), "pivot_direction_deg": between(r, -180.0, 180.0),
    }  # fmt: skip


def length_of(follower: Spec, lift: float) -> float:
    """A length that such a machine is known by [mm]."""
    distance = follower.get("centre_distance_mm")
    if isinstance(distance, dict):
        distance = distance["max"]
    return float(follower.get("arm_mm") or distance or lift)


def oscillating_roller(r: Random, stroke: float) -> Spec:
    """The stroke is the swing in degrees; lengths follow from an arm of any size."""
    arm = spread(r, 20.0, 300.0)
    roller = pick(r, [0.0, arm * between(r, 0.03, 0.4), arm * between(r, 0.03, 0.4)])
    found: Spec = {
        "kind": "oscillating_roller", "arm_mm": arm, "roller_radius_mm": roller,
        "sense": pick(r, ["opposite", "same"]), "pivot_direction_deg": between(r, -180.0, 180.0),
    }  # fmt: skip
    d = arm * between(r, 0.9, 2.0)
    found["centre_distance_mm"] = pick(r, [d, d, d, {"min": 0.9 * d, "max": 1.3 * d}, None])
    if (kept := closure(r, roller, {
        "kind": "conjugate", "roller_radius_mm": roller * between(r, 0.5, 1.5) + 1.0,
        "arm_mm": arm * between(r, 0.7, 1.3),
        "angle_deg": pick(r, [None, between(r, 60.0, 170.0)])})) is not None:  # fmt: skip
        found["closure"] = kept
    return found


FOLLOWERS = [
    (translating_roller, "mm", 0.55),
    (translating_flat_face, "mm", 0.20),
    (oscillating_roller, "deg", 0.17),
    (oscillating_flat_face, "deg", 0.08),
]


# -- limits --------------------------------------------------------------------------------------


def rate(r: Random, segments: list[Spec], unit: str, order: int, speed: float, law: float) -> float:
    """A cap of ``law``-ish times the largest lift/β^n: below the least possible now and then."""
    omega = speed * pi / 30.0
    sharpest = max(
        (abs(seg[f"lift_{unit}"]) / (seg["angle_deg"] / 360.0 * tau) ** order)
        for seg in segments if seg["kind"] != "dwell"
    )  # fmt: skip
    return float(sharpest * omega**order * law * spread(r, 1.0, 8.0))


def limits(r: Random, kind: str, segments: list[Spec], unit: str, speed: float,
           length: float, roller: float) -> list[Spec]:  # fmt: skip
    """A selection of what such a follower can be asked."""
    found: list[Spec] = []
    if kind != "translating_flat_face" and chance(r, 0.8):
        angles = {name: between(r, 15.0, 60.0) for name in ("rise_deg", "return_deg")}
        if chance(r, 0.1):
            angles = {"rise_deg": between(r, 0.5, 10.0), "return_deg": between(r, 60.0, 89.9)}
        if chance(r, 0.1):
            angles["dwell_deg"] = between(r, 10.0, 60.0)
        found.append({"kind": "pressure_angle", **angles})
    for name, order, least in (("velocity", 1, 1.2), ("acceleration", 2, 4.0), ("jerk", 3, 32.0)):
        if chance(r, {1: 0.12, 2: 0.25, 3: 0.45}[order]):
            cap = rate(r, segments, unit, order, speed, least)
            found.append({"kind": name, f"max_{unit}_per_s{order if order > 1 else ''}": cap})
    if chance(r, 0.3):
        found.append(
            {"kind": "profile_radius", "min_mm": pick(r, [0.0, length * spread(r, 0.01, 1.0)])}
        )
    if "roller" in kind and chance(r, 0.2):
        found.append(
            {"kind": "cutter_radius", "radius_mm": (roller or length) * spread(r, 0.5, 30.0)}
        )
    if chance(r, 0.15):
        found.append({"kind": "outer_radius", "max_mm": length * spread(r, 1.2, 12.0)})
    if kind == "translating_flat_face" and chance(r, 0.4):
        width = {"width_mm": length * spread(r, 0.8, 8.0)}
        one_side = {"right_mm": length * spread(r, 0.8, 8.0)}
        found.append({"kind": "face_width", **pick(r, [width, width, one_side])})
    if kind == "oscillating_flat_face" and chance(r, 0.4):
        found.append({"kind": "face_width", "far_mm": length * between(r, 0.9, 2.0)})
    if found and chance(r, 0.03):
        found.append(dict(found[0]))
    return found


def an_objective(r: Random) -> Any:
    others = ["peak_acceleration", "peak_jerk", "rms_acceleration", "rms_jerk",
              "peak_pressure_angle"]  # fmt: skip
    if chance(r, 0.6):
        return {"kind": "base_radius"}
    if chance(r, 0.75):
        return {"kind": pick(r, others)}
    return [{"kind": "base_radius"}, {"kind": pick(r, others)}]


# -- the whole -----------------------------------------------------------------------------------


def random_spec(number: int) -> Spec:
    """The spec of a number, the same at every call."""
    r = np.random.default_rng([SEED, number])
    shares = np.array([share for *_, share in FOLLOWERS])
    make, unit, _ = FOLLOWERS[int(r.choice(len(FOLLOWERS), p=shares / shares.sum()))]
    mad = chance(r, 0.12)
    if unit == "deg":
        lift = between(r, 3.0, 50.0) if not mad else spread(r, 1e-4, 170.0)
    else:
        lift = spread(r, 2.0, 80.0) if not mad else spread(r, 3e-3, 3e3)
    follower = make(r, lift)
    free = pick(r, [0.0, 0.0, 0.0, 1.0, 1.0, 0.5])
    if unit == "deg" and chance(r, 0.5):
        free = 0.0
    segments = program(r, lift, unit, free)
    speed = spread(r, 5.0, 3000.0) if not mad else spread(r, 1e-3, 1e6)
    length = lift if unit == "mm" else length_of(follower, lift)
    spec: Spec = {
        "name": f"random {number}",
        "speed_rpm": speed,
        "rotation": pick(r, ["ccw", "cw"]),
        "program": segments,
        "follower": follower,
        "limits": limits(
            r, follower["kind"], segments, unit, speed, length,
            follower.get("roller_radius_mm", 0.0),
        ),
        "objective": an_objective(r),
        "tolerance": spread(r, 1e-2, 1e-1) if chance(r, 0.9) else spread(r, 1e-3, 1e-2),
    }  # fmt: skip
    if unit == "mm":
        spec["base_radius_mm"] = a_range(r, 0.3 * length, 6.0 * length)
    else:
        # between the radii that the arm reaches, most of the time
        d = follower["centre_distance_mm"]
        d = d if isinstance(d, float) else 1.2 * length
        low = abs(d - length) - follower.get("roller_radius_mm", 0.0)
        low, high = max(1.1 * low, 0.2 * length), max(1.6 * low, length)
        if "arm_mm" not in follower:
            low, high = 0.1 * length, 0.7 * length
        spec["base_radius_mm"] = a_range(r, low, high)
    if chance(r, 0.08):
        spec["continuity"] = int(r.integers(0, 4))
    if mad and chance(r, 0.5):
        spec["base_radius_mm"] = length * spread(r, 1e-3, 1e6)
    if spec["base_radius_mm"] is None:
        del spec["base_radius_mm"]
    return spec
