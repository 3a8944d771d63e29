"""The exact response of chains: against closed forms, time integration, energy, Duhamel."""

from __future__ import annotations

from itertools import pairwise
from math import cos, exp, pi, sin, sqrt
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.integrate import quad, solve_ivp

from service.contract.examples import examples
from synthesis.catalogue.constraints import VibrationBound
from synthesis.catalogue.motion import Motion
from synthesis.certify.piecewise_motion import PiecewiseMotion
from synthesis.certify.residual_vibration import residual_amplitude
from synthesis.machines.dynamics import TrainSpec
from synthesis.machines.dynamics.chain import Chain
from synthesis.machines.dynamics.files import TRAIN_FILES
from synthesis.machines.dynamics.report import respond
from synthesis.machines.dynamics.response import Steps, from_rest, phi, residual_spectrum, steady
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE
from tests.machines.dynamics.test_residual_limit import FIRST, LIFT, spec

OMEGA = 31.7  # rad/s


def motion(first: str = "modified_sine", second: str = "polynomial_3_4_5") -> Motion:
    return Motion.of(spec(laws=(first, second), base_radius_mm=80.0).placed_segments())


def single(swings: float, damping: float = 0.0) -> Chain:
    """One mass that swings so often during the rise."""
    nu = 2.0 * pi * swings / (FIRST * DEGREE) * OMEGA
    one = np.ones(1)
    return Chain(one, nu**2 * one, 2.0 * damping * nu * one, 0.0 * one, 0.0 * one)


def chain(n: int, seed: int = 3) -> Chain:
    rng = np.random.default_rng(seed)
    return Chain(
        1e-3 * rng.uniform(0.5, 3.0, n), rng.uniform(50.0, 300.0, n), rng.uniform(0.001, 0.02, n),
        rng.uniform(0.0, 5.0, n), rng.uniform(0.0, 0.001, n), 30.0,
    )  # fmt: skip


def integrated(of: Chain, cam: Motion, turns: int, tolerance: float = 3e-10) -> Array:
    """y and y' after some turns from rest, piece by piece, with impacts between the pieces."""
    n, curve = of.count, cam.curve
    state = np.zeros(2 * n)
    state[:n] = -np.linalg.solve(of.stiffness, of.ground_springs) * cam.derivatives([0.0])[0, 0]
    before = float(cam.derivatives([2.0 * pi], 1, "left")[1, 0])
    for _ in range(turns):
        for k, (low, high) in enumerate(pairwise(curve.breaks)):
            piece = np.array([k])

            def rate(t: float, x: Array, piece: Any = piece) -> Array:
                s = curve.jet(np.array([OMEGA * t]), piece, 2)[:, 0].tolist()
                force = of.stiffness @ x[:n] + of.damping @ x[n:]
                force += of.ground_springs * s[0] + of.ground_dampers * s[1] * OMEGA
                return np.concatenate([x[n:], -force / of.masses - s[2] * OMEGA**2])

            state[n:] -= OMEGA * (float(curve.at(np.array([low]), piece, 1)[0]) - before)
            state = solve_ivp(rate, (low / OMEGA, high / OMEGA), state, method="DOP853",
                              rtol=tolerance, atol=tolerance).y[:, -1]  # fmt: skip
            before = float(curve.at(np.array([high]), piece, 1)[0])
    return state


@pytest.mark.parametrize("n", [1, 2, 5])
def test_chains_against_time_integration(n: int) -> None:
    cam = motion("constant_velocity" if n == 2 else "modified_sine")
    of = chain(n)
    turns = 2 if n == 2 else 1
    *_, last = from_rest(of, Steps.of(cam, 300), OMEGA, turns)
    expected = integrated(of, cam, turns)
    assert last.deflection[:, -1] == pytest.approx(expected[:n], abs=1e-7)
    assert last.speed[:, -1] == pytest.approx(expected[n:], abs=3e-5)


def test_the_periodic_response_repeats_and_is_reached() -> None:
    cam, of = motion(), chain(3)
    steps = Steps.of(cam, 360)
    found = steady(of, steps, OMEGA)
    assert found.deflection[:, 0] == pytest.approx(found.deflection[:, -1], abs=1e-12)
    *_, late = from_rest(of, steps, OMEGA, 240)
    assert late.deflection == pytest.approx(found.deflection, abs=1e-9)
    finer = steady(of, Steps.of(cam, 1440), OMEGA)
    at = np.isin(finer.steps.theta, found.steps.theta)
    assert np.count_nonzero(at) > 100
    here = np.searchsorted(found.steps.theta, finer.steps.theta[at])
    assert finer.deflection[:, at] == pytest.approx(found.deflection[:, here], abs=1e-11)


@pytest.mark.parametrize("swings", [0.37, 1.83, 7.41])
def test_residuals_of_cycloidal_and_parabolic_rises(swings: float) -> None:
    cases = {
        "cycloidal": abs(sin(pi * swings)) / (pi * swings * abs(1.0 - swings**2)),
        "parabolic": 4.0 * sin(pi * swings / 2.0) ** 2 / (pi * swings) ** 2,
    }
    nu = np.array([2.0 * pi * swings / (FIRST * DEGREE)])
    for law, expected in cases.items():
        cam = motion(law)
        assert residual_spectrum(cam, (0,), nu, 0.0)[0] / LIFT == pytest.approx(expected, abs=1e-12)
        (turn,) = from_rest(single(swings), Steps.of(cam, 90), OMEGA, 1)
        assert turn.free_amplitudes(FIRST * DEGREE)[0, 0] / LIFT == pytest.approx(
            expected, abs=1e-10
        )


def test_three_formulas_for_what_is_left() -> None:
    """By phi-functions, by the time response, by the judge's Taylor series."""
    cam, damping, swings = motion("constant_velocity", "polynomial_5_6_7_8_9"), 0.13, 3.3
    nu = 2.0 * pi * swings / (FIRST * DEGREE)
    judged = residual_amplitude(PiecewiseMotion(cam), VibrationBound((0,), nu, damping, 1.0, ""))
    (turn,) = from_rest(single(swings, damping), Steps.of(cam, 90), OMEGA, 1)
    assert turn.free_amplitudes(FIRST * DEGREE)[0, 0] == pytest.approx(judged.value, abs=1e-9)
    assert residual_spectrum(cam, (0,), np.array([nu]), damping)[0] == pytest.approx(
        judged.value, abs=1e-9
    )


def test_duhamels_integral_at_a_few_angles() -> None:
    cam, swings, damping = motion("polynomial_4_5_6_7"), 2.3, 0.07
    of = single(swings, damping)
    (turn,) = from_rest(of, Steps.of(cam, 50), OMEGA, 1)
    nu = sqrt(of.springs[0])
    damped = nu * sqrt(1.0 - damping**2)
    for k in (3, 7, 11):
        t = turn.steps.theta[k] / OMEGA

        def impulse(u: float, t: float = t) -> float:
            a = cam.derivatives([OMEGA * u], 2)[2, 0] * OMEGA**2
            return float(-a * exp(-damping * nu * (t - u)) * sin(damped * (t - u)) / damped)

        breaks = [0.5 * FIRST * DEGREE / OMEGA] if t > 0.5 * FIRST * DEGREE / OMEGA else None
        expected = quad(impulse, 0.0, t, epsabs=1e-13, epsrel=1e-12, points=breaks, limit=200)[0]
        assert turn.deflection[0, k] == pytest.approx(expected, abs=1e-11)


@pytest.mark.parametrize("ratio", [1e3, 1e6])
def test_stiff_trains(ratio: float) -> None:
    """A link a million times as fast as the next: it follows as if it were rigid."""
    soft = single(1.3, 0.02)
    both = Chain(
        np.array([soft.masses[0] / ratio, soft.masses[0]]),
        np.array([soft.springs[0] * ratio, soft.springs[0]]),
        np.array([0.0, soft.dampers[0]]), np.zeros(2), np.zeros(2),
    )  # fmt: skip
    rates = np.sort(np.abs(both.modes.rates))
    assert rates[-1] / rates[0] == pytest.approx(ratio, rel=0.02)
    steps = Steps.of(motion(), 400)
    turns = [from_rest(of, steps, OMEGA, 1)[0].deflection[-1] for of in (soft, both)]
    assert turns[1] == pytest.approx(turns[0], abs=8.0 * np.max(np.abs(turns[0])) / ratio)


def test_a_very_stiff_mass_lags_by_its_acceleration() -> None:
    """y = −s''/ω_n² and no more, without loss of digits."""
    cam, of = motion(), single(1.2e6, 0.3)
    (turn,) = from_rest(of, Steps.of(cam, 720), OMEGA, 1)
    a = cam.derivatives(turn.steps.theta, 2)[2] * OMEGA**2
    inside = (turn.steps.theta > 0.05) & (turn.steps.theta < 1.1)
    expected = -a[inside] / of.springs[0]
    assert turn.deflection[0, inside] == pytest.approx(expected, rel=1e-4)


def test_energy_comes_from_the_cam() -> None:
    of = Chain(*(getattr(chain(3), name) for name in ("masses", "springs")), np.zeros(3),
               np.array([0.0, 0.0, 2.7]), np.zeros(3))  # fmt: skip
    cam = motion("cycloidal")
    (turn,) = from_rest(of, Steps.of(cam, 20000), OMEGA, 1)
    s, v = turn.steps.s[0], turn.steps.s[1] * OMEGA
    speed, place = turn.speed + v, turn.deflection + s
    stored = 0.5 * np.sum(of.masses[:, None] * speed**2, axis=0)
    segment = of.links @ turn.deflection
    stored += 0.5 * np.sum(of.springs[:, None] * segment**2, axis=0)
    stored += 0.5 * np.sum(of.ground_springs[:, None] * place**2, axis=0)
    power = turn.contact_force * v
    work = np.sum(0.5 * (power[1:] + power[:-1]) * np.diff(turn.steps.theta) / OMEGA)
    assert stored[-1] - stored[0] == pytest.approx(work, rel=1e-6)
    assert work > 100.0


def test_phi_functions() -> None:
    z = np.array([0.0, 1e-9j, -0.7 + 0.2j, 3.3j, -41.0 + 7.0j, 1e6j, -2e5 + 1e5j])
    found = phi(z, 12)
    for k in range(1, 12):
        for each, value in zip(z[:5], found[k][:5], strict=True):
            parts = [
                quad(lambda u, k=k, each=each, part=part: getattr(
                    np.exp((1.0 - u) * each) * u ** (k - 1), part), 0.0, 1.0, epsabs=1e-15)[0]
                for part in ("real", "imag")
            ]  # fmt: skip
            assert value * np.prod(np.arange(1.0, k)) == pytest.approx(complex(*parts), abs=3e-14)
    shares = np.array([1.0 / np.prod(np.arange(1.0, k + 1)) for k in range(12)])
    above = (found[:-1, 5:] - shares[:, None]) / z[5:]
    assert found[1:, 5:] == pytest.approx(above, abs=1e-13)
    assert found[0, 3] == pytest.approx(complex(cos(3.3), sin(3.3)), abs=1e-15)


BODY = examples("train-responses")["press-feeder"]["value"]


def test_the_example_rests_in_its_first_mode_and_floats() -> None:
    found = respond(TrainSpec.model_validate({**BODY, "turns": 1}))
    slow = found.modes[0]
    assert slow.natural_frequency_hz == pytest.approx(31.0, abs=1e-3)
    designed = next(each for each in found.speeds if each.speed_rpm == 240.0)
    other = next(each for each in found.speeds if each.speed_rpm == 120.0)
    for dwell, noisy in zip(designed.dwells, other.dwells, strict=True):
        assert dwell.alone[0] < 1e-4 < noisy.alone[0]
        assert dwell.modes[0] < 0.1 * noisy.modes[0]
    assert found.float_onset_rpm is not None
    assert 240.0 < found.float_onset_rpm < 480.0
    assert [each.floats for each in found.speeds] == [False, False, False, True]
    assert [each.flight is None for each in found.speeds] == [True, True, True, False]
    slightly = {
        **BODY,
        "turns": 0,
        "speeds_rpm": [0.999 * found.float_onset_rpm, found.float_onset_rpm],
    }
    under, over = respond(TrainSpec.model_validate(slightly)).speeds
    assert under.contact_force_min_n.value > 0.0 >= over.contact_force_min_n.value
    file = TRAIN_FILES[0]
    table = file.write(found, file.options(turns=2)).decode().splitlines()
    assert len(table) > 2 * 720
    assert table[0].startswith("turn,angle_deg,time_s,cam_mm,mass_1_mm,mass_2_mm,output_error_mm")


def mass(**changes: Any) -> dict[str, Any]:
    return {"mass_kg": 1.0, "stiffness_n_per_mm": 40.0, **changes}


@pytest.mark.parametrize(
    ("masses", "words"),
    [
        ([mass(mass_kg=-1.0)], "must be positive"),
        ([mass(stiffness_n_per_mm=0.0)], "must be positive"),
        ([mass(), mass(damping_n_s_per_mm=-0.01)], "is unstable"),
        ([mass(), mass(ground_stiffness_n_per_mm=-30.0)], "statically unstable"),
        ([mass(stiffness_n_per_mm=1e-3 * (2.0 * pi * 12.0) ** 2)], "harmonic 12 of the cam"),
        ([], "at least 1"),
    ],
)
def test_trains_that_make_no_sense(masses: list[dict[str, Any]], words: str) -> None:
    with pytest.raises(ValidationError, match=words):
        TrainSpec.model_validate({**BODY, "train": {"masses": masses}})


def test_critical_damping_costs_what_rounding_says() -> None:
    """Two modes are one there: half of the digits go, and the answer says so."""
    body = {**BODY, "speeds_rpm": [61.7], "turns": 0}
    body["cam"] = {**BODY["cam"], "limits": []}
    body["cam"]["program"] = [
        {**each, **({"law": {"kind": "modified_sine"}} if "lift_mm" in each else {})}
        for each in BODY["cam"]["program"]
    ]
    damping = 2.0 * sqrt(40e-3)

    def response_with(factor: float) -> Any:
        masses = [{"mass_kg": 1.0, "stiffness_n_per_mm": 40.0,
                   "damping_n_s_per_mm": damping * factor}]  # fmt: skip
        train = TrainSpec.model_validate({**body, "train": {"masses": masses}})
        return respond(train).speeds[0]

    critical, *beside = (response_with(factor) for factor in (1.0, 1.0 - 1e-5, 1.0 + 1e-5))
    between = 0.5 * sum(each.output_error_max.value for each in beside)
    assert critical.output_error_max.value == pytest.approx(between, rel=1e-7)
    assert beside[0].rounding < critical.rounding < 1e-5
    assert abs(critical.output_error_max.value - between) < 10.0 * critical.rounding
