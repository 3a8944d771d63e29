"""The judge on cams with an arm: enclosures against dense sampling of complex numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from synthesis.catalogue.followers import OscillatingRoller
from synthesis.catalogue.laws import LAWS
from synthesis.catalogue.limits import LIMITS, Machine
from synthesis.catalogue.objectives import BaseRadius
from synthesis.certify import certify, certify_size, measure_objective
from synthesis.spec.design_spec import DesignSpec
from tests.catalogue.followers.samples import spec
from tests.certify.cams import motion_of, spline

LIMIT = {limit.model_fields["kind"].default: limit for limit in LIMITS}
OMEGA = 14.35
GRID = 200_001


@dataclass(frozen=True)
class ArmCam:
    sense: str = "opposite"
    psi: float = 1.17
    swing: float = 0.61
    arm: float = 81.3
    d: float = 107.9
    roller: float = 17.9
    law: str = "modified_sine"
    fixed: bool = True

    @property
    def motion(self):
        law = LAWS[self.law].curve("rise") if self.law in LAWS else None
        law = law or spline(5, np.linspace(0.0, 1.0, 9))
        back = LAWS["cycloidal"].curve("return")
        lift = self.arm * self.swing
        return motion_of([("rise", 97.0, lift, law), ("dwell", 41.0, 0.0, None),
                          ("return", 119.0, lift, back), ("dwell", 103.0, 0.0, None)])  # fmt: skip

    @property
    def machine(self) -> Machine:
        follower = OscillatingRoller(
            arm_mm=self.arm, centre_distance_mm=self.d if self.fixed else None,
            roller_radius_mm=self.roller, sense=self.sense, pivot_direction_deg=23.0,
        )  # fmt: skip
        return Machine(follower, OMEGA)

    @property
    def size(self) -> tuple[float, ...]:
        if self.fixed:
            return (self.arm * self.psi,)
        return self.d * np.cos(self.psi), self.d * np.sin(self.psi)

    def dense(self) -> dict[str, np.ndarray]:
        """Quantities by complex numbers: the centre, its tangent and their derivatives."""
        theta = np.linspace(0.0, 2.0 * np.pi, GRID)
        s = self.motion.derivatives(theta)
        sigma = {"opposite": 1.0, "same": -1.0}[self.sense]
        phi = s / self.arm
        back = np.radians(23.0) + np.pi - sigma * (self.psi + phi[0])
        pivot, arm = self.d * np.exp(1j * np.radians(23.0)), self.arm * np.exp(1j * back)
        # in the cam's frame c = (pivot + arm) e^{−iθ}; the arm turns by −σφ' − 1 in all
        turn, on = -1j * sigma * phi[1], np.exp(-1j * theta)
        c1 = (turn * arm - 1j * (pivot + arm)) * on
        c2 = (
            (-1j * sigma * phi[2] + turn * turn) * arm - 2j * turn * arm - (pivot + arm)
        ) * on  # fmt: skip
        normal = 1j * c1 / abs(c1)  # run clockwise
        drive = -1j * sigma * arm / abs(arm) * on
        return {
            "alpha": np.degrees(np.angle(normal / drive)),
            "curvature": -np.imag(np.conj(c1) * c2) / abs(c1) ** 3,
            "radius": abs(pivot + arm),
            "psi": np.degrees(self.psi + phi[0]),
        }


CAMS = [
    ArmCam(),
    ArmCam(sense="same", law="polynomial_3_4_5"),
    ArmCam(fixed=False, psi=0.83, law="double_harmonic"),
    ArmCam(sense="same", fixed=False, psi=1.41, swing=0.35, arm=63.1),
    ArmCam(sense="same", arm=140.7, roller=0.0, law="parabolic"),
    ArmCam(law="spline"),
]


def judge(cam: ArmCam, *limits) -> dict:
    return {e.limit: e for e in certify(cam.motion, cam.machine, cam.size, limits)}


@pytest.mark.parametrize("cam", CAMS)
def test_the_extremes_are_those_of_the_cam(cam: ArmCam):
    found = judge(
        cam,
        LIMIT["pressure_angle"](rise_deg=89.0, return_deg=89.0, dwell_deg=89.0),
        LIMIT["profile_radius"](min_mm=0.001), LIMIT["cutter_radius"](radius_mm=1e5),
        LIMIT["outer_radius"](max_mm=1e4),
    )  # fmt: skip
    dense = cam.dense()
    alpha = max(abs(found[f"pressure_angle_{kind}"].value) for kind in ("rise", "return", "dwell"))
    assert alpha == pytest.approx(np.max(abs(dense["alpha"])), abs=1e-5)
    sharpest = 1.0 / np.max(dense["curvature"])
    assert found["profile_radius"].value == pytest.approx(sharpest - cam.roller, rel=1e-4)
    if np.min(dense["curvature"]) < 0.0:
        hollow = cam.roller - 1.0 / np.min(dense["curvature"])
        assert found["cutter_radius"].value == pytest.approx(hollow, rel=1e-3)
    outer = np.max(dense["radius"]) - cam.roller
    assert found["outer_radius"].value == pytest.approx(outer, rel=1e-12)
    nearer = min((np.min(dense["psi"]), np.max(dense["psi"])), key=lambda psi: min(psi, 180 - psi))
    assert found["reach"].value == pytest.approx(nearer, rel=1e-12)
    assert found["reach"].unit == "deg"
    prime = measure_objective("prime_radius", cam.motion, cam.machine, cam.size)
    base = BaseRadius().to_wire(prime.value, cam.machine)
    assert base + cam.roller == pytest.approx(np.min(dense["radius"]), rel=1e-12)
    assert prime.lower <= prime.value <= prime.upper
    slope = measure_objective("pressure_slope", cam.motion, cam.machine, cam.size)
    assert np.degrees(np.arctan(slope.value)) <= alpha + 1e-9
    for extreme in found.values():
        assert extreme.width <= 1e-5 * max(abs(extreme.value or 1.0), 1.0), extreme


@pytest.mark.parametrize(
    ("swing", "holds"), [(np.pi - 1.17 - 1e-9, True), (np.pi - 1.17 + 1e-9, False)]
)
def test_an_arm_stretched_along_the_line_of_centres_does_not_stand(swing: float, holds: bool):
    for fixed in (True, False):
        found = judge(ArmCam(swing=swing, fixed=fixed))
        assert found["reach"].holds is holds
        assert found["reach"].bound == 180.0
        assert found["reach"].value == pytest.approx(180.0, abs=1e-6)
        assert 97.0 <= found["reach"].angle_deg <= 97.0 + 41.0


def test_an_arm_on_the_wrong_side_does_not_stand():
    for fixed in (True, False):
        found = judge(ArmCam(psi=-0.2, swing=0.5, fixed=fixed))
        assert not found["prime_circle_angle"].holds
        assert not found["reach"].holds
        assert found["reach"].bound == 0.0


def test_a_roller_larger_than_the_prime_radius_leaves_no_cam():
    found = judge(ArmCam(roller=200.0))
    assert not found["base_radius_positive"].holds


def test_the_dimensions_of_an_arm_are_held_against_their_ranges():
    follower = {
        "kind": "oscillating_roller", "arm_mm": 81.3, "roller_radius_mm": 17.9,
        "centre_distance_mm": {"min": 90.0, "max": 120.0},
        "initial_angle_deg": {"min": 50.0, "max": 70.0},
    }  # fmt: skip
    question = spec("oscillating_roller", follower=follower, base_radius_mm={"min": 60.0})
    assert isinstance(question, DesignSpec)

    def broken(d: float, angle: float) -> list[str]:
        size = d * np.cos(np.radians(angle)), d * np.sin(np.radians(angle))
        found = {e.limit: e for e in certify_size(question, size)}
        assert found["centre_distance"].unit == "mm"
        assert found["initial_angle"].unit == "deg"
        assert found["initial_angle"].field == "follower/initial_angle_deg"
        return [name for name, e in found.items() if not e.holds]

    assert broken(107.9, 61.3) == []
    assert broken(89.999, 69.0) == ["centre_distance"]
    assert broken(107.9, 70.001) == ["initial_angle"]
    assert broken(100.0, 49.9) == ["initial_angle"]
    assert broken(91.0, 50.1) == ["base_radius"]
