"""Forces of every follower family, against mechanics that knows none of the formulas."""

from __future__ import annotations

import numpy as np
import pytest

from synthesis.catalogue.forces.reduced import history
from synthesis.certify import report_forces
from synthesis.certify.quantities import MeasuredCam, force_quantity
from synthesis.studies.analyse import given_cam
from tests.catalogue.followers.samples import CASES, LIFTS
from tests.catalogue.forces.loads import edged, load_of, loaded

family = pytest.mark.parametrize(("kind", "sample"), CASES)
THETA = np.radians([3.1, 17.3, 48.9, 93.0, 97.9, 120.4, 133.3, 141.7, 190.2, 231.1, 256.0, 301.3])


def course_of_forces(asked, theta):
    cam, machine = given_cam(asked), asked.machine()
    return history(
        machine.follower, machine.load, machine.omega, cam.motion, cam.size, theta
    ), cam  # fmt: skip


@family
def test_the_drive_is_newton_s(kind: str, sample: int) -> None:
    """Positions alone, differentiated in time, and the load as it is told on the wire."""
    asked = loaded(kind, sample)
    found, cam = course_of_forces(asked, THETA)
    told, omega = load_of(kind, sample), asked.speed_rpm * 2.0 * np.pi / 60.0
    unit = np.max(cam.motion.curve(np.linspace(0.0, 6.28, 4001))) / LIFTS[kind]
    swings = "oscillating" in kind
    per = np.pi / 180.0 if swings else 1e-3  # rad or m in a unit of the wire
    step = 2e-5 / omega

    def at(time):
        return cam.motion.curve(THETA + omega * time) / unit * per

    velocity = (at(step) - at(-step)) / (2.0 * step)
    acceleration = (at(step) - 2.0 * at(0.0) + at(-step)) / step**2
    degrees = np.degrees(THETA)
    gap = 13.0 + 360.0 - 120.5
    low, high, after = (p["moment_n_m" if swings else "force_n"] for p in told["process"])
    process = np.where(
        (degrees >= 13.0) & (degrees < 120.5),
        low + (high - low) * (degrees - 13.0) / 107.5,
        after + (low - after) * ((degrees - 120.5) % 360.0) / gap,
    )
    rate, preload = told["spring"].values()
    side = asked.machine().load.side
    if swings:
        inertia, damping = told["moment_of_inertia_kg_m2"], told["damping_n_m_s_per_rad"]
        elastic, weight = rate * at(0.0), 0.0
    else:
        inertia, damping = told["moving_mass_kg"], told["damping_n_s_per_m"]
        elastic = rate * at(0.0) * 1e3
        weight = inertia * 9.80665 * np.cos(np.radians(37.0))
    whole = (
        inertia * acceleration + damping * velocity + elastic + side * preload + process + weight
    )
    along = 1.0 if not swings else 1e-3 * unit * 180.0 / np.pi  # lever of a force along the arc
    assert found.drive * along == pytest.approx(whole, rel=2e-5, abs=2e-5 * np.abs(whole).max())


@family
def test_the_contact_force_s_moment_is_the_torque(kind: str, sample: int) -> None:
    """The shaft bears the moment of what the follower presses with on the cam."""
    asked = loaded(kind, sample)
    found, cam = course_of_forces(asked, THETA)
    follower, s = asked.follower, cam.motion.derivatives(THETA)
    for flank in follower.flanks:
        (px, py), (dx, dy), *_ = flank.trace.position(s, cam.size)
        nx, ny = flank.trace.normal((dx + py, dy - px), s, cam.size)
        nx, ny = nx / np.hypot(nx, ny), ny / np.hypot(nx, ny)
        pushed = flank.side * found.contact[flank.name]  # along the outward normal
        moment = 1e-3 * pushed * (px * ny - py * nx)
        assert moment == pytest.approx(found.torque, rel=1e-9, abs=1e-9)
    work = np.trapezoid
    dense = np.linspace(0.0, 2.0 * np.pi, 20_001)
    turn, _ = course_of_forces(asked, dense)
    told = report_forces(cam.motion, asked.machine(), cam.size)
    assert told.torque.work_j == pytest.approx(work(turn.torque, dense), abs=1e-3)
    scale = abs(told.torque.process_work_j) + abs(told.torque.loss_j)
    assert abs(told.torque.balance_error_j) <= 1e-12 * scale
    lost = turn.damping * turn.s[1] * 1e-3
    assert told.torque.loss_j == pytest.approx(work(lost, dense), rel=1e-7)


@family
def test_two_ways_to_the_geometry_agree(kind: str, sample: int) -> None:
    """The judge's path of the traced point, and the followers' closed forms."""
    asked = loaded(kind, sample)
    found, cam = course_of_forces(asked, THETA)
    machine = asked.machine()
    finished = MeasuredCam.of(cam.motion, machine, cam.size)
    piece = finished.motion.curve.piece_of(THETA)
    for flank in asked.follower.flanks:

        def measured(name, flank=flank):
            mine = force_quantity(name, flank, finished)
            return finished.values([(mine, flank.path)], piece, THETA)[0]

        assert measured("contact_force") * flank.side == pytest.approx(
            found.contact[flank.name], rel=1e-11
        )
        assert measured("camshaft_torque") == pytest.approx(found.torque, rel=1e-11, abs=1e-12)
        if not edged(kind, sample):
            assert np.sqrt(np.maximum(measured("pressure_square"), 0.0)) == pytest.approx(
                found.pressure[flank.name], rel=1e-10
            )


@family
def test_extremes_and_arcs_are_those_of_a_dense_turn(kind: str, sample: int) -> None:
    asked = loaded(kind, sample, speed_rpm=611.0)
    dense = np.radians(np.linspace(0.0, 360.0, 36_001))
    turn, cam = course_of_forces(asked, dense)
    machine = asked.machine()
    told = report_forces(cam.motion, machine, cam.size)
    for flank in told.flanks:
        force = turn.contact[flank.flank]
        assert flank.largest_n.value == pytest.approx(force.max(), rel=2e-4)
        assert flank.smallest_n.value == pytest.approx(force.min(), rel=2e-4)
        if flank.largest_pressure_mpa is not None:
            pressure = turn.pressure[flank.flank].max()
            assert flank.largest_pressure_mpa.value == pytest.approx(pressure, rel=2e-4)
            assert flank.largest_pressure_mpa.value >= pressure * (1.0 - 1e-9)
    assert told.torque.largest_n_m.value == pytest.approx(turn.torque.max(), rel=2e-4)
    assert told.torque.smallest_n_m.value == pytest.approx(turn.torque.min(), rel=2e-4)
    pressed = machine.load.side * turn.drive
    if machine.load.pushed_both_ways:
        crossed = np.flatnonzero(np.sign(pressed[1:]) != np.sign(pressed[:-1]))
        assert np.degrees(dense[crossed]) == pytest.approx(told.changes_flank_deg, abs=0.006)
        assert not told.floats
        return
    away = sum((arc.end_deg - arc.start_deg) % 360.0 for arc in told.floats)
    assert away == pytest.approx(360.0 * np.mean(pressed <= 0.0), abs=0.02)
    assert bool(told.floats) == (told.float_onset_rpm is not None and told.float_onset_rpm < 611.0)
    slow = loaded(kind, sample, speed_rpm=0.999 * told.float_onset_rpm).machine()
    fast = loaded(kind, sample, speed_rpm=1.001 * told.float_onset_rpm).machine()
    assert not report_forces(cam.motion, slow, cam.size).floats
    assert report_forces(cam.motion, fast, cam.size).floats


@family
def test_the_pressure_is_hertz_s_on_the_profile(kind: str, sample: int) -> None:
    """Curvature of the profile's own points, by circles through three of them."""
    if edged(kind, sample):
        asked = loaded(kind, sample)
        cam = given_cam(asked)
        forces = report_forces(cam.motion, asked.machine(), cam.size)
        assert forces.flanks[0].largest_pressure_mpa is None
        return
    asked = loaded(kind, sample)
    theta = THETA[np.abs(np.degrees(THETA) - 120.4) > 1.0]
    turn, cam = course_of_forces(asked, theta)
    compliance = (1.0 - 0.29**2) / 203e3 + (1.0 - 0.3**2) / 206e3
    for flank in asked.follower.flanks:
        step = 1e-3

        def place(angle, flank=flank):
            at = cam.motion.derivatives(angle)
            (px, py), (dx, dy), *_ = flank.trace.position(at, cam.size)
            tx, ty = dx + py, dy - px
            long = np.hypot(tx, ty)
            x, y = (
                px + flank.side * flank.distance * ty / long,
                py - flank.side * (flank.distance * tx / long),
            )
            return np.stack([x * np.cos(angle) + y * np.sin(angle),
                             y * np.cos(angle) - x * np.sin(angle)])  # fmt: skip

        a, b, c = (place(theta + k * step) for k in (-1.0, 0.0, 1.0))
        u, v = b - a, c - b
        bend = (
            -2.0 * (u[0] * v[1] - u[1] * v[0]) / (np.hypot(*u) * np.hypot(*v) * np.hypot(*(c - a)))
        )  # clockwise: convex positive
        roller = 0.0 if flank.roller == 0.0 else 1.0 / flank.roller
        force = np.maximum(turn.contact[flank.name], 0.0)
        wanted = np.sqrt(
            np.maximum(force * (flank.side * bend + roller), 0.0) / (np.pi * 13.7 * compliance)
        )
        assert turn.pressure[flank.name] == pytest.approx(wanted, rel=2e-4, abs=0.05)
