"""Every figure of the forces equals an independent evaluation to 1e-9, and none is left out.

Newton's law on a slide, worked out here: of the product nothing but its answer is used. Extremes
are sought on samples, then between the best three; integrals are Gauss's on every segment. Figures
of the motion are held to the same by ``test_motion_summary``, of the cam as a body by
``test_cam_geometry``, of rolling and sliding by ``test_rolling_and_sliding``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss
from scipy.optimize import brentq, minimize_scalar

import synthesis as c
from synthesis.design.design import Forces
from synthesis.design.summary import CamGeometry, MotionSummary

RPM, LIFT, BASE, ROLL, OFFSET = 400.0, 24.0, 43.0, 11.0, 4.5  # rpm, mm
ENDS = (0.0, 110.0, 160.0, 255.0, 360.0)  # deg: rise, dwell, return, dwell
MASS, RATE, PRELOAD, DAMPING = 1.7, 6.2e3, 640.0, 30.0  # kg, N/m, N, N s/m
WIDTH, E, NU, RATING = 9.0, 206e3, 0.3, 21_000.0  # mm, MPa, 1, N
OMEGA, TURN = RPM * math.pi / 30.0, 2.0 * math.pi
PRIME = math.sqrt((BASE + ROLL) ** 2 - OFFSET**2)  # height of the roller's centre at s = 0
CHECKED = {  # of `forces`: what the test below compares, and what tells where from
    "flanks": {"flank", "largest_n", "smallest_n", "largest_pressure_mpa"},
    "torque": {"largest_n_m", "smallest_n_m", "mean_n_m", "rms_n_m", "power_w", "work_j",
               "process_work_j", "loss_j", "balance_error_j"},
    "floats": {"start_deg", "end_deg", "lowest_n", "angle_deg"},
    "rollers": {"path", "mean_speed_rpm", "largest_speed_rpm", "equivalent_load_n",
                "life_million_turns", "life_hours"},
    "float_onset_rpm": set(), "changes_flank_deg": set(),
}  # fmt: skip


def designed(rpm: float = RPM, **changes: Any) -> c.Design:
    move = {"lift_mm": LIFT, "law": {"kind": "cycloidal"}}
    spring = {"rate_n_per_mm": 1e-3 * RATE, "preload_n": PRELOAD}
    given = {
        "speed_rpm": rpm, "base_radius_mm": BASE,
        "program": [
            {"kind": "rise", "angle_deg": 110.0, **move}, {"kind": "dwell", "angle_deg": 50.0},
            {"kind": "return", "angle_deg": 95.0, **move}, {"kind": "dwell", "angle_deg": 105.0},
        ],
        "follower": {"kind": "translating_roller", "roller_radius_mm": ROLL, "offset_mm": OFFSET},
        "load": {"kind": "slide", "moving_mass_kg": MASS, "damping_n_s_per_m": DAMPING,
                 "spring": spring, "contact": {"width_mm": WIDTH},
                 "bearing": {"dynamic_rating_n": RATING}},
    }  # fmt: skip
    return c.synthesise(c.DesignSpec.model_validate({**given, **changes}))


def motion(theta: np.ndarray) -> tuple[np.ndarray, ...]:
    """s to s''' of the program at angles within it [mm over rad]."""
    found = np.zeros((4, len(theta)))
    deg = np.degrees(theta)
    for start, end, sign in ((0.0, 110.0, 1.0), (160.0, 255.0, -1.0)):
        inside, beta = (deg > start) & (deg < end), math.radians(end - start)
        x = TURN * (deg[inside] - start) / (end - start)
        found[0, inside] = (0.0 if sign > 0 else LIFT) + sign * LIFT * (x - np.sin(x)) / TURN
        found[1, inside] = sign * LIFT / beta * (1.0 - np.cos(x))
        found[2, inside] = sign * LIFT * TURN / beta**2 * np.sin(x)
        found[3, inside] = sign * LIFT * TURN**2 / beta**3 * np.cos(x)
    found[0, (deg >= 110.0) & (deg <= 160.0)] = LIFT
    return tuple(found)


def push(theta: np.ndarray, omega: float = OMEGA) -> np.ndarray:
    """Force along the slide that the cam has to give [N]."""
    s, v, a, _ = motion(theta)
    return 1e-3 * (MASS * a * omega**2 + DAMPING * v * omega + RATE * s) + PRELOAD


def contact(theta: np.ndarray, omega: float = OMEGA) -> np.ndarray:
    """Force along the normal [N]: tan α = (s' − e)/(height of the roller's centre)."""
    s, v, *_ = motion(theta)
    return push(theta, omega) * np.hypot(1.0, (v - OFFSET) / (PRIME + s))


def bend(theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Curvature of the pitch curve e^{-iθ}(e + i y), and its speed per radian."""
    s, v, a, _ = motion(theta)
    z = OFFSET + 1j * (PRIME + s)
    first = 1j * v - 1j * z
    second = 1j * a - 1j * (1j * v) - 1j * first
    speed = np.abs(first)
    return -(first.conj() * second).imag / speed**3, speed


def pressure(theta: np.ndarray) -> np.ndarray:
    """Hertz's of two cylinders [MPa]."""
    radius = 1.0 / bend(theta)[0] - ROLL
    both = contact(theta) * (1.0 / radius + 1.0 / ROLL)
    return np.sqrt(both / (math.pi * WIDTH * 2.0 * (1.0 - NU**2) / E))


def torque(theta: np.ndarray) -> np.ndarray:
    """The cam does the follower's work: force times s' [N m]."""
    return 1e-3 * push(theta) * motion(theta)[1]


def spin(theta: np.ndarray) -> np.ndarray:
    """Turns of the roller on its pin for one of the cam.

    Seen from the cam it turns by ds/r where its centre moves on by ds, without slip; its carrier
    turns back once for every turn of the cam.
    """
    return bend(theta)[1] / ROLL - 1.0


def onset() -> float:
    """Speed from which it floats [rad/s]."""
    least = lambda omega: extreme(lambda t: push(t, omega), -1.0)[0]  # noqa: E731
    return float(brentq(least, OMEGA, 4.0 * OMEGA, rtol=1e-13))


def extreme(function: Callable[[np.ndarray], np.ndarray], sign: float) -> tuple[float, float]:
    """The largest value (of −1: the smallest) and its angle [deg]."""
    best = (-math.inf, 0.0)
    for start, end in pairwise(ENDS):
        inside = np.radians(np.linspace(start, end, 2001)[1:-1])
        values = sign * function(inside)
        k = int(values.argmax())
        low, high = inside[max(k - 1, 0)], inside[min(k + 1, len(inside) - 1)]
        found = minimize_scalar(
            lambda t: -sign * float(function(np.array([t]))[0]),
            bounds=(low, high), method="bounded", options={"xatol": 1e-12},
        )  # fmt: skip
        best = max(best, (max(-found.fun, float(values[k])), math.degrees(found.x)))
    return sign * best[0], best[1]


def mean(function: Callable[[np.ndarray], np.ndarray]) -> float:
    """Over the turn, by Gauss on twenty parts of every segment."""
    node, weight = leggauss(20)
    total = 0.0
    for start, end in pairwise(ENDS):
        cuts = np.radians(np.linspace(start, end, 21))
        for low, high in pairwise(cuts.tolist()):
            at = 0.5 * (high - low) * (node + 1.0) + low
            total += 0.5 * (high - low) * float(weight @ function(at))
    return total / TURN


def test_every_figure_of_the_forces_is_newtons() -> None:
    forces = designed().forces
    assert forces is not None
    (flank,), torques, (roller,) = forces.flanks, forces.torque, forces.rollers

    def near(peak: Any, function: Callable[[np.ndarray], np.ndarray], sign: float) -> None:
        value, _ = extreme(function, sign)
        assert peak.value == pytest.approx(value, rel=1e-9)
        # the angle is that of this value, however flat it is there
        there = np.radians([peak.angle_deg - 1e-7, peak.angle_deg, peak.angle_deg + 1e-7]) % TURN
        assert np.abs(function(there) / value - 1.0).min() < 1e-6

    near(flank.largest_n, contact, 1.0)
    near(flank.smallest_n, contact, -1.0)
    near(flank.largest_pressure_mpa, pressure, 1.0)
    near(torques.largest_n_m, torque, 1.0)
    near(torques.smallest_n_m, torque, -1.0)
    average = mean(torque)
    lost = mean(lambda t: DAMPING * OMEGA * (1e-3 * motion(t)[1]) ** 2) * TURN
    assert torques.mean_n_m == pytest.approx(average, rel=1e-9)
    assert torques.rms_n_m == pytest.approx(math.sqrt(mean(lambda t: torque(t) ** 2)), rel=1e-9)
    assert torques.power_w == pytest.approx(average * OMEGA, rel=1e-9)
    assert torques.work_j == pytest.approx(average * TURN, rel=1e-9)
    assert torques.loss_j == pytest.approx(lost, rel=1e-9)
    assert (torques.process_work_j, torques.balance_error_j) == pytest.approx((0.0, 0.0), abs=1e-9)
    assert forces.floats == []
    assert forces.changes_flank_deg == []
    assert forces.float_onset_rpm == pytest.approx(onset() * 30.0 / math.pi, rel=1e-9)
    turns = mean(spin)
    exponent = 10.0 / 3.0
    load = (mean(lambda t: contact(t) ** exponent * spin(t)) / turns) ** (1.0 / exponent)
    life = (RATING / load) ** exponent
    assert roller.mean_speed_rpm == pytest.approx(RPM * turns, rel=1e-9)
    assert roller.largest_speed_rpm == pytest.approx(RPM * extreme(spin, 1.0)[0], rel=1e-9)
    assert roller.equivalent_load_n == pytest.approx(load, rel=1e-9)
    assert roller.life_million_turns == pytest.approx(life, rel=1e-9)
    assert roller.life_hours == pytest.approx(life * 1e6 / (60.0 * RPM * turns), rel=1e-9)


def test_where_it_floats_is_where_newton_wants_a_pull() -> None:
    omega = 1.1 * onset()
    forces = designed(omega * 30.0 / math.pi).forces
    assert forces is not None
    dense = np.radians(np.arange(0.005, 360.0, 0.01))
    pulled = np.diff((push(dense, omega) < 0.0).astype(int))
    starts, ends = np.flatnonzero(pulled > 0), np.flatnonzero(pulled < 0)
    assert len(starts) == len(ends) == len(forces.floats) > 0
    for arc, first, last in zip(forces.floats, starts, ends, strict=True):
        for told, k in ((arc.start_deg, first), (arc.end_deg, last)):
            root = brentq(
                lambda t: float(push(np.array([t]), omega)[0]), dense[k], dense[k + 1], xtol=1e-15
            )
            assert told == pytest.approx(math.degrees(root), rel=1e-9)
        low = minimize_scalar(
            lambda t: float(contact(np.array([t]), omega)[0]),
            bounds=(dense[first], dense[last + 1]), method="bounded", options={"xatol": 1e-12},
        )  # fmt: skip
        assert arc.lowest_n == pytest.approx(low.fun, rel=1e-9)
        assert arc.angle_deg == pytest.approx(math.degrees(low.x), abs=1e-3)


def test_in_a_groove_the_roller_changes_flank_where_the_force_vanishes() -> None:
    def drive(theta: float) -> float:
        _, v, a, _ = motion(np.array([theta]))
        return float(MASS * a[0] * OMEGA + DAMPING * v[0])

    slide = {"kind": "translating_roller", "roller_radius_mm": ROLL, "offset_mm": OFFSET}
    load = {"kind": "slide", "moving_mass_kg": MASS, "damping_n_s_per_m": DAMPING}
    forces = designed(follower={**slide, "closure": {"kind": "groove"}}, load=load).forces
    assert forces is not None
    halves = [(1.0, 109.0), (161.0, 254.0)]  # deg: within each move it vanishes once
    found = [brentq(drive, *np.radians(half), xtol=1e-15) for half in halves]
    assert np.degrees(found) == pytest.approx(forces.changes_flank_deg, rel=1e-9)


def test_no_figure_is_left_out() -> None:
    """A new field of these answers needs a comparison here, or in the test named above."""
    found = Forces.model_fields
    assert set(found) == set(CHECKED)
    for name in ("flanks", "floats", "rollers", "torque"):
        of = found[name].annotation
        (model,) = getattr(of, "__args__", (of,))
        assert set(model.model_fields) == CHECKED[name], name
    assert set(MotionSummary.model_fields) == {"velocity", "acceleration", "jerk", "moves"}
    flank = CamGeometry.model_fields["flanks"].annotation.__args__[0]
    assert set(flank.model_fields) == {
        "flank", "largest_radius_mm", "smallest_radius_mm", "perimeter_mm", "area_mm2",
        "centroid_mm", "polar_moment_mm4", "convex_radius_mm", "hollow_radius_mm", "hollows",
        "sliding_speed_mm_per_s", "roller_speed_rpm", "roller_acceleration_rad_per_s2",
    }  # fmt: skip
