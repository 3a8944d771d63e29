"""Random questions of the classes that proof files cover, feasible and not."""

import math
import random
from typing import Any

NAMED = (
    "polynomial_3_4_5", "polynomial_4_5_6_7", "cycloidal", "modified_sine", "modified_trapezoid",
)  # fmt: skip
LEAST_JERK = 32.0  # of h/T³: what a move from rest to rest needs
LEAST_ACCELERATION = 4.0  # of h/T²


def question(chance: random.Random) -> dict[str, Any]:
    """One question."""
    lift, rpm = chance.choice((0.5, 8.0, 30.0)), chance.choice((30.0, 95.49296585513721, 600.0))
    rise, fall = (round(chance.uniform(50.0, 130.0), chance.randrange(3)) for _ in range(2))
    left = round(360.0 - rise - fall, 6)
    top = chance.choice((0.0, round(0.3 * left, 3)))
    law = {"kind": "spline", "smoothness": chance.choice((2, 2, 2, 3)),
           "overshoot": chance.random() < 0.1}  # fmt: skip
    given = [{"kind": chance.choice(NAMED)} for _ in range(chance.choice((0, 0, 0, 1, 2)))]
    first, second = chance.sample([*given, *[law] * (2 - len(given))], 2)
    program = [
        {"kind": "rise", "angle_deg": rise, "lift_mm": lift, "law": first},
        {"kind": "dwell", "angle_deg": top},
        {"kind": "return", "angle_deg": fall, "lift_mm": lift, "law": second},
        {"kind": "dwell", "angle_deg": round(left - top, 6)},
    ]
    time = min(rise, fall) / (6.0 * rpm)
    share = chance.choice((1.5, *(2.5, 3.5) * 4) if given else (0.9, *(1.2, 1.5, 3.0) * 4))
    limits: list[dict[str, Any]] = [
        {"kind": "jerk", "max_mm_per_s3": float(f"{LEAST_JERK * share * lift / time**3:.6g}")}
    ]
    if chance.random() < 0.3 and not given:
        most = LEAST_ACCELERATION * chance.uniform(1.2, 2.0) * lift / time**2
        limits.append({"kind": "acceleration", "max_mm_per_s2": float(f"{most:.5g}")})
    if chance.random() < 0.2:
        most = chance.uniform(1.3, 2.2) * lift / time
        limits.append({"kind": "velocity", "max_mm_per_s": float(f"{most:.5g}")})
    body: dict[str, Any] = {"speed_rpm": rpm, "program": program, "limits": limits}
    if chance.random() < 0.6:
        limits.append({"kind": "pressure_angle", "rise_deg": chance.choice((20.0, 30.0, 45.5)),
                       "return_deg": chance.choice((30.0, 45.0)),
                       "dwell_deg": chance.choice((None, None, 40.0))})  # fmt: skip
        offset = chance.choice((0.0, None, {"min": -0.3 * lift, "max": 0.2 * lift}))
        body["follower"] = {"kind": "translating_roller", "offset_mm": offset,
                            "roller_radius_mm": chance.choice((0.0, 0.1, 0.3)) * lift}  # fmt: skip
        radius = body["follower"]["roller_radius_mm"]
        closures = [
            {"kind": "force", "contact": "inside", "rim_mm": 0.1 * lift},
            {"kind": "groove", "clearance_mm": 0.01 * lift, "rim_mm": 0.2 * lift},
            {"kind": "conjugate", "roller_radius_mm": radius, "offset_mm": 0.1 * lift},
        ]
        if radius and chance.random() < 0.4:
            body["follower"]["closure"] = chance.choice(closures)
        if chance.random() < 0.2:
            limits.append({"kind": "outer_radius", "max_mm": 12.0 * lift})
        if chance.random() < 0.2 and first["kind"] == "spline":
            speed = float(f"{1.7 * lift / (rise / (6.0 * rpm)):.4g}")
            window = {"from_deg": round(0.3 * rise, 3), "to_deg": round(0.6 * rise, 3),
                      "velocity_mm_per_s": {"max": speed}}  # fmt: skip
            point = {"angle_deg": round(0.5 * rise, 3), "travel_mm": 0.5 * lift,
                     "tolerance_mm": chance.choice((0.0, 0.05)) * lift}  # fmt: skip
            program[0].update(chance.choice(({"windows": [window]}, {"points": [point]})))
        if chance.random() < 0.3:  # a bound that curvature raises, in rounds
            limits.append({"kind": "profile_radius", "min_mm": chance.choice((0.2, 0.4)) * lift})
    else:
        limits.append({"kind": "profile_radius", "min_mm": chance.choice((0.1, 0.3)) * lift})
        if chance.random() < 0.4:
            limits.append({"kind": "face_width", "width_mm": round(4.0 * lift, 3)})
        tilt = chance.choice((0.0, 0.0, round(chance.uniform(-25.0, 25.0), 2)))
        body["follower"] = {"kind": "translating_flat_face", "tilt_deg": tilt}
    if chance.random() < 0.3:
        body["base_radius_mm"] = {"min": 0.1 * lift, "max": chance.choice((0.8, 2.0, 20.0)) * lift}
    kind = chance.choice(("base_radius",) * 4 + ("peak_jerk", "peak_acceleration"))
    if body["follower"]["kind"] == "translating_roller" and chance.random() < 0.15:
        kind = "peak_pressure_angle"  # without a limit on it, and in a range of sizes
        body["limits"] = [each for each in limits if each["kind"] != "pressure_angle"]
        body["base_radius_mm"] = {"min": 0.5 * lift, "max": chance.uniform(1.0, 4.0) * lift}
    aims: Any = {"kind": kind}
    if kind != "peak_pressure_angle" and chance.random() < 0.4:
        size, square = {"kind": "base_radius"}, chance.choice(("rms_jerk", "rms_acceleration"))
        rms = {"kind": square, "allowance": chance.choice((0.25, 0.1, None))}
        aims = chance.choice((rms, rms, [rms, size], [rms, size], [size, rms]))
        if not given and chance.random() < 0.5:  # as who asks for nothing else
            body["limits"] = [each for each in limits if each["kind"] != "jerk"]
    body = {**body, "objective": aims, "proof": "quick", "tolerance": 0.005,
            "time_budget_s": 10.0}  # fmt: skip
    of_slide = any(each.get(name) for each in program for name in ("windows", "points"))
    of_slide = of_slide or body["follower"]["kind"] != "translating_roller"
    body = body if of_slide or chance.random() < 0.7 else on_arm(body, lift, chance)
    return loaded(body, lift, time, chance) if chance.random() < 0.3 else body


def loaded(body: dict[str, Any], lift: float, time: float, chance: random.Random) -> dict[str, Any]:
    """The same with a load and limits on forces, of which some cams keep none.

    ``time``: of the shorter move [s]. Forces are sized by what accelerates the mass.
    """
    follower = body["follower"]
    closure = follower.get("closure", {"kind": "force"})["kind"]
    mass, arm = round(chance.uniform(0.2, 3.0), 2), follower.get("arm_mm")
    metre = 1.0 if arm is None else 1e-3 * arm  # N m of an N at the end of the arm
    inertia = mass * 6.0 * lift / time**2 * 1e-3  # N
    preload = inertia * chance.uniform(1.0, 3.0)
    rate = chance.choice((0.0, inertia / lift * chance.uniform(0.1, 2.0)))
    press = chance.choice((0.0, 0.0, inertia * chance.uniform(-0.5, 2.0)))
    most = 2.0 * inertia + preload + rate * lift + max(press, 0.0)
    start = round(chance.uniform(0.0, 300.0), chance.randrange(2))

    def figure(value: float) -> float:
        return float(f"{value:.4g}")

    names = ["moving_mass_kg", "damping_n_s_per_m", "rate_n_per_mm", "preload_n", "force_n"]
    values = [mass, 0.0, rate, preload, press]
    values[1] = chance.choice((0.0, 0.3 * inertia / (lift / time * 1e-3)))
    if arm is not None:
        names = ["moment_of_inertia_kg_m2", "damping_n_m_s_per_rad", "rate_n_m_per_rad",
                 "preload_n_m", "moment_n_m"]  # fmt: skip
        turn = 1e3 * metre  # mm of arc in a radian
        units = (metre**2, metre**2, metre * turn, metre, metre)
        values = [value * unit for value, unit in zip(values, units, strict=True)]
    known = dict(zip(names, map(figure, values), strict=True))
    force = known.pop(names[4])
    spring: dict[str, Any] = {name: known.pop(name) for name in names[2:4]}
    if closure == "force" and chance.random() < 0.3:  # chosen with the cam
        low = spring[names[3]]
        spring[names[3]] = chance.choice((None, {"min": 0.5 * low, "max": 2.0 * low}))
        spring[names[2]] = chance.choice((None, spring[names[2]]))
    load: dict[str, Any] = {"kind": "slide" if arm is None else "arm", "spring": spring, **known}
    if force:
        points = [(start, 0.0), (start + 20.0, force), (start + 50.0, force), (start + 50.0, 0.0)]
        load["process"] = [{"angle_deg": x, names[4]: y} for x, y in points]
    if arm is None and chance.random() < 0.4:
        load["rise_from_vertical_deg"] = chance.choice((0.0, 30.0, 180.0))
    load["contact"] = {"width_mm": 10.0}
    limits: list[dict[str, Any]] = [{"kind": "camshaft_torque"}, {"kind": "hertz_pressure"},
                                    {"kind": "contact_force", "max_n": None},
                                    {"kind": "contact_force", "min_n": 0.0}]  # fmt: skip
    if follower.get("roller_radius_mm") == 0.0:  # a knife edge has no Hertz pressure
        limits = [each for each in limits if each["kind"] != "hertz_pressure"]
    limits = chance.sample([each for each in limits if closure == "force" or "min_n" not in each],
                           chance.choice((1, 1, 2)))  # fmt: skip
    share = chance.choice((0.8, 1.0, 1.3, 2.0))
    radius = follower.get("roller_radius_mm", lift) or lift
    stiff = math.pi * 10.0 * 2.0 * 0.91 / 206e3
    values_of = {"camshaft_torque": ("max_n_m", most * 3.0 * lift / time * 1e-3 * time_of(body)),
                 "hertz_pressure": ("max_mpa", math.sqrt(2.0 * most / stiff / radius)),
                 "contact_force": ("max_n", most)}  # fmt: skip
    for each in limits:
        name, value = values_of[each["kind"]]
        if "min_n" not in each:
            each[name] = figure(share * value)
    return {**body, "load": load, "limits": [*body["limits"], *limits]}


def time_of(body: dict[str, Any]) -> float:
    """Seconds in which the cam turns by a radian."""
    return 30.0 / math.pi / float(body["speed_rpm"])


def on_arm(body: dict[str, Any], lift: float, chance: random.Random) -> dict[str, Any]:
    """The same of an arm, whose roller's centre moves as far along its arc."""
    swing = round(chance.uniform(8.0, 25.0), 1)
    arm, follower = round(lift / math.radians(swing), 3), body["follower"]
    program = [
        {**{k: v for k, v in each.items() if k != "lift_mm"}, "lift_deg": swing}
        if "lift_mm" in each
        else each
        for each in body["program"]
    ]
    limits = [
        {name.replace("mm_per", "deg_per"): value * swing / lift if "_per_" in name else value
         for name, value in each.items()}
        for each in body["limits"]
    ]  # fmt: skip
    closure = follower.get("closure", {"kind": "force"})
    if closure["kind"] == "conjugate":
        closure = {"kind": "conjugate", "roller_radius_mm": closure["roller_radius_mm"],
                   "arm_mm": arm}  # fmt: skip
    distance = chance.choice((None, 1.2 * arm, {"min": 0.9 * arm, "max": 1.4 * arm}))
    own = {"kind": "oscillating_roller", "roller_radius_mm": follower["roller_radius_mm"],
           "arm_mm": arm, "sense": chance.choice(("same", "opposite")), "closure": closure,
           "centre_distance_mm": distance}  # fmt: skip
    return {**body, "program": program, "limits": limits, "follower": own}
