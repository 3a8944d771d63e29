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


def course_of_forces(question, theta):
    cam, machine = given_cam(question), question.machine()
    return history(
        machine.follower, machine.load, machine.omega, cam.motion, cam.size, theta
    ), cam  # fmt: skip


@family
def test_the_drive_is_newton_s(kind: str, sample: int) -> None:
    """Positions alone, differentiated in time, and the load as it is told on the wire."""
    question = loaded(kind, sample)
    found, cam = course_of_forces(question, THETA)
    reported, omega = load_of(kind, sample), question.speed_rpm * 2.0 * np.pi / 60.0
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
    low, high, after = (p["moment_n_m" if swings else "force_n"] for p in reported["process"])
    process = np.where(
        (degrees >= 13.0) & (degrees < 120.5),
        low + (high - low) * (degrees - 13.0) / 107.5,
        after + (low - after) * ((degrees - 120.5) % 360.0) / gap,
    )
    rate, preload = reported["spring"].values()
    side = question.machine().load.side
    if swings:
        inertia, damping = reported["moment_of_inertia_kg_m2"], reported["damping_n_m_s_per_rad"]
        elastic, weight = rate * at(0.0), 0.0
    else:
        inertia, damping = reported["moving_mass_kg"], reported["damping_n_s_per_m"]
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
    question = loaded(kind, sample)
    found, cam = course_of_forces(question, THETA)
    follower, s = question.follower, cam.motion.derivatives(THETA)
    for flank in follower.flanks:
        (px, py), (dx, dy), *_ = flank.trace.position(s, cam.size)
        nx, ny = flank.trace.normal((dx + py, dy - px), s, cam.size)
        nx, ny = nx / np.hypot(nx, ny), ny / np.hypot(nx, ny)
        pushed = flank.side * found.contact[flank.name]  # along the outward normal
        moment = 1e-3 * pushed * (px * ny - py * nx)
        assert moment == pytest.approx(found.torque, rel=1e-9, abs=1e-9)
    work = np.trapezoid
    dense = np.linspace(0.0, 2.0 * np.pi, 20_001)
    turn, _ = course_of_forces(question, dense)
    reported = report_forces(cam.motion, question.machine(), cam.size)
    assert reported.torque.work_j == pytest.approx(work(turn.torque, dense), abs=1e-3)
    scale = abs(reported.torque.process_work_j) + abs(reported.torque.loss_j)
    assert abs(reported.torque.balance_error_j) <= 1e-12 * scale
    lost = turn.damping * turn.s[1] * 1e-3
    assert reported.torque.loss_j == pytest.approx(work(lost, dense), rel=1e-7)


@family
def test_two_ways_to_the_geometry_agree(kind: str, sample: int) -> None:
    """The judge's path of the traced point, and the followers' closed forms."""
    question = loaded(kind, sample)
    found, cam = course_of_forces(question, THETA)
    machine = question.machine()
    finished = MeasuredCam.of(cam.motion, machine, cam.size)
    piece = finished.motion.curve.piece_of(THETA)
    for flank in question.follower.flanks:

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
    question = loaded(kind, sample, speed_rpm=611.0)
    dense = np.radians(np.linspace(0.0, 360.0, 36_001))
    turn, cam = course_of_forces(question, dense)
    machine = question.machine()
    reported = report_forces(cam.motion, machine, cam.size)
    for flank in reported.flanks:
        force = turn.contact[flank.flank]
        assert flank.largest_n.value == pytest.approx(force.max(), rel=2e-4)
        assert flank.smallest_n.value == pytest.approx(force.min(), rel=2e-4)
        assert (flank.largest_pressure_mpa is None) == edged(kind, sample)  # without a radius
        if flank.largest_pressure_mpa is not None:
            pressure = turn.pressure[flank.flank].max()
            assert flank.largest_pressure_mpa.value == pytest.approx(pressure, rel=2e-4)
            assert flank.largest_pressure_mpa.value >= pressure * (1.0 - 1e-9)
    assert reported.torque.largest_n_m.value == pytest.approx(turn.torque.max(), rel=2e-4)
    assert reported.torque.smallest_n_m.value == pytest.approx(turn.torque.min(), rel=2e-4)
    pressed = machine.load.side * turn.drive
    if machine.load.pushed_both_ways:
        crossed = np.flatnonzero(np.sign(pressed[1:]) != np.sign(pressed[:-1]))
        assert np.degrees(dense[crossed]) == pytest.approx(reported.changes_flank_deg, abs=0.006)
        assert not reported.floats
        return
    away = sum((arc.end_deg - arc.start_deg) % 360.0 for arc in reported.floats)
    assert away == pytest.approx(360.0 * np.mean(pressed <= 0.0), abs=0.02)
    assert bool(reported.floats) == (
        reported.float_onset_rpm is not None and reported.float_onset_rpm < 611.0
    )
    slow = loaded(kind, sample, speed_rpm=0.999 * reported.float_onset_rpm).machine()
    fast = loaded(kind, sample, speed_rpm=1.001 * reported.float_onset_rpm).machine()
    assert not report_forces(cam.motion, slow, cam.size).floats
    assert report_forces(cam.motion, fast, cam.size).floats


@family
def test_the_pressure_is_hertz_s_on_the_profile(kind: str, sample: int) -> None:
    """Curvature of the profile's own points, by circles through three of them."""
    if edged(kind, sample):
        question = loaded(kind, sample)
        cam = given_cam(question)
        forces = report_forces(cam.motion, question.machine(), cam.size)
        assert forces.flanks[0].largest_pressure_mpa is None
        return
    question = loaded(kind, sample)
    theta = THETA[np.abs(np.degrees(THETA) - 120.4) > 1.0]
    turn, cam = course_of_forces(question, theta)
    compliance = (1.0 - 0.29**2) / 203e3 + (1.0 - 0.3**2) / 206e3
    for flank in question.follower.flanks:
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
