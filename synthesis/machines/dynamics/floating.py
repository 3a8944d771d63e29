"""A train that loses contact with its cam: time integration from event to event.

In contact the contact force is N = P − k_1 y_1 − c_1 y_1', P the preload. When it reaches 0 the end
of the first link leaves the cam: the link then carries no force, and its massless end relaxes by
k_1 z + c_1 z' = P to its free length (at once, without a damper). Contact returns when the gap
y_1 − z closes. A train whose fastest mode swings too often is not integrated.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import cos, sin
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from synthesis.catalogue.fields import FiniteModel, doc
from synthesis.catalogue.motion import Motion
from synthesis.machines.dynamics.chain import Chain
from synthesis.machines.dynamics.response import IMPACT, derivative_jumps
from synthesis.numerics import clock
from synthesis.numerics.piecewise import Array, Piecewise
from synthesis.units import DEGREE, FULL_TURN

COARSE, FINE = 1e-6, 1e-8  # relative tolerances; the difference of the two is the uncertainty
MAX_RADIANS = 3000.0  # of the fastest mode's phase, in all turns: more take too long
MAX_LOSSES = 400  # of contact, in all turns; more are a rattle
MIN_STEPS = 96  # of a turn, so that no event is stepped over
SAMPLES = 6  # places of a step where gap and force are read


class Flight(FiniteModel):
    """Motion of a train that loses contact, integrated in time from rest."""

    first_separation_turn: int | None = doc(
        "Turn of the first loss of contact, from 0; null: never."
    )
    first_separation_deg: float | None = doc("Cam angle of the first loss of contact.")
    losses: int = doc("Losses of contact in all turns.")
    separated_share: float = doc("Share of the last turn without contact.")
    largest_gap: float = doc("Largest gap between cam and train.")
    contact_force_max_n: float = doc("Largest contact force, landings included.")
    output_error_end: float = doc("Output minus cam at the end of the last turn.")
    uncertainty: float = doc(
        "Difference of output_error_end from an integration with a hundred times the tolerance. "
        "Flights magnify differences: where it is large, late landings are not reliable."
    )
    chatters: bool = doc("Whether the integration stopped after 400 losses of contact.")


def simulate_flights(chain: Chain, motion: Motion, omega: float, turns: int) -> Flight | None:
    """Integrate from rest, at ω [rad/s]; None where the fastest mode swings too often."""
    fastest = float(np.max(np.abs(chain.modes.rates))) / omega
    if fastest * turns > MAX_RADIANS:
        return None
    coarse, fine = (_Simulation(chain, motion, omega, turns, each).run() for each in (COARSE, FINE))
    change = abs(fine.output_error_end - coarse.output_error_end)
    return fine.model_copy(update={"uncertainty": change})


@dataclass(frozen=True)
class _Simulation:
    """One integration from rest, with a relative tolerance."""

    chain: Chain
    motion: Motion
    omega: float
    turns: int
    tolerance: float

    def run(self) -> Flight:
        """All turns; the state is (y, y') in contact and (y, y', z) in flight."""
        n, last_turn = self.chain.count, (self.turns - 1) * FULL_TURN
        # Equilibrium on the cam, which stands still at its start.
        state = np.zeros(2 * n)
        start = float(self.motion.derivatives([0.0])[0, 0])
        state[:n] = -np.linalg.solve(self.chain.stiffness, self.chain.ground_springs) * start
        flying, z, losses = False, float(state[0]), list[float]()
        # Largest gap and force; cam angle without contact in the last turn.
        peaks, in_flight = {True: 0.0, False: 0.0}, 0.0
        for low, high, jump in self._stages():
            state[n:] -= jump * self.omega  # y' = x' − s' jumps where the cam's velocity does
            at, changed = low, True
            while changed and at < high and len(losses) <= MAX_LOSSES:
                clock.now()  # so that a cancelled task ends here
                begin = at
                at, state, z, changed, peak = self._phase(begin, high, state, z, flying=flying)
                peaks[flying] = max(peaks[flying], peak)
                if flying:
                    in_flight += max(at - max(begin, last_turn), 0.0)
                flying = flying != changed
                if changed and flying:
                    losses.append(at)
        turn, angle = divmod(losses[0], FULL_TURN) if losses else (None, None)
        return Flight(
            first_separation_turn=None if turn is None else int(turn),
            first_separation_deg=None if angle is None else angle / DEGREE,
            losses=len(losses),
            separated_share=in_flight / FULL_TURN,
            largest_gap=peaks[True],
            contact_force_max_n=peaks[False],
            output_error_end=float(state[n - 1]),
            uncertainty=0.0,
            chatters=len(losses) > MAX_LOSSES,
        )

    def _stages(self) -> Iterator[tuple[float, float, float]]:
        """Intervals of cam angle between jumps of the velocity, and the jump at their start."""
        curve = self.motion.curve
        jumps = derivative_jumps(curve, 1, IMPACT)
        places = {0.0: 0.0}
        places |= {float(curve.breaks[k]): float(jumps[k]) for k in np.flatnonzero(jumps)}
        ends = [*places, FULL_TURN]
        for turn in range(self.turns):
            for low, high in pairwise(ends):
                yield turn * FULL_TURN + low, turn * FULL_TURN + high, places[low]

    def _phase(
        self, low: float, high: float, state: Array, z: float, *, flying: bool
    ) -> tuple[float, Array, float, bool, float]:
        """Integrate until contact changes or the interval ends.

        Returns:
            cam angle, (y, y') and z there, whether contact changed, and the largest gap (in flight)
            or contact force.
        """
        n = self.chain.count
        begin = np.append(state, z) if flying else state

        def event(x: Array) -> Array:  # the gap y_1 − z or the force, positive until the phase ends
            return np.asarray(x[0] - x[-1]) if flying else self.chain.contact_force(x[0], x[n])

        def crossing(theta: float, x: Array) -> float:
            return float(event(x))

        crossing.terminal = True  # type: ignore[attr-defined]
        crossing.direction = -1.0  # type: ignore[attr-defined]
        stroke = float(np.ptp(self.motion.curve(self.motion.curve.breaks)))
        solution: Any = solve_ivp(
            self._rates(flying), (low, high), begin, method="DOP853", rtol=self.tolerance,
            atol=self.tolerance * stroke, events=crossing, max_step=FULL_TURN / MIN_STEPS,
            dense_output=True,
        )  # fmt: skip
        at, last = float(solution.t[-1]), solution.y[:, -1]
        z = float(last[2 * n] if flying else last[0])
        between = np.linspace(solution.t[:-1], solution.t[1:], SAMPLES, axis=1).ravel()
        peak = float(np.max(event(solution.sol(between))))
        return at, last[: 2 * n], z, solution.status == 1, peak

    def _rates(self, flying: bool) -> Callable[[float, Array], Array]:
        """d/dθ of the state."""
        chain, n, omega = self.chain, self.chain.count, self.omega
        spring, damper = float(chain.springs[0]), float(chain.dampers[0])
        driven = _evaluator(self.motion.curve)

        def rate(theta: float, x: Array) -> Array:
            s, v, a = driven(theta)
            force = chain.stiffness @ x[:n] + chain.damping @ x[n : 2 * n]
            force = force + chain.ground_springs * s + chain.ground_dampers * (v * omega)
            if flying:  # the first link carries no force: remove it and the preload
                force[0] += chain.preload - spring * x[0] - damper * x[n]
            pulls = -force / chain.masses - a * omega**2
            change = np.concatenate([x[n : 2 * n], pulls])
            if flying:
                creep = (chain.preload - spring * x[-1]) / damper if damper > 0.0 else 0.0
                change = np.append(change, creep)
            return change / omega

        return rate


def _evaluator(curve: Piecewise) -> Callable[[float], tuple[float, float, float]]:
    """s, s' and s'' at a cam angle of any turn as floats: integrators evaluate one at a time."""
    breaks, origins = curve.breaks.tolist(), curve.origins.tolist()
    polys = [row[::-1] for row in curve.poly.tolist()]
    waves = [[wave for wave in row if wave[0] != 0.0] for row in curve.waves.tolist()]

    def at(theta: float) -> tuple[float, float, float]:
        angle = theta % FULL_TURN
        k = min(max(bisect_right(breaks, angle) - 1, 0), len(polys) - 1)
        t, s, v, half = angle - origins[k], 0.0, 0.0, 0.0
        for coefficient in polys[k]:
            half = half * t + v
            v = v * t + s
            s = s * t + coefficient
        a = 2.0 * half
        for amplitude, frequency, phase in waves[k]:
            sine, cosine = sin(frequency * t + phase), cos(frequency * t + phase)
            s += amplitude * sine
            v += amplitude * frequency * cosine
            a -= amplitude * frequency**2 * sine
        return s, v, a

    return at
