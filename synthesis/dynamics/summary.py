"""From the exact response to what is told of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import pi

import numpy as np

from synthesis.design import Design, engine_version, question_id
from synthesis.dynamics.chain import Chain
from synthesis.dynamics.floating import flights
from synthesis.dynamics.report import (
    AtSpeed,
    DwellResponse,
    Flight,
    Mode,
    ResponsePeak,
    TrainResponse,
)
from synthesis.dynamics.response import Response, Steps, from_rest, steady
from synthesis.dynamics.spectrum import moves, residuals
from synthesis.dynamics.train import TrainSpec
from synthesis.motion import Motion
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE, FULL_TURN, rad_per_s

PER_SWING = 40  # steps of one swing of the fastest mode, within
FEWEST, MOST = 720, 8192  # steps of a turn
HALVINGS = 24  # of the interval in which contact is first lost
ROUNDINGS = 8.0 * 2.0**-52  # of what modes add up to, some of which may cancel


@dataclass(frozen=True, eq=False)
class Machine:
    """A train on the motion of a cam."""

    chain: Chain
    motion: Motion

    def at(self, speed_rpm: float) -> Response:
        """The periodic response."""
        return steady(self.chain, self._steps(speed_rpm), rad_per_s(speed_rpm))

    def starting(self, speed_rpm: float, turns: int) -> list[Response]:
        """Turn by turn from rest."""
        steps = self._steps(speed_rpm)
        return from_rest(self.chain, steps, rad_per_s(speed_rpm), turns)

    def _steps(self, speed_rpm: float) -> Steps:
        fastest = float(np.max(np.abs(self.chain.modes.rates.imag)))
        per_turn = PER_SWING * fastest / rad_per_s(speed_rpm)
        return self._cut[int(np.clip(2.0 ** np.ceil(np.log2(max(per_turn, 1.0))), FEWEST, MOST))]

    @cached_property
    def _cut(self) -> _Cut:
        return _Cut(self.motion)

    def onset(self, speeds: Sequence[float]) -> float | None:
        """Speed at which contact is first lost between two of these [rpm]."""
        ordered = sorted(set(speeds))
        lost = [self.loses(speed) for speed in ordered]
        if True not in lost or lost[0]:
            return None
        first = lost.index(True)
        low, high = ordered[first - 1], ordered[first]
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if self.loses(middle) else (middle, high)
        return high

    def loses(self, speed_rpm: float) -> bool:
        """Whether the train leaves the cam."""
        return bool(np.min(self.at(speed_rpm).contact_force) <= 0.0)


class _Cut(dict[int, Steps]):
    """Steps of one motion by their number, made once each."""

    def __init__(self, motion: Motion) -> None:
        super().__init__()
        self._motion = motion

    def __missing__(self, per_turn: int) -> Steps:
        self[per_turn] = Steps.of(self._motion, per_turn)
        return self[per_turn]


def summed_up(spec: TrainSpec, design: Design) -> TrainResponse:
    """What the train of a spec does on a finished cam."""
    chain = spec.train.chain()
    machine = Machine(chain, design.curve)
    held = spec.train.preload_n is None
    return TrainResponse(
        id=question_id(spec, "train response"),
        name=spec.name,
        engine_version=engine_version(),
        unit="mm",
        modes=_modes(chain),
        speeds=[_at_speed(machine, speed, spec.turns, held=held) for speed in spec.speeds],
        float_onset_rpm=None if held else machine.onset(spec.speeds),
        cam=design,
        spec=spec,
    )


def _modes(chain: Chain) -> list[Mode]:
    rates = chain.modes.rates[chain.modes.kept]
    return [
        Mode(
            natural_frequency_hz=abs(rate) / (2.0 * pi),
            damping_ratio=max(-rate.real / abs(rate), 0.0),
        )
        for rate in rates.tolist()
    ]


def _at_speed(machine: Machine, speed_rpm: float, turns: int, *, held: bool) -> AtSpeed:
    found = machine.at(speed_rpm)
    error, force = found.deflection[-1], found.contact_force
    pulls = output_acceleration(found)
    starts = machine.starting(speed_rpm, turns)
    floats = not held and bool(np.min(force) <= 0.0)
    modes = machine.chain.modes
    return AtSpeed(
        speed_rpm=speed_rpm,
        output_error_max=_peak(found, error),
        output_error_min=_peak(found, -error, -1.0),
        output_acceleration_max=_peak(found, pulls),
        output_acceleration_min=_peak(found, -pulls, -1.0),
        contact_force_max_n=_peak(found, force),
        contact_force_min_n=_peak(found, -force, -1.0),
        floats=floats,
        dwells=_dwells(machine, found),
        remembers=float(np.exp(np.max(modes.rates.real) * FULL_TURN / found.omega)),
        turns=[float(np.max(np.abs(each.deflection[-1] - error))) for each in starts],
        flight=_flight(machine, found.omega, turns) if floats and turns else None,
        steps=len(found.theta) - 1,
        rounding=ROUNDINGS * float(np.max(np.abs(modes.shapes) @ np.abs(found.state))),
    )


def _flight(machine: Machine, omega: float, turns: int) -> Flight | None:
    known = flights(machine.chain, machine.motion, omega, turns)
    if known is None:
        return None
    found, apart = known
    turn, angle = (None, None) if found.lost is None else found.lost
    return Flight(
        first_lost_turn=turn, first_lost_deg=None if angle is None else angle / DEGREE,
        losses=found.count, in_air=found.in_air, largest_gap=found.gap,
        contact_force_max_n=found.force, output_error_end=found.output, uncertainty=apart,
        rattles=found.rattles,
    )  # fmt: skip


def output_acceleration(found: Response) -> Array:
    """Of the last mass, from the forces on it: (k+1,) [mm/s²]."""
    chain, s = found.chain, found.steps.s
    held = chain.ground_springs[:, None] * s[0] + chain.ground_dampers[:, None] * s[1] * found.omega
    forces = -(chain.stiffness @ found.deflection + chain.damping @ found.speed) - held
    return np.asarray(forces[-1] / chain.masses[-1])


def _peak(found: Response, values: Array, sign: float = 1.0) -> ResponsePeak:
    at = int(np.argmax(values))
    return ResponsePeak(value=sign * float(values[at]), angle_deg=float(found.theta[at]) / DEGREE)


def _dwells(machine: Machine, found: Response) -> list[DwellResponse]:
    motion, rates = machine.motion, machine.chain.modes.rates[machine.chain.modes.kept]
    runs = {run[-1]: run for run in moves(motion)}
    placed = [s for s in motion.stretches if s.angle > 0.0]
    dwells = []
    for before, stretch in zip((placed[-1], *placed[:-1]), placed, strict=True):
        if stretch.kind != "dwell" or before.index not in runs:
            continue
        left = found.left(stretch.start)[-1]
        alone = [
            float(residuals(motion, runs[before.index], np.array([abs(rate) / found.omega]),
                            -rate.real / abs(rate))[0])
            if abs(rate.imag) > 0.0 else 0.0
            for rate in rates.tolist()
        ]  # fmt: skip
        dwells.append(
            DwellResponse(
                segment=stretch.index, start_deg=stretch.start / DEGREE, modes=left.tolist(),
                amplitude=float(np.sum(left)), alone=alone,
            )
        )  # fmt: skip
    return dwells
