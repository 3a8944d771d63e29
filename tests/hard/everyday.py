"""Everyday cams in another author's numbers, and what is said of each.

    python -m tests.hard.everyday [TRADE …]

Fifteen trades, twenty cams each. Numbers are those of textbooks, catalogues and drawings: lifts in
whole millimetres or in eighths of an inch, track rollers of the catalogue, base radii in fives,
speeds of machines of the trade; limits as an engineer of the trade sets them, or none. A colleague
should have little to say of such cams.

Prints every warning, and the counts by rule and severity: where a caution or a stop comes out,
judge whether a colleague would say it.
"""

from __future__ import annotations

import json
import random
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import Any

from synthesis import DesignSpec, synthesise
from synthesis.errors import TimeBudgetExceeded

Spec = dict[str, Any]
Pick = Callable[..., Any]  # one of its arguments
EACH = 20  # scenes of a trade
INCH = 25.4  # mm
ROLLERS = (8.0, 9.5, 11.0, 13.0, 15.0, 16.0, 17.5, 20.0, 23.5, 26.0)  # KR 16 to KR 52, radius [mm]
SMOOTH = ("cycloidal", "modified_sine", "modified_trapezoid", "polynomial_3_4_5")
SMOOTHEST = (*SMOOTH, "polynomial_4_5_6_7", "gutman_1_3")
JERK = 69.47  # C_j of the modified sine
ACCELERATION = 5.528  # its C_a


def double_dwell(
    rise: float, top: float, back: float, lift: float, law: str, unit: str = "mm"
) -> list[Spec]:
    move = {f"lift_{unit}": round(lift, 6), "law": {"kind": law}}
    return [
        {"kind": "rise", "angle_deg": rise, **move},
        {"kind": "dwell", "angle_deg": top},
        {"kind": "return", "angle_deg": back, **move},
        {"kind": "dwell", "angle_deg": 360.0 - rise - top - back},
    ]


def slide(roller: float, **more: Any) -> Spec:
    return {"kind": "translating_roller", "roller_radius_mm": roller, "offset_mm": 0.0, **more}


def arm(length: float, roller: float, **more: Any) -> Spec:
    return {
        "kind": "oscillating_roller", "arm_mm": length, "roller_radius_mm": roller,
        "centre_distance_mm": round(1.2 * length / 5.0) * 5.0, **more,
    }  # fmt: skip


def angles(rise: float, back: float) -> Spec:
    return {"kind": "pressure_angle", "rise_deg": rise, "return_deg": back}


def radius(least: float) -> Spec:
    return {"kind": "profile_radius", "min_mm": least}


def capped(order: int, lift: float, angle: float, rpm: float, times: float) -> Spec:
    """A limit of acceleration or jerk: so many times the modified sine's, two digits."""
    kind, coefficient = {2: ("acceleration", ACCELERATION), 3: ("jerk", JERK)}[order]
    peak = coefficient * lift * (6.0 * rpm / angle) ** order * times
    return {"kind": kind, f"max_mm_per_s{order}": float(f"{peak:.2g}")}


def round_base(lift: float, share: float) -> float:
    """A base radius in fives that gives the usual pressure angles."""
    return 5.0 * max(round((15.0 + share * lift) / 5.0), 5)


def textbook_size(pick: Pick) -> Spec:
    """Norton's and Rothbart's style: a named law, inches, the size from a pressure angle of 30°."""
    lift = pick(0.5, 0.75, 1.0, 1.25, 1.5, 2.0)
    return {
        "speed_rpm": pick(60.0, 120.0, 180.0),
        "program": double_dwell(
            pick(60.0, 90.0, 100.0, 120.0), 45.0, pick(90.0, 100.0, 120.0), lift * INCH,
            pick(*SMOOTH),
        ),
        "follower": slide(pick(0.25, 0.375, 0.5) * INCH),
        "limits": [angles(30.0, 30.0)],
    }  # fmt: skip


def textbook_given(pick: Pick) -> Spec:
    """Worked examples: the base radius is given, nothing is limited."""
    lift = pick(10.0, 20.0, 25.0, 30.0, 40.0, 50.0)
    return {
        "speed_rpm": pick(60.0, 95.493, 150.0, 240.0),
        "program": double_dwell(
            pick(90.0, 100.0, 120.0, 150.0), pick(30.0, 40.0, 60.0), pick(90.0, 100.0, 120.0),
            lift, pick(*SMOOTHEST),
        ),
        "base_radius_mm": round_base(lift, 1.6),
        "follower": slide(pick(*ROLLERS[:6]), offset_mm=pick(0.0, 0.0, 5.0, 10.0)),
    }  # fmt: skip


def textbook_face(pick: Pick) -> Spec:
    """Flat-faced followers whose size follows from the curvature."""
    lift = pick(10.0, 12.0, 15.0, 20.0, 25.0)
    return {
        "speed_rpm": pick(60.0, 120.0, 200.0),
        "program": double_dwell(
            pick(100.0, 120.0, 150.0), pick(20.0, 30.0, 60.0), pick(110.0, 120.0, 150.0), lift,
            pick("cycloidal", "modified_sine", "polynomial_3_4_5"),
        ),
        "follower": {"kind": "translating_flat_face"},
        "limits": [radius(pick(5.0, 8.0, 10.0))],
    }  # fmt: skip


def packaging_arm(pick: Pick) -> Spec:
    """Jaws and folders of packaging machines: an arm, in a groove or under a spring."""
    closure = pick({"kind": "groove", "clearance_mm": 0.05, "rim_mm": 8.0}, {"kind": "force"})
    return {
        "speed_rpm": pick(60.0, 90.0, 120.0, 150.0),
        "program": double_dwell(
            pick(90.0, 100.0, 120.0), pick(60.0, 90.0), pick(90.0, 100.0),
            pick(12.0, 15.0, 18.0, 20.0), pick("modified_sine", "modified_trapezoid"), "deg",
        ),
        "follower": arm(pick(100.0, 120.0, 140.0, 160.0), pick(*ROLLERS[2:7]), closure=closure),
        "base_radius_mm": {"min": pick(40.0, 50.0)},
        "limits": [angles(35.0, 35.0)],
    }  # fmt: skip


def arm_given(pick: Pick) -> Spec:
    """Arms of drawings: all is given, nothing limited."""
    length = pick(90.0, 100.0, 120.0, 150.0)
    return {
        "speed_rpm": pick(30.0, 60.0, 100.0),
        "program": double_dwell(
            pick(100.0, 120.0), 40.0, pick(100.0, 120.0), pick(12.0, 15.0, 18.0, 20.0),
            pick(*SMOOTH), "deg",
        ),
        "follower": arm(length, pick(10.0, 12.5, 15.0, 17.5)),
        "base_radius_mm": round(0.55 * length / 5.0) * 5.0,
    }  # fmt: skip


def engine_valve(pick: Pick) -> Spec:
    """Valve cams under flat tappets; the spring holds to a quarter above the rated speed."""
    lift, half = pick(7.0, 8.0, 8.5, 9.0), pick(62.0, 65.0, 68.0, 70.0)
    rpm, mass = pick(1500.0, 2000.0, 2500.0, 2750.0), 0.12
    move = {"lift_mm": lift, "law": {"kind": "polynomial_3_4_5_6"}}
    # the largest deceleration is at the nose, where the spring is compressed by the lift as well
    needed = mass * 7.5 * lift * (6.0 * 1.25 * rpm / half) ** 2 * 1e-3
    return {
        "speed_rpm": rpm,
        "program": [
            {"kind": "rise", "angle_deg": half, **move},
            {"kind": "return", "angle_deg": half, **move},
            {"kind": "dwell", "angle_deg": 360.0 - 2.0 * half},
        ],
        "base_radius_mm": {"min": pick(15.0, 16.0, 17.0, 18.0)},
        "follower": {"kind": "translating_flat_face"},
        "limits": [radius(2.0)],
        "load": {
            "kind": "slide", "moving_mass_kg": mass, "contact": {"width_mm": 14.0},
            "spring": {"rate_n_per_mm": 35.0,
                       "preload_n": float(f"{max(needed - 35.0 * lift, 200.0):.2g}")},
        },
    }  # fmt: skip


def pusher(pick: Pick) -> Spec:
    """Pushers and feeders: the law is chosen, jerk and curvature limited, a shaft allowed for."""
    lift, roller = pick(20.0, 30.0, 40.0, 45.0, 60.0), pick(*ROLLERS[2:7])
    rpm = pick(60.0, 100.0, 120.0, 200.0)
    rise, back = pick(90.0, 100.0, 120.0), pick(100.0, 120.0)
    return {
        "speed_rpm": rpm,
        "program": double_dwell(rise, 60.0, back, lift, "spline"),
        "base_radius_mm": {"min": pick(30.0, 35.0, 40.0, 50.0)},
        "follower": slide(roller),
        "limits": [
            angles(30.0, pick(30.0, 45.0)), radius(roller),
            capped(3, lift, min(rise, back), rpm, pick(1.0, 1.2, 1.5, 2.0)),
        ],
        "tolerance": 5e-3,
    }  # fmt: skip


def calm_pusher(pick: Pick) -> Spec:
    """The same by an engineer who limits the acceleration and minimises jerk after size."""
    body = pusher(pick)
    rise, _, back, _ = body["program"]
    angle, lift = min(rise["angle_deg"], back["angle_deg"]), rise["lift_mm"]
    times = pick(1.0, 1.2, 1.5)
    body["limits"][2] = capped(2, lift, angle, body["speed_rpm"], times)
    return {**body, "objective": [{"kind": "base_radius"}, {"kind": "rms_jerk"}], "tolerance": 0.05}


def textile(pick: Pick) -> Spec:
    """Sewing and textile machines: short strokes, high speeds, grooves."""
    return {
        "speed_rpm": pick(400.0, 500.0, 600.0, 800.0),
        "program": double_dwell(
            pick(110.0, 120.0, 140.0), pick(40.0, 60.0), pick(110.0, 120.0),
            pick(4.0, 5.0, 6.0, 8.0), pick("modified_sine", "cycloidal", "polynomial_4_5_6_7"),
        ),
        "base_radius_mm": pick(22.0, 25.0, 28.0, 30.0),
        "follower": slide(pick(8.0, 9.5), closure={"kind": "groove", "rim_mm": 5.0}),
    }  # fmt: skip


def slow_press(pick: Pick) -> Spec:
    """Hand presses and clamps that crawl: old laws are good enough there."""
    lift = pick(15.0, 20.0, 25.0, 30.0)
    return {
        "speed_rpm": pick(3.0, 5.0, 6.0, 8.0),
        "program": double_dwell(
            pick(120.0, 150.0), pick(20.0, 30.0), pick(90.0, 100.0), lift,
            pick("simple_harmonic", "parabolic", "modified_sine"),
        ),
        "base_radius_mm": round_base(lift, 1.6),
        "follower": slide(pick(*ROLLERS[4:])),
        "load": {
            "kind": "slide", "moving_mass_kg": pick(5.0, 10.0, 20.0),
            "rise_from_vertical_deg": 0.0,
            "spring": {"rate_n_per_mm": 4.0, "preload_n": 120.0},
        },
    }  # fmt: skip


def heavy(pick: Pick) -> Spec:
    """Punches and presses: a working stroke against some kilonewtons, the size from the angle."""
    lift = pick(12.0, 16.0, 20.0, 25.0)
    force = pick(1000.0, 2000.0, 3000.0)
    points = ((0.0, 0.0), (60.0, 0.0), (90.0, force), (120.0, force), (121.0, 0.0), (360.0, 0.0))
    return {
        "speed_rpm": pick(40.0, 60.0, 80.0),
        "program": double_dwell(120.0, 20.0, 120.0, lift, pick(*SMOOTH)),
        "follower": slide(pick(20.0, 23.5, 26.0)),
        "limits": [angles(30.0, 30.0), radius(20.0)],
        "load": {
            "kind": "slide", "moving_mass_kg": 12.0, "contact": {"width_mm": 25.0},
            "spring": {"rate_n_per_mm": 15.0, "preload_n": 400.0},
            "process": [{"angle_deg": at, "force_n": value} for at, value in points],
        },
    }  # fmt: skip


def assembly(pick: Pick) -> Spec:
    """Assembly machines: three levels, the spring chosen with the cam."""
    lift, law = pick(12.0, 16.0, 20.0, 25.0), {"kind": pick("modified_sine", "polynomial_3_4_5")}
    return {
        "speed_rpm": pick(40.0, 60.0, 75.0, 90.0),
        "program": [
            {"kind": "rise", "angle_deg": 60.0, "lift_mm": lift, "law": law},
            {"kind": "dwell", "angle_deg": 30.0},
            {"kind": "rise", "angle_deg": 50.0, "lift_mm": 0.5 * lift, "law": law},
            {"kind": "dwell", "angle_deg": 40.0},
            {"kind": "return", "angle_deg": 100.0, "lift_mm": 1.5 * lift, "law": law},
            {"kind": "dwell", "angle_deg": 80.0},
        ],
        "base_radius_mm": {"min": pick(30.0, 40.0, 45.0)},
        "follower": slide(pick(*ROLLERS[1:6]), offset_mm=pick(0.0, 5.0)),
        "limits": [angles(30.0, 35.0), {"kind": "contact_force", "min_n": 20.0}],
        "load": {
            "kind": "slide", "moving_mass_kg": pick(1.5, 2.5, 4.0),
            "spring": {"rate_n_per_mm": pick(2.0, 3.0, 5.0), "preload_n": {"min": 20.0}},
        },
    }  # fmt: skip


def spring_closed(pick: Pick) -> Spec:
    """Drives whose spring was sized by hand: 1.5 times the inertia that separates."""
    lift, rpm, mass = pick(10.0, 15.0, 20.0), pick(200.0, 300.0, 400.0), pick(0.8, 1.2, 2.0)
    rise = pick(100.0, 120.0)
    inertia = mass * ACCELERATION * lift * (6.0 * rpm / rise) ** 2 * 1e-3
    force = 1.5 * inertia
    return {
        "speed_rpm": rpm,
        "program": double_dwell(rise, 40.0, rise, lift, pick("cycloidal", "modified_sine")),
        "base_radius_mm": {"min": round_base(lift, 1.5)},
        "follower": slide(pick(*ROLLERS[1:5])),
        "limits": [angles(30.0, 30.0)],
        "load": {
            "kind": "slide", "moving_mass_kg": mass,
            "spring": {"rate_n_per_mm": float(f"{0.6 * force / lift:.2g}"),
                       "preload_n": float(f"{0.8 * force:.2g}")},
        },
    }  # fmt: skip


def conveyor(pick: Pick) -> Spec:
    """Long strokes with a constant velocity on the way, as of flying tools, without jumps."""
    lift = pick(60.0, 80.0, 100.0, 120.0)
    return {
        "speed_rpm": pick(20.0, 30.0, 40.0, 58.0),
        "program": double_dwell(
            pick(150.0, 160.0), 20.0, pick(120.0, 130.0), lift,
            pick("mcv50_makino", "cv50_half_sine", "scca_cv20"),
        ),
        "follower": slide(pick(*ROLLERS[5:])),
        "limits": [angles(35.0, 40.0)],
    }  # fmt: skip


def free_arm(pick: Pick) -> Spec:
    """Ratchets, feeders and levers on an arm whose pivot is chosen."""
    return {
        "speed_rpm": pick(50.0, 80.0, 120.0),
        "program": double_dwell(
            pick(90.0, 100.0, 120.0), 40.0, pick(100.0, 120.0), pick(15.0, 20.0, 25.0, 30.0),
            pick(*SMOOTHEST), "deg",
        ),
        "follower": {
            "kind": "oscillating_roller", "arm_mm": pick(80.0, 90.0, 100.0, 120.0),
            "roller_radius_mm": pick(*ROLLERS[:5]),
        },
        "limits": [angles(35.0, 35.0)],
    }  # fmt: skip


JUDGED: Mapping[tuple[str, int], str] = MappingProxyType({
    ("textbook_face", 2): "hub", ("textbook_face", 8): "hub",  # a base radius of 5 mm
    ("conveyor", 8): "hub", ("conveyor", 9): "hub", ("conveyor", 10): "hub",  # 6 to 8, stroke 60
    ("calm_pusher", 10): "rough_motion",  # the acceleration comes up within 1 % of the move
})  # fmt: skip
"""Scenes of which a colleague would say what the rule does: trade, number, rule."""


TRADES: Mapping[str, Callable[[Pick], Spec]] = MappingProxyType({
    each.__name__: each
    for each in (
        textbook_size, textbook_given, textbook_face, packaging_arm, arm_given, engine_valve,
        pusher, calm_pusher, textile, slow_press, heavy, assembly, spring_closed, conveyor,
        free_arm,
    )
})  # fmt: skip


def scenes(each: int = EACH) -> Iterator[tuple[str, int, Spec]]:
    """Trade, number and spec of every scene, no two the same; ``each``: how many of a trade."""
    for trade, make in TRADES.items():
        source, made = random.Random(trade), dict[str, Spec]()

        def pick(*items: Any, source: random.Random = source) -> Any:
            return source.choice(items)

        while len(made) < each:
            body = make(pick)
            made.setdefault(json.dumps(body), body)
        yield from ((trade, number, body) for number, body in enumerate(made.values()))


def main() -> None:
    """Design all of them, print what is said of each, and how often."""
    counts, cams, silent, wrong = Counter[tuple[str, str]](), Counter[str](), 0, 0
    wanted = sys.argv[1:]
    for trade, number, body in scenes():
        if wanted and trade not in wanted:
            continue
        try:
            design = synthesise(DesignSpec.model_validate({**body, "time_budget_s": 20.0}))
        except TimeBudgetExceeded as error:
            print(f"{trade} {number}: {error}")
            continue
        except ValueError as error:
            print(f"{trade} {number}: REFUSED {error}")
            continue
        cams[design.status] += 1
        silent += not design.warnings
        radius = design.dimensions.get("base_radius_mm", float("nan"))
        if design.warnings or not design.certificate.certified:
            print(f"{trade} {number}: {design.status}, base radius {radius:.4g} mm")
        if not design.motion:
            print(f"   {json.dumps(body)}\n   {design.conflict and design.conflict.limits}")
        for one in design.warnings:
            counts[one.code, one.severity] += 1
            right = one.severity == "note" or JUDGED.get((trade, number)) == one.code
            wrong += not right
            print(f"   {'' if right else 'WRONG? '}{one.severity} {one.code}: {one.sentence}")
    print(f"\n{sum(cams.values())} cams ({dict(cams)}), nothing said of {silent}")
    print(f"{wrong} cautions and stops that are not judged right")
    for (code, severity), count in sorted(counts.items()):
        print(f"{count:4} {severity:8} {code}")


if __name__ == "__main__":
    main()
