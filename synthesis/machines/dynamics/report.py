"""TrainResponse: the response body of a follower train on its cam, and how it is put together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from math import pi
from typing import Any

import numpy as np
from pydantic import Field

from synthesis.catalogue.fields import FiniteModel, doc
from synthesis.catalogue.limits.motion import runs_between_dwells
from synthesis.catalogue.motion import Motion
from synthesis.design.design import Design
from synthesis.design.identity import engine_version, question_id
from synthesis.errors import InputError
from synthesis.machines.dynamics.chain import Chain
from synthesis.machines.dynamics.floating import Flight, simulate_flights
from synthesis.machines.dynamics.response import (
    Response,
    Steps,
    from_rest,
    residual_spectrum,
    steady,
)
from synthesis.machines.dynamics.train import TrainSpec
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE, FULL_TURN, rad_per_s


class Mode(FiniteModel):
    """A mode of the train with the cam at rest."""

    natural_frequency_hz: float = doc(
        "Undamped natural frequency; of an overdamped mode, its rate."
    )
    damping_ratio: float = doc("Damping ratio; 1 for an overdamped mode.")


class ResponsePeak(FiniteModel):
    """An extreme over the turn."""

    value: float = doc("Its value.")
    angle_deg: float = doc("Cam angle where it is.")


class DwellResponse(FiniteModel):
    """Residual vibration where a dwell begins, in the periodic response."""

    segment: int = doc("Index of the dwell in the program.")
    start_deg: float = doc("Cam angle where the dwell begins.")
    modes: list[float] = doc("Amplitude of the output in each mode, in the order of `modes`.")
    amplitude: float = doc("Sum of the amplitudes: largest possible deviation of the output.")
    alone: list[float] = doc(
        "Residual amplitude of a single oscillator with each mode's frequency and damping, at rest "
        "before the run of moves: the quantity of the limit `residual_vibration`."
    )


class AtSpeed(FiniteModel):
    """The periodic response at one speed, and the transient from rest."""

    speed_rpm: float = doc("Speed of the cam.")
    output_error_max: ResponsePeak = doc("Largest output minus cam motion.")
    output_error_min: ResponsePeak = doc("Smallest value of the same.")
    output_acceleration_max: ResponsePeak = doc("Largest acceleration of the output, per s².")
    output_acceleration_min: ResponsePeak = doc("Smallest value of the same.")
    contact_force_max_n: ResponsePeak = doc("Largest force between cam and train.")
    contact_force_min_n: ResponsePeak = doc(
        "Smallest force; below 0 the linear train would pull on the cam."
    )
    floats: bool = doc("Whether contact is lost, as the preload is too small.")
    dwells: list[DwellResponse] = doc("Residual vibration where each dwell begins.")
    remaining_share_per_turn: float = doc(
        "Share of a disturbance that remains after one turn; 1 without damping: then transients "
        "do not decay to the periodic response."
    )
    turns: list[float] = doc(
        "From rest: largest deviation of the output from the periodic response in each turn."
    )
    flight: Flight | None = doc(
        "Where contact is lost: motion of the train from rest over the `turns` requested. Null "
        "where contact is kept, no turns are requested, or the train vibrates too fast for it."
    )
    steps: int = doc("Steps of the turn at whose ends extremes are evaluated.")
    rounding: float = doc(
        "Estimate of the rounding error of a deflection; there is no other error."
    )


class TrainResponse(FiniteModel):
    """The answer to a TrainSpec. Lengths are in `unit`: along the arc of an arm's end, mm too."""

    id: str = doc("Hash of the spec and the engine's version.")
    name: str = doc("Name from the spec.")
    engine_version: str = doc("Version of Camwright that made it.")
    unit: str = doc("Unit of displacements: mm.")
    modes: list[Mode] = doc("Modes of the train, slowest first.")
    speeds: list[AtSpeed] = doc("Responses in the order of the requested speeds.")
    float_onset_rpm: float | None = doc(
        "Lowest speed of contact loss between two of the requested speeds; null where contact is "
        "kept, is lost at the slowest already, or the cam is form-closed."
    )
    cam: Design = doc("The cam.")
    spec: TrainSpec = doc("The request.")
    links: dict[str, str] = Field({}, description="Where to find its files.")


STEPS_PER_PERIOD = 40  # of the fastest mode, within the next two numbers
MIN_STEPS, MAX_STEPS = 720, 8192  # of a turn
HALVINGS = 24  # of the speed interval that holds the float onset
ROUNDING = 8.0 * 2.0**-52  # of the sum of the modes' magnitudes, some of which cancel


def respond(spec: TrainSpec, *, deadline: float | None = None) -> TrainResponse:
    """The response of an elastic train to a cam; what the cam leaves free is designed first.

    ``deadline`` is a ``time.monotonic()``; the cam's own budget counts as well.

    Raises:
        InputError: no cam keeps its limits, so that there is no motion.
        TimeBudgetExceeded, SolverFailed: as for the design of the cam.
    """
    from synthesis.pipeline.synthesise import synthesise  # loads solvers, not needed for the types

    design = synthesise(spec.cam, deadline=deadline)
    if not design.motion:
        raise InputError(
            "/cam", spec.cam.name, "No cam keeps these limits, so that there is no motion.",
            "POST it to /v1/designs: conflict says which limits contradict and what would help.",
        )  # fmt: skip
    return report_response(spec, design)


def report_response(spec: TrainSpec, design: Design) -> TrainResponse:
    """The response of a spec's train on a finished cam."""
    chain, motion = spec.train.chain(), design.curve
    form_closed = spec.train.preload_n is None
    return TrainResponse(
        id=question_id(spec, "train response"),
        name=spec.name,
        engine_version=engine_version(),
        unit="mm",
        modes=[
            Mode(
                natural_frequency_hz=abs(rate) / (2.0 * pi),
                damping_ratio=max(-rate.real / abs(rate), 0.0),
            )
            for rate in chain.modes.rates[chain.modes.independent].tolist()
        ],
        speeds=[
            _at_speed(chain, motion, speed, spec.turns, form_closed=form_closed)
            for speed in spec.speeds
        ],
        float_onset_rpm=None if form_closed else _float_onset(chain, motion, spec.speeds),
        cam=design,
        spec=spec,
    )


_steps = lru_cache(maxsize=4)(Steps.of)


def _steady(chain: Chain, motion: Motion, speed_rpm: float) -> Response:
    """The periodic response, in steps short enough for the fastest mode."""
    omega = rad_per_s(speed_rpm)
    needed = STEPS_PER_PERIOD * float(np.max(np.abs(chain.modes.rates.imag))) / omega
    per_turn = 2.0 ** np.ceil(np.log2(max(needed, 1.0)))  # few values, to be used again
    return steady(chain, _steps(motion, int(np.clip(per_turn, MIN_STEPS, MAX_STEPS))), omega)


def _float_onset(chain: Chain, motion: Motion, speeds: Sequence[float]) -> float | None:
    """Lowest speed of contact loss between two of these speeds, by bisection [rpm]."""

    def loses_contact(speed_rpm: float) -> bool:
        return bool(np.min(_steady(chain, motion, speed_rpm).contact_force) <= 0.0)

    ordered = sorted(set(speeds))
    first = next((k for k, speed in enumerate(ordered) if loses_contact(speed)), 0)
    if first == 0:  # contact is kept, or lost at the slowest already
        return None
    low, high = ordered[first - 1], ordered[first]
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if loses_contact(middle) else (middle, high)
    return high


def _at_speed(
    chain: Chain, motion: Motion, speed_rpm: float, turns: int, *, form_closed: bool
) -> AtSpeed:
    modes, response = chain.modes, _steady(chain, motion, speed_rpm)
    error, force = response.deflection[-1], response.contact_force

    def peak(values: Array, sign: float) -> ResponsePeak:
        at = int(np.argmax(sign * values))
        angle = float(response.steps.theta[at]) / DEGREE
        return ResponsePeak(value=float(values[at]), angle_deg=angle)

    peaks: dict[str, Any] = {
        name.format(end): peak(values, sign)
        for name, values in (
            ("output_error_{}", error), ("output_acceleration_{}", response.output_acceleration),
            ("contact_force_{}_n", force),
        )
        for end, sign in (("max", 1.0), ("min", -1.0))
    }  # fmt: skip
    starts = from_rest(chain, response.steps, response.omega, turns)
    turn_s = FULL_TURN / response.omega
    floats = not form_closed and bool(np.min(force) <= 0.0)
    return AtSpeed(
        speed_rpm=speed_rpm,
        **peaks,
        floats=floats,
        dwells=list(_dwells(motion, response)),
        remaining_share_per_turn=float(np.exp(np.max(modes.rates.real) * turn_s)),
        turns=[float(np.max(np.abs(each.deflection[-1] - error))) for each in starts],
        flight=simulate_flights(chain, motion, response.omega, turns) if floats and turns else None,
        steps=len(response.steps.theta) - 1,
        rounding=ROUNDING * float(np.max(np.abs(modes.shapes) @ np.abs(response.state))),
    )


def _dwells(motion: Motion, response: Response) -> Iterator[DwellResponse]:
    modes = response.chain.modes
    by_end = {run[-1]: run for run in runs_between_dwells(motion.segments)}
    segments = [s for s in motion.segments if s.angle > 0.0]
    for before, dwell in zip((segments[-1], *segments[:-1]), segments, strict=True):
        if dwell.kind != "dwell" or before.index not in by_end:
            continue
        alone = [
            float(residual_spectrum(motion, by_end[before.index],
                                    np.array([abs(rate) / response.omega]),
                                    -rate.real / abs(rate))[0])
            if abs(rate.imag) > 0.0 else 0.0
            for rate in modes.rates[modes.independent].tolist()
        ]  # fmt: skip
        amplitudes = response.free_amplitudes(dwell.start)[-1]
        yield DwellResponse(
            segment=dwell.index, start_deg=dwell.start / DEGREE, modes=amplitudes.tolist(),
            amplitude=float(np.sum(amplitudes)), alone=alone,
        )  # fmt: skip
