"""Print the tables of p6.md: reach, borders, what the limits leave, poses, torques.

python docs/reference/p6.py
"""

import json
from math import asin, degrees, hypot, radians, sin
from pathlib import Path

from docs.reference.tables import number, table
from synthesis.machines.linkages.arm import ArmSpec, PalletisingArm, analyse_arm

FOLDER = Path(__file__).resolve().parents[2] / "openapi/examples/linkages/palletising-arms"
BODY = json.loads((FOLDER / "irb-660.json").read_text(encoding="utf-8"))["value"]
REACH = 3150.0  # mm, as the maker states it
A2, A3 = BODY["upper_arm_mm"], BODY["forearm_mm"]
BESIDE = BODY["shoulder_offset_mm"] + BODY["wrist_offset_mm"]


def solve(**changes: object) -> PalletisingArm:
    return analyse_arm(ArmSpec.model_validate(BODY | changes))


P6 = solve()


def reported(value: float) -> str:
    return number(value, 3)


def reach() -> None:
    """a1 + a4 + √(a2² + a3² + 2 a2 a3 sin q), and the q of the stated reach."""
    stated = asin(((REACH - BESIDE) ** 2 - A2**2 - A3**2) / (2.0 * A2 * A3))
    rows = []
    for opening in (60.0, degrees(stated), 70.0, 80.0, 90.0):
        square = A2**2 + A3**2 + 2.0 * A2 * A3 * sin(radians(opening))
        found = solve(opening_deg={"min": -80.0, "max": opening}, poses=[])
        rows.append((number(opening, 4), reported(BESIDE + square**0.5), reported(found.reach_mm)))
    table(("largest q = θ2 − θ3 °", "formula mm", "reach mm"), *rows)


def border() -> None:
    (region,) = P6.regions
    rows = []
    for arc in region.border:
        values = (*arc.centre_mm, arc.radius_mm, arc.start_deg, arc.sweep_deg, *arc.from_mm)
        rows.append((arc.keeps.replace("_", " "), *(reported(value) for value in values)))
    table(("stands still", "centre r", "centre z", "radius", "from °", "sweep °", "begins r",
           "begins z"), *rows)  # fmt: skip


def size() -> None:
    (region,) = P6.regions
    ends = {"farthest": region.r_max, "nearest": region.r_min, "highest": region.z_max,
            "lowest": region.z_min}  # fmt: skip
    rows = [
        (
            name,
            reported(end.value_mm) + " mm",
            reported(end.upper_arm_deg),
            reported(end.forearm_deg),
        )
        for name, end in ends.items()
    ]
    rows += [("area", number(region.area_mm2 * 1e-6, 6) + " m²", "", ""),
             ("volume", number(region.volume_mm3 * 1e-9, 6) + " m³", "", "")]  # fmt: skip
    table(("quantity", "value", "θ2 °", "θ3 °"), *rows)


def openings() -> None:
    """What the assumed limit and the implied one do."""
    rows = []
    for name, limits in (
        ("−80° to 70°", {"min": -80.0, "max": 70.0}), ("to 70°", {"max": 70.0}),
        ("none", {}),
    ):  # fmt: skip
        found = solve(opening_deg=limits, poses=[])
        areas = ", ".join(f"{one.elbow} {number(one.area_mm2 * 1e-6, 4)}" for one in found.regions)
        lines = ", ".join(number(one.opening_deg, 0) + "°" for one in found.singular)
        rows.append((name, reported(found.reach_mm), areas, lines))
    table(("limits of q", "reach mm", "elbow and area m²", "in line at q"), *rows)


def poses() -> None:
    rows = []
    for pose in P6.poses:
        for one in pose.solutions:
            beyond = ", ".join(each.joint.replace("_", " ") for each in one.beyond)
            angles = (one.base_deg, one.upper_arm_deg, one.forearm_deg, one.tool_deg, one.in_line)
            r = hypot(pose.x_mm, pose.y_mm)
            rows.append((f"{pose.name}, {one.base} {one.elbow}", reported(r), reported(pose.z_mm),
                         *(reported(angle) for angle in angles), beyond))  # fmt: skip
    table(("pose", "r mm", "z mm", "A1 °", "θ2 °", "θ3 °", "A6 °", "cos q", "beyond"), *rows)


def torques() -> None:
    rows = []
    loads = {"its load alone": {"masses": []}, "its links alone": {"payload_kg": 0.0}, "both": {}}
    for name, changes in loads.items():
        found = solve(**changes)
        most = {one.axis: number(one.torque_nm, 1) for one in found.torques}
        (pick,) = (pose.solutions[0] for pose in found.poses if pose.name == "pick")
        rows.append((name, most["upper_arm"], most["forearm"], number(pick.torque_upper_nm, 1),
                     number(pick.torque_forearm_nm, 1)))  # fmt: skip
    table(("held", "axis 2 at most N·m", "axis 3 at most N·m", "axis 2 at *pick* N·m",
           "axis 3 at *pick* N·m"), *rows)  # fmt: skip


def main() -> None:
    reach()
    border()
    size()
    openings()
    poses()
    torques()


if __name__ == "__main__":
    main()
