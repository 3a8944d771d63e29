"""Questions of mixed units and sizes from fixed seeds: exact limits, idle limits, absurd ones.

The follower walks between levels, machines measure from 1e-4 to 1e4 mm, and most numbers of a limit
are multiples of a value that is known in closed form: 1 exactly, next to 1, or far from it.
"""

from __future__ import annotations

from math import degrees, isclose, pi, radians
from typing import Any

import numpy as np

Spec = dict[str, Any]
SEED = 20_281_123
COUNT = 3_000
LEAST = {1: 1.0, 2: 4.0, 3: 32.0}
"""Least peak of the n-th derivative between rests, in lift/angle^n."""
PEAKS = {1: "velocity", 2: "acceleration", 3: "jerk"}
EXACT = (1.0,)
NEAR = (1.0 - 1e-9, 1.0 + 1e-9, 1.0 - 1e-6, 1.0 + 1e-6, 1.0 - 1e-3, 1.0 + 1e-3)
ROOMY = (1.1, 1.25, 1.5, 2.0, 3.0, 5.0)
IDLE = (1e2, 1e4, 1e8)
LAWS = (
    "cycloidal", "modified_sine", "modified_trapezoid", "polynomial_3_4_5", "polynomial_4_5_6_7",
    "simple_harmonic", "parabolic", "mcv50_makino",
)  # fmt: skip
AIMS = ("peak_acceleration", "peak_jerk", "rms_acceleration", "rms_jerk", "peak_pressure_angle")


class Draw:
    """Random choices, and the many ways in which people write a number."""

    def __init__(self, seed: list[int]) -> None:
        self.random = np.random.default_rng(seed)

    def one(self, *items: Any) -> Any:
        return items[int(self.random.integers(len(items)))]

    def happens(self, share: float) -> bool:
        return bool(self.random.random() < share)

    def even(self, low: float, high: float) -> float:
        return self.written(float(self.random.uniform(low, high)))

    def orders(self, low: float, high: float) -> float:
        """Even over orders of magnitude."""
        return self.written(float(np.exp(self.random.uniform(np.log(low), np.log(high)))))

    def written(self, value: float) -> float:
        """About a value: all its digits, one digit, three, or sixty-fourths of an inch."""
        inches = 25.4 / 64.0 * round(value * 64.0 / 25.4)
        one, three = float(f"{value:.1g}"), float(f"{value:.3g}")
        found = self.one(value, one, three, inches)
        return float(found) if isclose(found, value, rel_tol=0.2) else value

    def multiple(self) -> float:
        """Of a value that is known: exact, next to it, roomy, idle."""
        group = self.one(EXACT, NEAR, ROOMY, ROOMY, ROOMY, IDLE)
        return float(self.one(*group))


# -- motion --------------------------------------------------------------------------------------


def levels_of(draw: Draw, count: int) -> list[float]:
    """Levels at the ends of the segments, the first and the last the same, between 0 and 1."""
    levels = [0.0]
    for left in range(count - 1, 0, -1):
        stay = draw.happens(0.45) and left > 1
        levels.append(levels[-1] if stay else draw.one(0.0, 1.0, draw.even(0.05, 0.95)))
    if max(levels) == 0.0:
        levels[1] = 1.0
    return [*levels, 0.0]


def angles_of(draw: Draw, count: int) -> list[float]:
    """Angles that sum to 360°: equal, whole degrees, radians, or most of the turn in one."""
    shares = draw.random.dirichlet([draw.one(0.6, 3.0, 30.0)] * count) + 0.004
    angles = [float(a) for a in 360.0 * shares / shares.sum()]
    way = draw.one("raw", "whole", "radian", "equal")
    if way == "equal":
        angles = [360.0 / count] * count
    if way == "whole":
        angles = [max(1.0, round(angle)) for angle in angles]
    if way == "radian" and max(angles) > degrees(1.0):
        angles[0] = degrees(0.5)
    largest = int(np.argmax(angles))
    angles[largest] = 360.0 - (sum(angles) - angles[largest])
    return angles if min(angles) > 0.0 else [360.0 / count] * count


def a_law(draw: Draw, free: bool) -> Spec:
    if not free:
        return {"kind": draw.one(*LAWS)}
    law: Spec = {"kind": "spline"}
    if draw.happens(0.2):
        law["smoothness"] = draw.one(1, 2, 3, 4)  # 1 becomes 2 where the jerk is asked about
    if draw.happens(0.1):
        law["overshoot"] = True
    return law


def program_of(draw: Draw, lift: float, unit: str, speed: float) -> list[Spec]:
    """A walk between levels; where it stays, a dwell."""
    count = int(draw.random.integers(2, 13)) if draw.happens(0.5) else draw.one(2, 3, 4, 4)
    levels, angles = levels_of(draw, count), angles_of(draw, count)
    free = draw.one(1.0, 1.0, 1.0, 0.6, 0.0)
    found: list[Spec] = []
    for i, angle in enumerate(angles):
        way = (levels[i + 1] - levels[i]) * lift
        if way == 0.0:
            found.append({"kind": "dwell", "angle_deg": angle})
            continue
        kind = "rise" if way > 0.0 else "return"
        move: Spec = {"kind": kind, "angle_deg": angle, f"lift_{unit}": abs(way)}
        move["law"] = a_law(draw, draw.happens(free))
        found.append(move)
    if draw.happens(0.08):
        _with_window(draw, found, unit, speed)
    if draw.happens(0.08):
        _with_free_numbers(draw, found, unit)
    return found


def _with_window(draw: Draw, program: list[Spec], unit: str, speed: float) -> None:
    """A part of a free move that is slower than a multiple of its mean, or a point to pass."""
    moves = [s for s in program if s["kind"] != "dwell" and s["law"]["kind"] == "spline"]
    if not moves:
        return
    move = draw.one(*moves)
    angle, lift = move["angle_deg"], move[f"lift_{unit}"]
    if draw.happens(0.5):
        at, way = draw.even(0.3, 0.7), draw.even(0.3, 0.7)
        point = {"angle_deg": at * angle, f"travel_{unit}": way * lift}
        if draw.happens(0.5):
            point[f"tolerance_{unit}"] = 1e-3 * lift
        move["points"] = [point]
        return
    mean = lift * 6.0 * speed / angle * (1.0 if move["kind"] == "rise" else -1.0)
    most = mean * draw.one(1.0, 1.2, 1.6, 50.0)
    bound = {"max": most} if most > 0.0 else {"min": most}
    ends = {"from_deg": 0.25 * angle, "to_deg": 0.75 * angle}
    move["windows"] = [{**ends, f"velocity_{unit}_per_s": bound}]


def _with_free_numbers(draw: Draw, program: list[Spec], unit: str) -> None:
    """Two angles, or the lifts of moves of one direction, in a range around what they are."""
    name = draw.one("angle_deg", f"lift_{unit}")
    places = [i for i, segment in enumerate(program) if name in segment]
    if name != "angle_deg":
        kind = draw.one("rise", "return")
        places = [i for i in places if program[i]["kind"] == kind]
    for i in places[:2] if len(places) > 1 else []:
        value = program[i][name]
        program[i][name] = {"min": draw.even(0.5, 0.95) * value, "max": draw.even(1.05, 2) * value}


# -- machines ------------------------------------------------------------------------------------


def slide_of(draw: Draw, lift: float) -> Spec:
    found: Spec = {"kind": "translating_roller"}
    found["roller_radius_mm"] = roller = draw.one(0.0, lift * draw.orders(1e-3, 30.0), 0.3 * lift)
    e = lift * draw.even(-2.0, 2.0)
    free = {"min": -abs(e), "max": abs(e) + 0.1 * lift}
    found |= draw.one({}, {}, {"offset_mm": 0.0}, {"offset_mm": e}, {"offset_mm": free})
    counter = {"kind": "conjugate", "roller_radius_mm": roller + 0.1 * lift, "offset_mm": 0.0}
    far = {**counter, "distance_mm": lift * draw.even(4.0, 12.0)}
    if roller and draw.happens(0.3):
        found["closure"] = _closure(draw, roller, draw.one(counter, far))
    return found


def arm_of(draw: Draw, length: float) -> Spec:
    found: Spec = {"kind": "oscillating_roller", "sense": draw.one("same", "opposite")}
    found["arm_mm"] = length
    found["roller_radius_mm"] = roller = draw.one(0.0, length * draw.orders(0.01, 0.5))
    d = length * draw.one(1.0, draw.even(0.6, 3.0), draw.even(0.9, 1.5))
    found |= draw.one(
        {"centre_distance_mm": d},
        {"centre_distance_mm": d},
        {"centre_distance_mm": {"min": 0.9 * d, "max": 1.5 * d}},
        {"centre_distance_mm": None, "initial_angle_deg": draw.even(15.0, 50.0)},
        {},
    )
    counter = {"kind": "conjugate", "roller_radius_mm": roller + 0.05 * length, "arm_mm": length}
    if roller and draw.happens(0.3):
        found["closure"] = _closure(draw, roller, counter)
    if draw.happens(0.08):
        found["arm_mm"] = {"min": 0.8 * length, "max": 1.2 * length}
    return found


def _closure(draw: Draw, roller: float, counter: Spec) -> Spec:
    groove = {"kind": "groove", "clearance_mm": 0.01 * roller, "rim_mm": 0.5 * roller}
    ring = {"kind": "force", "contact": "inside", "rim_mm": 0.5 * roller}
    return dict(draw.one(groove, ring, counter))


def face_of(draw: Draw, lift: float) -> Spec:
    tilted = {"tilt_deg": draw.even(-40.0, 40.0), "offset_mm": lift * draw.even(-1.0, 1.0)}
    return {"kind": "translating_flat_face"} | draw.one({}, {}, tilted)


def swinging_face_of(draw: Draw, length: float) -> Spec:
    d = draw.one(length, length, {"min": 0.8 * length, "max": 1.6 * length})
    f = length * draw.one(0.0, draw.even(-0.1, 0.1))
    sense = draw.one("same", "opposite")
    return {"kind": "oscillating_flat_face", "centre_distance_mm": d, "face_offset_mm": f,
            "sense": sense}  # fmt: skip


# -- requirements --------------------------------------------------------------------------------


def least_peak(program: list[Spec], unit: str, order: int, speed: float) -> float:
    """Least peak of the n-th derivative that the sharpest move needs between rests [unit/s^n]."""
    omega = speed * pi / 30.0
    sharpness = [
        move[f"lift_{unit}"] / radians(move["angle_deg"]) ** order
        for move in program
        if f"lift_{unit}" in move
        and not isinstance(move[f"lift_{unit}"], dict)
        and not isinstance(move["angle_deg"], dict)
    ]
    return float(LEAST[order] * max(sharpness, default=1.0) * omega**order)


def limits_of(
    draw: Draw, follower: Spec, program: list[Spec], unit: str, speed: float, length: float
) -> list[Spec]:
    """A few of all that such a machine may be asked."""
    found: list[Spec] = []
    kind = follower["kind"]
    for order, name in PEAKS.items():
        if draw.happens({1: 0.15, 2: 0.3, 3: 0.6}[order]):
            peak = least_peak(program, unit, order, speed) * draw.multiple()
            found.append({"kind": name, f"max_{unit}_per_s{order if order > 1 else ''}": peak})
    if kind != "translating_flat_face" and draw.happens(0.75):
        angle = draw.one(0.01, 1.0, 30.0, 45.0, 60.0, 89.0, 89.999, draw.even(15.0, 60.0))
        other = draw.one(angle, draw.even(25.0, 60.0))
        found.append({"kind": "pressure_angle", "rise_deg": angle, "return_deg": other})
    if draw.happens(0.35):
        least = draw.one(0.0, 1e-6 * length, length * draw.orders(0.02, 3.0), 1e3 * length)
        found.append({"kind": "profile_radius", "min_mm": least})
    if "roller" in kind and draw.happens(0.1):
        cutter = length * draw.orders(0.1, 1e4)
        found.append({"kind": "cutter_radius", "radius_mm": cutter})
    if draw.happens(0.12):
        found.append({"kind": "outer_radius", "max_mm": length * draw.orders(1.5, 1e6)})
    if kind == "translating_flat_face" and draw.happens(0.3):
        found.append({"kind": "face_width", "width_mm": length * draw.orders(1.0, 1e5)})
    if kind == "oscillating_flat_face" and draw.happens(0.2):
        found.append({"kind": "face_width", "far_mm": length * draw.orders(0.8, 1e4)})
    if draw.happens(0.06) and any(segment["kind"] == "dwell" for segment in program):
        still = {"natural_frequency_hz": speed / 60.0 * draw.even(3.0, 15.0)}
        found.append({"kind": "residual_vibration", **still, f"max_{unit}": 0.01 * length})
    draw.random.shuffle(found)  # type: ignore[arg-type]
    return found


def load_of(draw: Draw, lift: float, program: list[Spec], speed: float) -> tuple[Spec, list[Spec]]:
    """A sprung mass on a slide, its spring a multiple of what its inertia needs; and limits."""
    omega, mass = speed * pi / 30.0, draw.orders(1e-3, 1e3)
    sharpest = least_peak(program, "mm", 2, speed) * 1e-3
    inertia = mass * sharpest
    spring = {"rate_n_per_mm": inertia / lift * draw.orders(0.1, 10.0),
              "preload_n": inertia * draw.orders(0.1, 10.0)}  # fmt: skip
    load: Spec = {"kind": "slide", "moving_mass_kg": mass, "spring": spring,
                  "contact": {"width_mm": 0.3 * lift}}  # fmt: skip
    if draw.happens(0.3):
        load["damping_n_s_per_m"] = inertia / (1e-3 * lift * omega) * 0.05
    limits = [{"kind": "contact_force", "min_n": 0.0}]
    if draw.happens(0.4):
        limits[0]["max_n"] = min(
            inertia * draw.orders(2.0, 1e4), 1e12
        )  # N, the most that can be asked
    return load, limits


# -- the whole -----------------------------------------------------------------------------------

MACHINES = (
    (slide_of, "mm", 0.5),
    (face_of, "mm", 0.2),
    (arm_of, "deg", 0.2),
    (swinging_face_of, "deg", 0.1),
)


def radius_of(draw: Draw, follower: Spec, lift: float) -> Any:
    """A base radius: open, given, in a range, or with one end, now and then an absurd one."""
    low, high = 0.2 * lift, 8.0 * lift
    if "arm_mm" in follower:
        ranges = [follower["arm_mm"], follower.get("centre_distance_mm") or follower["arm_mm"]]
        arm, d = (r["max"] if isinstance(r, dict) else r for r in ranges)
        low = 1.05 * abs(d - arm) + 0.1 * arm
        high = 3.0 * low
    elif "centre_distance_mm" in follower:
        low, high = 0.1 * lift, 0.7 * lift
    a, b = sorted((draw.orders(low, high), draw.orders(low, high)))
    if draw.happens(0.05):
        a, b = 1e-6 * lift, 1e6 * lift
    return draw.one(None, None, None, None, a, {"min": a, "max": b}, {"min": a}, {"max": b})


def without_jumps(spec: Spec) -> Spec:
    """The same with splines of class C2 in place of C1, where their jerk is asked about."""
    if "jerk" in str([spec["limits"], spec["objective"]]):
        for segment in spec["program"]:
            law = segment.get("law", {})
            law |= {"smoothness": 2} if law.get("smoothness") == 1 else {}
    return spec


def mixed_spec(number: int) -> Spec:
    """The question of a number, the same at every call."""
    draw = Draw([SEED, number])
    shares = [share for *_, share in MACHINES]
    make, unit, _ = MACHINES[int(draw.random.choice(len(MACHINES), p=shares))]
    length = draw.orders(1e-4, 1e4) if draw.happens(0.5) else draw.orders(3.0, 100.0)
    lift = length if unit == "mm" else draw.one(draw.even(2.0, 45.0), draw.orders(1e-4, 90.0))
    speed = draw.one(draw.orders(1e-3, 1e6), draw.orders(30.0, 1e3), 60.0, 30.0 / pi)
    follower = make(draw, length)
    program = program_of(draw, lift, unit, speed)
    scale = length if unit == "mm" else 0.5 * length
    limits = limits_of(draw, follower, program, unit, speed, scale)
    spec: Spec = {"speed_rpm": speed, "rotation": draw.one("ccw", "cw"), "program": program,
                  "follower": follower, "limits": limits}  # fmt: skip
    plain = follower["kind"].startswith("translating") and "closure" not in follower
    if plain and draw.happens(0.15):
        spec["load"], more = load_of(draw, length, program, speed)
        spec["limits"] = [*limits, *more]
    base, aims = {"kind": "base_radius"}, [{"kind": aim} for aim in AIMS]
    if follower["kind"] == "translating_flat_face":
        del aims[-1]
    spec["objective"] = draw.one(base, base, base, draw.one(*aims), [base, draw.one(*aims)])
    radius = radius_of(draw, follower, length)
    if radius is not None and "initial_angle_deg" not in follower:
        spec["base_radius_mm"] = radius
    if draw.happens(0.05):
        spec["continuity"] = draw.one(0, 1, 2, 3)
    spec["tolerance"] = draw.one(1e-3, 5e-3, 1e-2, draw.orders(1e-4, 0.1))
    if draw.happens(0.15):
        spec["proof"] = "thorough"
    return without_jumps(spec)
