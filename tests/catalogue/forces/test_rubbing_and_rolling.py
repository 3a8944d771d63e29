"""Friction in the guide, speed and life of rollers, against equilibrium and kinematics."""

from __future__ import annotations

import numpy as np
import pytest

from synthesis.catalogue.forces.reduced import history
from synthesis.certify import report_forces
from synthesis.numerics.taylor import Taylor
from synthesis.studies.analyse import given_cam
from tests.catalogue.followers.samples import CASES, spec
from tests.catalogue.forces.loads import SLIDE, edged, loaded

RUBBED = SLIDE | {
    "friction": {"coefficient": 0.13, "overhang_mm": 47.0, "bearing_length_mm": 61.0}
}  # fmt: skip
ROLLERS = [case for case in CASES if "roller" in case[0] and not edged(*case)]


def test_friction_is_that_of_a_slide_held_at_two_places() -> None:
    question = spec("translating_roller", 0, load=RUBBED)
    cam, machine = given_cam(question), question.machine()
    theta = np.radians([11.0, 48.3, 88.8, 113.0, 151.0, 203.7, 246.1, 300.0])
    found = history(machine.follower, machine.load, machine.omega, cam.motion, cam.size, theta)
    e, s0 = cam.size
    for k, angle in enumerate(np.degrees(theta)):
        s, v = found.s[0, k], found.s[1, k]
        lean = np.arctan2(v - e, s0 + s)
        near = 47.0 - s  # from the roller to the guide
        # along the slide, across it, and moments about the roller's centre; reactions across
        sense = 1.0 if angle < 97.3 else -1.0 if 138.5 < angle < 257.4 else 0.0
        signs = np.sign(lean) * np.array([1.0, -1.0])
        rows = [
            [np.cos(lean), *(-sense * 0.13 * signs)],
            [-np.sin(lean), 1.0, 1.0],
            [0.0, near, near + 61.0],
        ]
        n, one, other = np.linalg.solve(rows, [found.drive[k], 0.0, 0.0])
        assert np.sign(one) == np.sign(lean)
        assert np.sign(other) == -np.sign(lean)
        assert found.contact[""][k] == pytest.approx(n, rel=1e-12)
        assert found.friction[k] == pytest.approx(
            sense * 0.13 * (abs(one) + abs(other)), abs=1e-9 * n
        )


def test_with_friction_extremes_and_energy_hold_too() -> None:
    question = spec("translating_roller", 0, load=RUBBED)
    cam, machine = given_cam(question), question.machine()
    reported = report_forces(cam.motion, machine, cam.size)
    theta = np.radians(np.linspace(0.0, 360.0, 36_001))
    turn = history(machine.follower, machine.load, machine.omega, cam.motion, cam.size, theta)
    assert reported.flanks[0].largest_n.value == pytest.approx(turn.contact[""].max(), rel=2e-4)
    assert reported.flanks[0].smallest_n.value == pytest.approx(turn.contact[""].min(), rel=2e-4)
    assert reported.torque.largest_n_m.value == pytest.approx(turn.torque.max(), rel=2e-4)
    plain = report_forces(cam.motion, loaded("translating_roller", 0).machine(), cam.size)
    assert reported.torque.loss_j > plain.torque.loss_j * 1.5
    assert abs(reported.torque.balance_error_j) <= 1e-9 * reported.torque.loss_j


@pytest.mark.parametrize(("kind", "sample"), ROLLERS)
def test_rollers_roll_without_slip(kind: str, sample: int) -> None:
    """Cam and roller have one velocity where they touch; the pin turns with the follower."""
    question = loaded(kind, sample)
    cam, machine = given_cam(question), question.machine()
    theta = np.radians([5.7, 33.0, 71.2, 120.0, 160.3, 222.2, 288.8])
    found = history(machine.follower, machine.load, machine.omega, cam.motion, cam.size, theta)
    step = 1e-5
    for flank in question.follower.flanks:

        def at(angle, flank=flank):
            s = cam.motion.derivatives(angle)
            (x, y), *_ = flank.trace.position(s, cam.size)
            (gx, gy), _ = flank.trace.drive_direction(s, cam.size)
            return np.array([x, y]) + 0.0 * angle, np.arctan2(gy, gx) + 0.0 * angle

        (ahead, turned), (behind, before) = at(theta + step), at(theta - step)
        (place, _), rate = at(theta), (ahead - behind) / (2.0 * step)
        pin = (np.unwrap([before, turned], axis=0)[1] - before) / (2.0 * step)
        # the path on the cam, and its normal in the machine
        tx, ty = rate[0] + place[1], rate[1] - place[0]
        along = np.array([tx, ty]) / np.hypot(tx, ty)
        normal = np.array([-along[1], along[0]])
        arm = -flank.side * flank.roller * normal  # from the roller's centre to the contact
        touch = place + arm
        surface = np.array([-touch[1], touch[0]])  # the cam turns by 1 ccw
        # v_p + Ω × arm = surface along the tangent
        lack = np.sum((surface - rate) * along, axis=0)
        spin = lack / (-arm[1] * along[0] + arm[0] * along[1])
        wanted = np.abs(spin - pin) * machine.omega
        assert found.rolling[flank.name] == pytest.approx(wanted, rel=1e-7)


def test_the_life_is_the_catalogue_s() -> None:
    question = loaded("translating_roller", 0)
    cam, machine = given_cam(question), question.machine()
    (reported,) = report_forces(cam.motion, machine, cam.size).rollers
    theta = np.radians((np.arange(36_000) + 0.5) / 100.0)
    turn = history(machine.follower, machine.load, machine.omega, cam.motion, cam.size, theta)
    borne, speed = turn.contact[""], turn.rolling[""] * 60.0 / (2.0 * np.pi)
    equal = (np.mean(borne ** (10 / 3) * speed) / np.mean(speed)) ** 0.3
    assert reported.mean_speed_rpm == pytest.approx(np.mean(speed), rel=1e-6)
    assert reported.largest_speed_rpm == pytest.approx(np.max(speed), rel=1e-3)
    assert reported.equivalent_load_n == pytest.approx(equal, rel=1e-4)
    assert reported.life_million_turns == pytest.approx((9_600.0 / equal) ** (10 / 3), rel=1e-3)
    hours = reported.life_million_turns * 1e6 / (np.mean(speed) * 60.0)
    assert reported.life_hours == pytest.approx(hours, rel=1e-6)
    # on a dwell cam and roller are two wheels
    still = history(
        machine.follower, machine.load, machine.omega, cam.motion, cam.size, [np.radians(320.0)]
    )
    assert still.rolling[""][0] == pytest.approx(machine.omega * 41.9 / 9.3, rel=1e-12)


def test_the_model_of_an_absolute_value_holds_it() -> None:
    rng = np.random.default_rng(7)
    c0, c1, c2 = rng.normal(size=(3, 200)) * np.array([[0.7], [0.5], [0.3]])
    rem = 0.1 * rng.random(200)
    model = Taylor.of(c0, c1, c2, rem)
    found = np.abs(model)
    for t in np.linspace(-1.0, 1.0, 41):
        for shift in (-1.0, 0.0, 1.0):
            value = np.abs(c0 + c1 * t + c2 * t * t + shift * rem)
            held = found.c0 + found.c1 * t + found.c2 * t * t
            assert np.all(np.abs(value - held) <= found.rem * (1.0 + 1e-12))
            assert np.all(value <= found.mag * (1.0 + 1e-12))
    known = np.abs(c0) > np.abs(c1) + np.abs(c2) + rem
    assert 20 < np.count_nonzero(known) < 180
    assert np.all(found.rem[known] == model.rem[known])


def test_in_a_groove_the_roller_turns_back_where_it_changes_flank() -> None:
    question = loaded("translating_roller", 3)
    cam, machine = given_cam(question), question.machine()
    (reported,) = report_forces(cam.motion, machine, cam.size).rollers
    theta = np.radians((np.arange(36_000) + 0.5) / 100.0)
    turn = history(machine.follower, machine.load, machine.omega, cam.motion, cam.size, theta)
    inner = turn.drive > 0.0
    assert 0.0 < np.mean(inner) <= 1.0
    speed = np.where(inner, turn.rolling["inner"], turn.rolling["outer"])
    assert reported.mean_speed_rpm == pytest.approx(np.mean(speed) * 60.0 / (2.0 * np.pi), rel=1e-4)
    assert np.all(turn.rolling["outer"] > turn.rolling["inner"])
