"""The motion in numbers: against closed forms of the literature and quadrature by other routes."""

import math

import pytest

import synthesis as c
from synthesis.design.summary import MotionSummary

RPM, LIFT, RISE, RETURN = 200.0, 45.0, 120.0, 100.0


def summary(
    *laws: str | dict, dwells: tuple[float, float] = (60.0, 80.0), **fields
) -> MotionSummary:
    """Of a rise and a return by these laws, on a cam of a size that is given."""
    rise, back = (law if isinstance(law, dict) else {"kind": law} for law in laws)
    program = [
        {"kind": "rise", "angle_deg": RISE, "lift_mm": LIFT, "law": rise},
        {"kind": "dwell", "angle_deg": dwells[0]},
        {"kind": "return", "angle_deg": RETURN, "lift_mm": LIFT, "law": back},
        {"kind": "dwell", "angle_deg": dwells[1]},
    ]
    follower = {"kind": "translating_roller", "roller_radius_mm": 16.0, "offset_mm": 0.0}
    spec = c.DesignSpec.model_validate(
        {
            "speed_rpm": RPM,
            "program": program,
            "follower": follower,
            "base_radius_mm": 90.0,
            **fields,
        }
    )
    found = c.synthesise(spec).motion_summary
    assert found is not None
    return found


# Closed forms (VDI 2143-1; Norton, Cam Design and Manufacturing Handbook): peaks where the next
# derivative vanishes, mean squares by hand. Of the 3-4-5 polynomial v a = 1800 u³ (1 − 2x) with
# u = x (1 − x) is largest at u = 3/14.
PI = math.pi
MODIFIED_SINE = {
    "Cv": 4.0 * PI / (4.0 + PI), "Ca": 4.0 * PI**2 / (4.0 + PI), "Cj": 16.0 * PI**3 / (4.0 + PI),
}  # fmt: skip
CYCLOIDAL = {
    "Cv": 2.0, "Ca": 2.0 * PI, "Cj": 4.0 * PI**2, "Cva": 3.0 * math.sqrt(3.0) / 2.0 * PI,
    "Ea": 2.0 * PI**2, "Ej": 8.0 * PI**4,
}  # fmt: skip
POLYNOMIAL_3_4_5 = {
    "Cv": 15.0 / 8.0, "Ca": 10.0 / math.sqrt(3.0), "Cj": 60.0, "Ea": 120.0 / 7.0, "Ej": 720.0,
    "Cva": 1800.0 * 27.0 / 2744.0 / math.sqrt(7.0),
}  # fmt: skip


@pytest.mark.parametrize(
    ("law", "known"),
    [
        ("modified_sine", MODIFIED_SINE),
        ("cycloidal", CYCLOIDAL),
        ("polynomial_3_4_5", POLYNOMIAL_3_4_5),
    ],
)
def test_coefficients_are_those_of_the_literature(law, known):
    found = summary(law, law).moves
    for move in found:
        for name, value in known.items():
            assert getattr(move.coefficients, name) == pytest.approx(value, rel=1e-12), name
    assert [move.reference.law for move in found] == ["modified_sine", "modified_sine"]
    assert found[0].reference.coefficients.Ca == pytest.approx(MODIFIED_SINE["Ca"], rel=1e-12)
