"""Three hundred everyday cams of twenty trades, written apart from the rules of advice.

    python -m tests.hard.trades              # each caution and stop, and how many there are
    python -m tests.hard.trades --verbose    # the notes too

Numbers are as remembered from textbooks (Norton, Rothbart, Neklutin, Koster) and from machines of
the trades, not of any one source; each scene is one that its trade would ask for. Whoever wrote
them knew the rules from ``docs/warnings.md``, not their code nor ``everyday.py``.
"""

from __future__ import annotations

import argparse
import random
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any, Final

import synthesis as c

SEED: Final = 20_61  # any number: the scenes stay the same
EACH: Final = 15  # scenes of a trade
Spec = dict[str, Any]
Draw = random.Random


def move(kind: str, angle: float, lift: float, law: str, unit: str = "mm") -> Spec:
    return {"kind": kind, "angle_deg": angle, f"lift_{unit}": lift, "law": {"kind": law}}


def dwell(angle: float) -> Spec:
    return {"kind": "dwell", "angle_deg": angle}


def there_and_back(
    lift: float, angles: tuple[float, float, float], laws: tuple[str, str], unit: str = "mm"
) -> list[Spec]:
    """Rise, upper dwell and return of these angles; the lower dwell is the rest of the turn."""
    up, above, down = angles
    program = [move("rise", up, lift, laws[0], unit)]
    program += [dwell(above)] if above else []
    program.append(move("return", down, lift, laws[1], unit))
    rest = 360.0 - up - above - down
    return [*program, dwell(rest)] if rest else program


def slide(roller: float, offset: float = 0.0, **more: Any) -> Spec:
    return {"kind": "translating_roller", "roller_radius_mm": roller, "offset_mm": offset, **more}


def arm(roller: float, length: float, pivot: float, **more: Any) -> Spec:
    return {"kind": "oscillating_roller", "roller_radius_mm": roller, "arm_mm": length,
            "centre_distance_mm": pivot, **more}  # fmt: skip


def angle_limit(rise: float, back: float) -> Spec:
    return {"kind": "pressure_angle", "rise_deg": rise, "return_deg": back}


def sized(draw: Draw, radius: float, limit: Spec, shaft: float) -> Spec:
    """Half of the designers give the base radius, the others the limit and the shaft."""
    if draw.random() < 0.5:
        return {"base_radius_mm": radius}
    return {"limits": [limit], "shaft_diameter_mm": shaft}


def tucker(d: Draw) -> Spec:
    """Carton flap tucker: an arm at packaging speed."""
    swing, law = d.choice([18.0, 24.0, 30.0]), d.choice(["modified_sine", "cycloidal"])
    up, above = d.choice([80.0, 90.0, 110.0]), d.choice([20.0, 40.0])
    return {"speed_rpm": d.choice([60.0, 80.0, 120.0]),
            "program": there_and_back(swing, (up, above, up), (law, law), "deg"),
            "follower": arm(16.0, d.choice([120.0, 140.0]), 180.0),
            **sized(d, d.choice([75.0, 85.0]), angle_limit(35.0, 35.0), 40.0)}  # fmt: skip


def filler(d: Draw) -> Spec:
    """Piston filler: slow, long stroke, suction at an even speed."""
    stroke, law = d.choice([40.0, 60.0, 75.0]), d.choice(["modified_sine", "mcv50_makino"])
    return {"speed_rpm": d.choice([25.0, 40.0, 60.0]),
            "program": there_and_back(stroke, (150.0, 20.0, 140.0), (law, "modified_sine")),
            "follower": slide(d.choice([16.0, 20.0]), closure={"kind": "groove"}),
            **sized(d, d.choice([80.0, 100.0]), angle_limit(30.0, 35.0), 50.0)}  # fmt: skip


def sealer(d: Draw) -> Spec:
    """Sealing plate of a blister machine, lifted against a spring, dwelling while it seals."""
    stroke, dwelling = d.choice([12.0, 18.0, 25.0]), d.choice([90.0, 120.0])
    return {"speed_rpm": d.choice([30.0, 45.0, 60.0]),
            "program": there_and_back(stroke, (80.0, dwelling, 80.0), ("modified_sine",) * 2),
            "follower": slide(20.0),
            "load": {"kind": "slide", "moving_mass_kg": d.choice([6.0, 12.0]),
                     "spring": {"rate_n_per_mm": 6.0, "preload_n": 400.0}},
            **sized(d, 60.0, angle_limit(25.0, 30.0), 45.0)}  # fmt: skip


def shedding(d: Draw) -> Spec:
    """Shedding cam of a loom, a pair of conjugate cams on a rocking lever."""
    law = d.choice(["simple_harmonic", "modified_sine", "cycloidal"])
    return {"speed_rpm": d.choice([90.0, 120.0, 180.0]),
            "program": there_and_back(d.choice([14.0, 18.0, 22.0]), (120.0, 60.0, 120.0),
                                      (law, law), "deg"),
            "follower": arm(25.0, 130.0, 190.0),
            **sized(d, 90.0, angle_limit(35.0, 35.0), 50.0)}  # fmt: skip


def presser(d: Draw) -> Spec:
    """Presser of a warp-knitting machine: fast and short."""
    law = d.choice(["modified_trapezoid", "cycloidal", "polynomial_4_5_6_7"])
    return {"speed_rpm": d.choice([500.0, 800.0, 1100.0]),
            "program": there_and_back(d.choice([4.0, 6.0, 8.0]), (80.0, 30.0, 90.0), (law, law)),
            "follower": slide(d.choice([9.5, 11.0])),
            **sized(d, d.choice([30.0, 35.0]), angle_limit(20.0, 20.0), 25.0)}  # fmt: skip


def take_up(d: Draw) -> Spec:
    """Needle or thread lever of a sewing machine: a groove at high speed."""
    return {"speed_rpm": d.choice([1000.0, 1800.0, 2500.0]),
            "program": there_and_back(d.choice([5.0, 8.0]), (150.0, 0.0, 210.0),
                                      ("simple_harmonic", "simple_harmonic")),
            "follower": slide(d.choice([4.0, 5.0]), closure={"kind": "groove"}),
            "base_radius_mm": d.choice([16.0, 20.0])}  # fmt: skip


def gripper(d: Draw) -> Spec:
    """Gripper of a sheet-fed press, opened for a short while."""
    law = d.choice(["modified_sine", "polynomial_3_4_5"])
    return {"speed_rpm": d.choice([120.0, 180.0, 250.0]),
            "program": there_and_back(d.choice([8.0, 12.0]), (40.0, 20.0, 40.0), (law, law),
                                      "deg"),
            "follower": arm(d.choice([12.5, 15.0]), 60.0, d.choice([130.0, 140.0])),
            **sized(d, d.choice([85.0, 95.0]), angle_limit(35.0, 40.0), 60.0)}  # fmt: skip


def tappet(d: Draw) -> Spec:
    """Valve with a flat tappet, symmetric, on a ground camshaft."""
    half = d.choice([65.0, 70.0, 75.0])
    return {"speed_rpm": d.choice([1000.0, 1500.0, 2000.0]),
            "program": there_and_back(d.choice([7.0, 8.5, 9.5]), (half, 0.0, half),
                                      (d.choice(["polynomial_3_4_5_6", "spline"]),) * 2),
            "follower": {"kind": "translating_flat_face"},
            "base_radius_mm": d.choice([17.0, 19.0]),
            "load": {"kind": "slide", "moving_mass_kg": 0.16,
                     "spring": {"rate_n_per_mm": 30.0, "preload_n": 280.0}}}  # fmt: skip


def lifter(d: Draw) -> Spec:
    """Roller lifter of a diesel engine's valve."""
    half = d.choice([68.0, 75.0])
    return {"speed_rpm": d.choice([500.0, 750.0, 1000.0]),
            "program": there_and_back(d.choice([6.5, 7.5, 8.5]), (half, 0.0, half),
                                      (d.choice(["polynomial_3_4_5_6", "spline"]),) * 2),
            "follower": slide(d.choice([9.0, 11.0])), "base_radius_mm": d.choice([20.0, 24.0]),
            "load": {"kind": "slide", "moving_mass_kg": 0.45,
                     "spring": {"rate_n_per_mm": 40.0, "preload_n": 400.0}}}  # fmt: skip


def injector(d: Draw) -> Spec:
    """Plunger of a unit injection pump: up fast, down slowly."""
    up = d.choice([65.0, 75.0])
    return {"speed_rpm": d.choice([400.0, 700.0, 1000.0]),
            "program": there_and_back(d.choice([10.0, 12.0]), (up, 10.0, 120.0),
                                      ("modified_sine", "modified_sine")),
            "follower": slide(d.choice([12.0, 14.0])), "base_radius_mm": d.choice([26.0, 30.0]),
            "load": {"kind": "slide", "moving_mass_kg": 0.6,
                     "spring": {"rate_n_per_mm": 35.0, "preload_n": 400.0}}}  # fmt: skip


def picker(d: Draw) -> Spec:
    """Up and down of a pick-and-place unit: twice a turn, in a groove."""
    stroke, law = d.choice([25.0, 35.0, 45.0]), d.choice(["modified_sine", "scca"])
    half = [move("rise", 60.0, stroke, law), dwell(25.0), move("return", 60.0, stroke, law),
            dwell(35.0)]  # fmt: skip
    return {"speed_rpm": d.choice([35.0, 50.0, 70.0]), "program": half + half,
            "follower": slide(d.choice([13.0, 15.0]), closure={"kind": "groove"}),
            **sized(d, d.choice([70.0, 85.0]), angle_limit(35.0, 35.0), 40.0)}  # fmt: skip


def press_fit(d: Draw) -> Spec:
    """Ram that presses parts in: slow, with kilonewtons at the end of its stroke."""
    force = d.choice([1500.0, 3000.0, 5000.0])
    process = [
        {"angle_deg": a, "force_n": f}
        for a, f in ((0.0, 0.0), (90.0, 0.0), (120.0, force), (150.0, force), (150.0, 0.0))
    ]
    return {"speed_rpm": d.choice([20.0, 30.0, 40.0]),
            "program": there_and_back(d.choice([20.0, 30.0]), (120.0, 40.0, 110.0),
                                      ("modified_sine", "modified_sine")),
            "follower": slide(d.choice([26.0, 31.0])),
            "load": {"kind": "slide", "moving_mass_kg": d.choice([10.0, 20.0]), "process": process,
                     "spring": {"rate_n_per_mm": 8.0, "preload_n": 600.0}},
            "limits": [angle_limit(25.0, 30.0)],
            "shaft_diameter_mm": d.choice([50.0, 60.0])}  # fmt: skip


def beam(d: Draw) -> Spec:
    """Walking beam: the lift of a transfer, unhurried, with long dwells."""
    law = d.choice(["modified_sine", "polynomial_3_4_5", "modified_trapezoid"])
    return {"speed_rpm": d.choice([12.0, 20.0, 30.0]),
            "program": there_and_back(d.choice([20.0, 30.0, 40.0]), (70.0, 110.0, 70.0),
                                      (law, law)),
            "follower": slide(d.choice([20.0, 26.0])),
            **sized(d, d.choice([90.0, 110.0]), angle_limit(30.0, 30.0), 50.0)}  # fmt: skip


def cross_slide(d: Draw) -> Spec:
    """Cross slide of an automatic lathe: quick approach, even feed, quick return."""
    approach, feed = d.choice([12.0, 16.0]), d.choice([3.0, 5.0])
    return {"speed_rpm": d.choice([1.0, 2.0, 4.0]),
            "program": [move("rise", 70.0, approach, "cycloidal"),
                        move("rise", 120.0, feed, "cv50_modified_trapezoid"), dwell(20.0),
                        move("return", 70.0, approach + feed, "cycloidal"), dwell(80.0)],
            "follower": slide(d.choice([8.0, 10.0])),
            **sized(d, d.choice([55.0, 65.0]), angle_limit(35.0, 45.0), 25.0)}  # fmt: skip


def former(d: Draw) -> Spec:
    """Forming slide of a wire-bending machine, pulled back by a spring."""
    law = d.choice(["modified_sine", "modified_trapezoid", "polynomial_4_5_6_7"])
    return {"speed_rpm": d.choice([90.0, 140.0, 200.0]),
            "program": there_and_back(d.choice([12.0, 16.0, 22.0]), (90.0, 30.0, 100.0),
                                      (law, law)),
            "follower": slide(d.choice([15.0, 17.5])),
            "load": {"kind": "slide", "moving_mass_kg": d.choice([2.0, 3.5]),
                     "spring": {"rate_n_per_mm": 8.0, "preload_n": 350.0}},
            **sized(d, d.choice([60.0, 70.0]), angle_limit(30.0, 30.0), 40.0)}  # fmt: skip


def jaw(d: Draw) -> Spec:
    """Folding jaw of a tea-bag machine: quick arms with conjugate cams."""
    law = d.choice(["modified_sine", "polynomial_4_5_6_7"])
    closure = {"kind": "conjugate", "roller_radius_mm": 11.0, "arm_mm": 70.0}
    return {"speed_rpm": d.choice([150.0, 200.0, 300.0]),
            "program": there_and_back(d.choice([15.0, 20.0]), (90.0, 60.0, 90.0), (law, law),
                                      "deg"),
            "follower": arm(11.0, 70.0, d.choice([95.0, 105.0]), closure=closure),
            **sized(d, d.choice([48.0, 52.0]), angle_limit(40.0, 40.0), 25.0)}  # fmt: skip


def stapler(d: Draw) -> Spec:
    """Stitching head of a bindery: a blade down and up, and a long rest."""
    law = d.choice(["cycloidal", "modified_sine"])
    return {"speed_rpm": d.choice([150.0, 200.0, 280.0]),
            "program": there_and_back(d.choice([10.0, 14.0]), (70.0, 10.0, 70.0), (law, law)),
            "follower": slide(d.choice([11.0, 13.0]), closure={"kind": "groove"}),
            **sized(d, d.choice([45.0, 55.0]), angle_limit(30.0, 30.0), 30.0)}  # fmt: skip


def lesson(d: Draw) -> Spec:
    """A textbook's exercise, in inches turned to millimetres, with whatever follower it teaches."""
    inch = 25.4
    law = d.choice(["cycloidal", "simple_harmonic", "modified_sine", "polynomial_3_4_5"])
    follower = d.choice([slide(0.25 * inch), slide(0.5 * inch, 0.25 * inch),
                         {"kind": "translating_flat_face"}])  # fmt: skip
    return {"speed_rpm": d.choice([60.0, 100.0, 180.0]),
            "program": there_and_back(d.choice([0.5, 0.75, 1.0]) * inch, (90.0, 90.0, 90.0),
                                      (law, law)),
            "follower": follower, "base_radius_mm": d.choice([1.75, 2.0, 2.5]) * inch}  # fmt: skip


def dough(d: Draw) -> Spec:
    """Piston of a dough divider: slow, long and loaded."""
    return {"speed_rpm": d.choice([12.0, 15.0, 18.0, 25.0]),
            "program": there_and_back(d.choice([50.0, 70.0]), (140.0, 40.0, 120.0),
                                      ("modified_sine", "modified_sine")),
            "follower": slide(d.choice([31.0, 36.0]), closure={"kind": "groove"}),
            "load": {"kind": "slide", "moving_mass_kg": 25.0,
                     "process": [{"angle_deg": a, "force_n": f}
                                 for a, f in ((0.0, 0.0), (70.0, 2000.0), (140.0, 2000.0),
                                              (170.0, 0.0))]},
            "limits": [angle_limit(30.0, 35.0)], "shaft_diameter_mm": 60.0}  # fmt: skip


def pump(d: Draw) -> Spec:
    """Plunger pump: a harmonic up and down without a rest, under a flat face or a roller."""
    stroke = d.choice([8.0, 12.0, 16.0])
    follower = d.choice([{"kind": "translating_flat_face"}, slide(12.0)])
    return {"speed_rpm": d.choice([150.0, 300.0, 450.0]),
            "program": there_and_back(stroke, (180.0, 0.0, 180.0), ("simple_harmonic",) * 2),
            "follower": follower, "base_radius_mm": d.choice([25.0, 30.0]),
            "load": {"kind": "slide", "moving_mass_kg": 0.8,
                     "spring": {"rate_n_per_mm": 10.0, "preload_n": 150.0}}}  # fmt: skip


# What is rightly said, judged one by one: of a harmonic between dwells or between unequal halves
# the acceleration jumps; small base circles under tappets are pointed or undercut; of jaws whose
# base radius alone is given the counter roller's place is not seen to; a picker comes to 39°.
JUDGED: Final = {
    "shedding": {"jumps"}, "take_up": {"jumps"}, "lesson": {"jumps"}, "tappet": {"sharp_nose"},
    "jaw": {"sharp_nose", "pressure_angle"}, "picker": {"pressure_angle"},
}  # fmt: skip
TRADES: Final[tuple[Callable[[Draw], Spec], ...]] = (
    tucker, filler, sealer, shedding, presser, take_up, gripper, tappet, lifter, injector,
    picker, press_fit, beam, cross_slide, former, jaw, stapler, lesson, dough, pump,
)  # fmt: skip


def scenes() -> Iterator[tuple[str, Spec]]:
    """All scenes with a name each; the same at every call."""
    for trade in TRADES:
        draw = Draw(f"{SEED} {trade.__name__}")
        found = list[Spec]()
        while len(found) < EACH:
            spec = {**trade(draw), "proof": "quick"}
            if spec not in found:
                found.append(spec)
                yield f"{trade.__name__} {len(found)}", spec


def main() -> None:
    """Ask for all scenes and print what is said of them."""
    asked = argparse.ArgumentParser()
    asked.add_argument("--verbose", action="store_true")
    verbose, counts = asked.parse_args().verbose, Counter[str]()
    for name, spec in scenes():
        design = c.synthesise(c.DesignSpec.model_validate(spec))
        counts[f"status {design.status}"] += 1
        counts[f"worst {design.severity}"] += 1
        for one in design.warnings:
            counts[f"{one.code} {one.severity}"] += 1
            if verbose or one.severity != "note":
                sys.stdout.write(f"{name}: {one.severity} {one.code}: {one.sentence}\n")
    sys.stdout.writelines(f"{count:4} {what}\n" for what, count in sorted(counts.items()))


if __name__ == "__main__":
    main()
