"""Print the tables of p2.md: what the cam does, its jumps, what mends it, and the printed faults.

python docs/reference/p2.py
"""

import json
from math import degrees, pi, radians
from pathlib import Path

from docs.reference.tables import number, table
from synthesis import Analysis, DesignSpec, analyse

EXAMPLE = Path(__file__).resolve().parents[2] / "openapi/examples/analyses/p2-as-given.json"
SPEC = DesignSpec.model_validate(json.loads(EXAMPLE.read_text(encoding="utf-8"))["value"])
LIFT, RISE, BACK = 60.0, 100.0, 90.0  # mm, degrees
SIDES = {"left": "−", "right": "+", "both": ""}


def limits(found: Analysis) -> None:
    table(
        ("limit", "extreme", "at °", "allowed", "margin"),
        *(
            (
                e.limit.replace("_", " "), f"{number(e.value)}{e.unit.replace('deg', '°')}",
                number(e.angle_deg), number(e.bound), number(e.margin),
            )
            for e in found.extremes
            if e.limit.startswith("pressure")
        ),
    )  # fmt: skip


def curves(found: Analysis) -> None:
    rows = [("curve", "unit", "largest", "at °", "smallest", "at °")]
    for c in found.curves:
        if c.over == "turn" and c.curve != "jerk":
            ends = []
            for peak in (c.largest, c.smallest):
                given = peak is not None
                ends += [
                    number(peak.value, 6 if c.unit == "1/mm" else 4) if given else "",
                    f"{number(peak.angle_deg)}{SIDES[peak.side]}" if given else "",
                ]
            rows.append((c.curve.replace("_", " "), c.unit, *ends))
    table(*rows)


def jumps(found: Analysis) -> None:
    bent = {j.angle_deg: j for j in found.jumps if j.curve == "pitch_curvature"}
    table(
        ("θ °", "a before mm/s²", "a after", "pitch curvature before 1/mm", "after"),
        *(
            (
                f"{j.angle_deg:.0f}", number(j.before), number(j.after),
                number(bent[j.angle_deg].before, 6), number(bent[j.angle_deg].after, 6),
            )
            for j in found.jumps
            if j.curve == "acceleration"
        ),
    )  # fmt: skip


def mends(found: Analysis) -> None:
    table(
        ("offset", "offset mm", "base radius mm", "prime radius mm", "larger by mm"),
        *(
            (
                s.offset, number(s.dimensions["offset_mm"]), number(s.dimensions["base_radius_mm"]),
                number(s.dimensions["prime_radius_mm"]), number(s.base_radius_change_mm),
            )
            for s in found.remedy.sizes
        ),
    )  # fmt: skip


def faults(found: Analysis) -> None:
    rise, back = radians(RISE), radians(BACK)
    (angle,) = (c for c in found.curves if (c.curve, c.over) == ("pressure_angle", "turn"))
    turn = radians(angle.largest.value - angle.smallest.value)
    table(
        ("what", "as programmed", "right"),
        (
            "acceleration on the rise, 4h/β²", f"{number(4 * LIFT / RISE**2)} mm/deg²",
            f"{number(4 * LIFT / rise**2)} mm/rad²",
        ),
        (
            "largest speed on the return, πh/2β", f"{number(pi * LIFT / 2 / back**2)} (πh/2β²)",
            f"{number(pi * LIFT / 2 / back)} mm/rad",
        ),
        (
            "acceleration as the return begins, −π²h/2β²",
            f"+{number(pi**2 * LIFT / 2 / back**2)} mm/rad²",
            f"{number(-(pi**2) * LIFT / 2 / back**2)} mm/rad²",
        ),
        (
            "share of the roller's rotation left out, from peak to peak of the pressure angle",
            "0°", f"{number(degrees(turn))}°",
        ),
    )  # fmt: skip


def main() -> None:
    found = analyse(SPEC)
    for part in (limits, curves, jumps, mends, faults):
        part(found)


if __name__ == "__main__":
    main()
