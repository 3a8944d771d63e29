"""A cam far smaller than the arm that it moves: rounding alone could put its points on the axis."""

from synthesis import DesignSpec, synthesise

SWING = 8.82e-5  # deg
BODY = {
    "speed_rpm": 60.0,
    "program": [
        {"kind": "dwell", "angle_deg": 180.0},
        {"kind": "rise", "angle_deg": 90.0, "lift_deg": SWING,
         "law": {"kind": "modified_trapezoid"}},
        {"kind": "return", "angle_deg": 90.0, "lift_deg": SWING, "law": {"kind": "parabolic"}},
    ],
    "follower": {
        "kind": "oscillating_roller", "sense": "opposite", "arm_mm": 1.03e-3,
        "roller_radius_mm": 0.0, "centre_distance_mm": 1.03e-3,
    },
    "limits": [
        {"kind": "pressure_angle", "rise_deg": 89.0, "return_deg": 89.0},
        {"kind": "outer_radius", "max_mm": 118.0},
    ],
}  # fmt: skip


def test_its_outer_radius_is_enclosed():
    design = synthesise(DesignSpec.model_validate(BODY))
    (outer,) = (one for one in design.extremes if one.limit == "outer_radius")
    assert outer.holds
    assert outer.value is not None
    assert outer.value < 1e-4
    assert design.status in ("optimal", "feasible")
