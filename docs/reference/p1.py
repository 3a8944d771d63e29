"""Print the tables of p1.md: the true values of example 13-6, and how far the printed ones are off.

python docs/reference/p1.py
"""

from math import pi, sqrt

import numpy as np

from docs.reference.tables import number
from synthesis.catalogue.motion import Motion
from synthesis.catalogue.profile import cam_profile
from synthesis.spec.design_spec import DesignSpec

OMEGA = 10.0  # rad/s
MOVE = {"angle_deg": 60.0, "lift_mm": 30.0, "law": {"kind": "cycloidal"}}
SPEC = DesignSpec.model_validate(
    {
        "name": "Example 13-6",
        "speed_rpm": OMEGA * 60.0 / (2.0 * pi),
        "rotation": "ccw",
        "program": [
            {"kind": "rise", **MOVE},
            {"kind": "dwell", "angle_deg": 30.0},
            {"kind": "return", **MOVE},
            {"kind": "dwell", "angle_deg": 210.0},
        ],
        "follower": {"kind": "translating_roller", "roller_radius_mm": 10.0, "offset_mm": 20.0},
        "base_radius_mm": 50.0,
    }
)
SIZE = (20.0, sqrt(60.0**2 - 20.0**2))  # e, s0 = √(Rp² − e²)


def row(k: int) -> tuple[float, ...]:
    """S, v, a, pitch x y and profile x y at k degrees."""
    theta = np.radians([float(k)])
    p = cam_profile(Motion.of(SPEC.placed_segments()), SPEC.follower, SIZE, SPEC.rotation, theta)
    s, v, a = p.s[0, 0], p.s[1, 0] * OMEGA, p.s[2, 0] * OMEGA**2
    return s, v, a, p.pitch_x[0], p.pitch_y[0], p.x[0], p.y[0]


def main() -> None:
    print(
        "| θ ° | s mm | v mm/s | a mm/s² | pitch x mm | pitch y mm | profile x mm | profile y mm |"
    )
    print("|" + "--:|" * 8)
    for k in range(0, 361, 20):
        cells = [number(value, 4 if i == 2 else 6) for i, value in enumerate(row(k))]
        print("| " + " | ".join([str(k), *cells]) + " |")


if __name__ == "__main__":
    main()
