"""The same textbook formulas at sizes that ask for digits: tiny and huge lifts, steep and short.

Rounding of the cam angle itself is allowed for: an angle of one turn is known to 4e-16 rad, which
moves each quantity by that times its slope.
"""

from decimal import Decimal
from itertools import pairwise
from math import sqrt

import numpy as np
import pytest

from synthesis.catalogue.motion import Motion
from synthesis.catalogue.profile import cam_profile
from synthesis.spec.design_spec import DesignSpec
from tests.validation.textbook import OffsetRoller

CASES = {
    "an ordinary cam": OffsetRoller(
        h="31.7", rise="67.3", dwell="28.9", prime="61.3", e="-17.9", Rr="9.7", omega=1
    ),
    "rise of 1 degree": OffsetRoller(
        h="0.37", rise=1, dwell="13.1", prime="41.9", e="7.3", Rr="5.9", omega=1
    ),
    "lift a millionth of the base radius": OffsetRoller(
        h="0.0000531", rise="57.1", dwell="31.3", prime="53.7", e="11.3", Rr="8.3", omega=1
    ),
    "lift ten times the base radius": OffsetRoller(
        h="173.3", rise="97.7", dwell="31.3", prime="17.1", e="3.7", Rr="1.9", omega=1
    ),
    "offset nearly the prime radius": OffsetRoller(
        h="23.3", rise="88.7", dwell="31.3", prime="47", e="46.99997", Rr="8.3", omega=1
    ),
    "a cam of micrometres": OffsetRoller(
        h="0.003", rise="67.3", dwell="28.9", prime="0.0061", e="0.0017", Rr="0.0009", omega=1
    ),
    "a cam of metres": OffsetRoller(
        h="3170", rise="67.3", dwell="28.9", prime="6130", e="1790", Rr="970", omega=1
    ),
    "no dwell above": OffsetRoller(
        h="31.7", rise="67.3", dwell=0, prime="61.3", e="17.9", Rr="9.7", omega=1
    ),
}


def product(case: OffsetRoller, degrees: np.ndarray):
    move = {"angle_deg": float(case.rise), "lift_mm": float(case.h), "law": {"kind": "cycloidal"}}
    spec = DesignSpec.model_validate(
        {
            "program": [
                {"kind": "rise", **move},
                {"kind": "dwell", "angle_deg": float(case.dwell)},
                {"kind": "return", **move},
                {"kind": "dwell", "angle_deg": float(360 - 2 * case.rise - case.dwell)},
            ],
            "follower": {
                "kind": "translating_roller",
                "roller_radius_mm": float(case.Rr),
                "offset_mm": float(case.e),
            },
            "base_radius_mm": float(case.prime - case.Rr),
        }
    )
    s0 = sqrt((case.prime - case.e) * (case.prime + case.e))
    size = (float(case.e), s0)
    return cam_profile(
        Motion.of(spec.placed_segments()), spec.follower, size, "ccw", np.radians(degrees)
    )


def angles(case: OffsetRoller) -> np.ndarray:
    """Inside each segment, near its ends and away from them."""
    ends = np.cumsum([0.0, *map(float, (case.rise, case.dwell, case.rise)), 360.0])
    ends[-1] = 360.0
    parts = np.array([1e-6, 0.013, 0.11, 0.237, 0.41, 0.5037, 0.637, 0.773, 0.918, 0.9997])
    return np.concatenate([a + (b - a) * parts for a, b in pairwise(ends) if b > a])


@pytest.mark.parametrize("name", CASES)
def test_positions_slopes_pressure_angle_and_curvature(name: str):
    case = CASES[name]
    degrees = angles(case)
    p = product(case, degrees)
    found = {
        "s": p.s[0],
        "v": p.s[1],
        "a": p.s[2],
        "pitch x": p.pitch_x,
        "pitch y": p.pitch_y,
        "profile x": p.x,
        "profile y": p.y,
        "tan of pressure angle": np.tan(p.pressure_angle),
        "curvature": p.curvature,
    }
    step = Decimal("1e-9")
    truth = [case.at(Decimal(float(angle))) for angle in degrees]
    beside = [case.at(Decimal(float(angle)) + step) for angle in degrees]
    for column, values in found.items():
        want = np.array([float(row[column]) for row in truth])
        slope = np.array(
            [float((b[column] - t[column]) / step) for t, b in zip(truth, beside, strict=True)]
        )
        allowed = 1e-13 * np.max(abs(want)) + 1e-13 * abs(slope)  # 1e-13°: the angle's rounding
        worst = int(np.argmax(abs(values - want) - allowed))
        assert np.all(abs(values - want) <= allowed), (
            f"{column} at {degrees[worst]}°: {values[worst]}, truly {want[worst]}"
        )
