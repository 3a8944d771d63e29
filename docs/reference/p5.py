"""Print the tables of p5.md: the shaper over a turn, its extremes, and what each fault costs.

python docs/reference/p5.py
"""

import json
from math import atan2, degrees, pi, radians
from pathlib import Path

import numpy as np

from docs.reference.tables import number, table
from synthesis.machines.linkages.shaper import ShaperSpec, SixBarShaper, analyse_or_size_shaper
from synthesis.machines.linkages.shaper.mechanism import Motion
from synthesis.machines.linkages.shaper.report import QUANTITIES, Quantity

EXAMPLE = Path(__file__).resolve().parents[2] / "openapi/examples/linkages/six-bar-shapers/p5.json"
BODY = json.loads(EXAMPLE.read_text(encoding="utf-8"))["value"]
MISSED = 0.033  # deg: how far from the dead centre the printed program starts


def solve(**changes: object) -> SixBarShaper:
    return analyse_or_size_shaper(ShaperSpec.model_validate(BODY | changes))


P5 = solve()


def motion(crank_deg: float, found: SixBarShaper = P5) -> Motion:
    return found.spec.shaper(found.dimensions).motion(np.float64(radians(crank_deg)))


def closed_forms() -> None:
    quick, swing = P5.quick_return, P5.guide_angle
    right, left = sorted(P5.dead_centres, key=lambda one: -one.ram_mm)
    table(
        ("quantity", "value"),
        ("guide's swing 2β, sin β = r/a", number(swing.max_deg - swing.min_deg) + "°"),
        ("stroke 2 L r/a", number(P5.stroke_mm) + " mm"),
        ("right dead centre, crank at −β", number(right.crank_deg - 360.0) + "°"),
        ("ram there, − √(c² − (H − L cos β)²) + L sin β", number(right.ram_mm) + " mm"),
        ("left dead centre, crank at 180° + β", number(left.crank_deg) + "°"),
        ("ram there, − √(c² − (H − L cos β)²) − L sin β", number(left.ram_mm) + " mm"),
        ("slow stroke, leftwards, 180° + 2β", number(quick.slow_deg) + "°"),
        ("quick stroke, 180° − 2β", number(quick.quick_deg) + "°"),
        ("quick-return ratio", number(quick.ratio, 6)),
        ("least transmission angle at the ram", number(P5.least_transmission_angle_deg) + "°"),
    )


def turn() -> None:
    """Every 30°; at 1 rad/s, rates by time are those by angle."""
    rows = []
    for crank in range(0, 360, 30):
        now = motion(crank)
        guide, coupler = (degrees(atan2(sin, cos)) for cos, sin in (now.guide, now.coupler))
        values = (
            guide, *(degrees(rate) for rate in now.guide_turn),
            coupler % 360.0, *(degrees(rate) for rate in now.coupler_turn), *now.ram,
        )  # fmt: skip
        rows.append((str(crank), *(number(float(value), 3) for value in values)))
    table(("φ °", "ψ °", "ψ' °/s", "ψ'' °/s²", "γ °", "γ' °/s", "γ'' °/s²",
           "x mm", "x' mm/s", "x'' mm/s²"), *rows)  # fmt: skip


def places(quantity: Quantity, crank_deg: float) -> str:
    """Where an extreme is: at its mirror image about the upright too, if the value is the same."""
    both = sorted((crank_deg, (540.0 - crank_deg) % 360.0))
    drive = P5.spec.drive
    first, second = (float(quantity.of(motion(each), drive, radians(each))) for each in both)
    twins = abs(first - second) < 1e-6 * abs(first) and both[1] - both[0] > 1e-3
    return " and ".join(number(each, 2) for each in (both if twins else [crank_deg]))


def extremes() -> None:
    rows = []
    for quantity, each in zip(QUANTITIES, P5.extremes, strict=True):
        ends = ((number(p.value), places(quantity, p.crank_deg))
                for p in (each.largest, each.smallest))  # fmt: skip
        rows.append((f"{each.quantity.replace('_', ' ')}, {each.unit}", *sum(ends, ())))
    table(("quantity", "largest", "at φ °", "smallest", "at φ °"), *rows)


def missed() -> None:
    """The program's turn begins beside the right dead centre."""
    right = max(P5.dead_centres, key=lambda one: one.ram_mm)
    slow = P5.quick_return.slow_deg
    rows = []
    for beside in (-MISSED, 0.0, MISSED):
        now = motion(right.crank_deg + beside)
        away = float(now.ram[0]) - right.ram_mm
        ratio = (slow - beside) / (360.0 - slow + beside)
        rows.append((number(beside, 3), number(float(now.ram[1])), number(away, 6),
                     number(ratio, 6)))  # fmt: skip
    table(("start beside the dead centre °", "ram's speed mm/s", "ram off mm",
           "ratio from there"), *rows)  # fmt: skip


def speeding_up() -> None:
    rows = []
    for alpha in (0.0, 0.1, -0.05):
        found = solve(acceleration_rad_per_s2=alpha)
        left = min(found.dead_centres, key=lambda one: one.ram_mm)
        of = {each.quantity: each for each in found.extremes}
        speed, bend = of["ram_velocity"].largest, of["ram_acceleration"].largest
        rows.append((
            number(alpha, 2), number(float(found.spec.drive.time(2.0 * pi))), number(left.time_s),
            number(speed.value, 3), number(speed.crank_deg, 2), number(bend.value, 3),
            number(bend.crank_deg, 2),
        ))  # fmt: skip
    table(("α rad/s²", "turn s", "left dead centre at s", "peak x' mm/s", "at φ °",
           "peak x'' mm/s²", "at φ °"), *rows)  # fmt: skip


def sliding() -> None:
    """The block's velocity along the guide beside the ram's, where either is largest or none."""
    right, left = sorted(P5.dead_centres, key=lambda one: -one.ram_mm)
    (ram,) = (each for each in P5.extremes if each.quantity == "ram_velocity")
    where = (
        ("crank upright", 90.0), ("left dead centre", left.crank_deg),
        ("ram fastest", ram.largest.crank_deg), ("crank hanging", 270.0),
        ("right dead centre", right.crank_deg),
    )  # fmt: skip
    rows = []
    for name, crank in where:
        now = motion(crank)
        rows.append((name, number(crank, 2), number(float(now.slide[1]), 1),
                     number(float(now.ram[1]), 1)))  # fmt: skip
    table(("where", "φ °", "sliding mm/s", "ram mm/s"), *rows)


def branches() -> None:
    rows = []
    for side in ("left", "right"):
        found = solve(ram_side=side)
        (ram,) = (each for each in found.extremes if each.quantity == "ram_velocity")
        ends = sorted(one.ram_mm for one in found.dead_centres)
        rows.append((
            side, *(number(end) for end in ends), number(float(motion(0.0, found).ram[1]), 3),
            number(ram.largest.value, 3), number(ram.largest.crank_deg, 2),
        ))  # fmt: skip
    table(("ram_side", "leftmost mm", "rightmost mm", "x' at φ = 0 mm/s", "peak x' mm/s",
           "at φ °"), *rows)  # fmt: skip


def times() -> None:
    rows = []
    for name, rpm in (("1 rad/s", BODY["speed_rpm"]), ("30 rpm", 30.0), ("60 rpm", 60.0)):
        found = solve(speed_rpm=rpm)
        left = min(found.dead_centres, key=lambda one: one.ram_mm)
        of = {each.quantity: each.largest.value for each in found.extremes}
        rows.append((name, number(radians(left.crank_deg)), number(left.time_s),
                     number(of["ram_velocity"], 3), number(of["ram_acceleration"], 2)))  # fmt: skip
    table(("crank", "left dead centre at rad", "at s", "peak x' mm/s", "peak x'' mm/s²"), *rows)


def main() -> None:
    closed_forms()
    turn()
    extremes()
    missed()
    speeding_up()
    sliding()
    branches()
    times()


if __name__ == "__main__":
    main()
