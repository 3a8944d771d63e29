"""A train that loses contact with its cam: time integration from event to event.

In contact the contact force is N = P − k_1 y_1 − c_1 y_1', P the preload. When it reaches 0 the end
of
the first link leaves the cam: the link then carries no force, and its massless end relaxes by
k_1 z + c_1 z' = P to its free length (at once, without a damper). Contact returns when the gap
y_1 − z closes. A train whose fastest mode swings too often is not integrated.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from math import cos, sin
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from synthesis.catalogue.motion import Motion
from synthesis.machines.dynamics.chain import Chain
from synthesis.numerics import clock
from synthesis.numerics.piecewise import Array, Piecewise
from synthesis.units import FULL_TURN

COARSE, FINE = 1e-6, 1e-8  # relative tolerances; the difference of the two is the uncertainty
MAX_RADIANS = 3000.0  # of the fastest mode's phase, in all turns: more take too long
MAX_LOSSES = 400  # of contact, in all turns; more are a rattle
MIN_STEPS = 96  # of a turn, so that no event is stepped over
SAMPLES = 6  # places of a step where gap and force are read


@dataclass(frozen=True)
class FlightResult:
    """The train's motion from rest, summarised.

    Attributes:
        lost: turn (from 0) and cam angle [rad] of the first loss of contact; None: never.
        count: losses of contact. separated_share: share of the last turn without contact.
        gap: largest gap [mm].
        force: largest contact force [N]. output: final deflection of the last mass [mm].
        chatters: stopped, as contact was lost too often.
    """

    lost: tuple[int, float] | None
    count: int
    separated_share: float
    gap: float
    force: float
    output: float
    chatters: bool


def simulate_flights(
    chain: Chain, motion: Motion, omega: float, turns: int
) -> tuple[FlightResult, float] | None:
    """Integrate from rest; also the change of the final deflection at a coarser tolerance [mm].

    None where the fastest mode swings too often.
    """
    fastest = float(np.max(np.abs(chain.modes.rates))) / omega
    if fastest * turns > MAX_RADIANS:
        return None
    found = [_Simulation(chain, motion, omega, turns, each).run() for each in (COARSE, FINE)]
    return found[1], abs(found[1].output - found[0].output)


@dataclass(frozen=True)
class _Simulation:
    chain: Chain
    motion: Motion
    omega: float
    turns: int
    tolerance: float

    def run(self) -> FlightResult:
        """All turns; the state is (y, y') in contact and (y, y', z) in flight."""
        n, found = self.chain.count, FlightResult(None, 0, 0.0, 0.0, 0.0, 0.0, False)
        state = np.zeros(2 * n)
        start = float(self.motion.derivatives([0.0])[0, 0])
        state[:n] = -np.linalg.solve(self.chain.stiffness, self.chain.ground_springs) * start
        flying, z = False, float(state[0])
        for low, high, jump in self._stages():
            state[n:] -= jump * self.omega
            at = low
            while at < high:
                clock.now()
                at, state, z, lost, seen = self._phase(at, high, state, z, flying=flying)
                found = self._with_phase(found, seen, at, flying=flying)
                if not lost:
                    break
                flying = not flying
                found = self._with_loss(found, at) if flying else found
                if found.count > MAX_LOSSES:
                    return replace(found, chatters=True, output=float(state[n - 1]))
        return replace(found, output=float(state[n - 1]))

    def _stages(self) -> Iterator[tuple[float, float, float]]:
        """Intervals of cam angle between jumps of the velocity, and the jump at their start."""
        curve = self.motion.curve
        before = np.roll(self.motion.derivatives(curve.breaks[1:], 1, "left")[1], 1)
        after = self.motion.derivatives(curve.breaks[:-1], 1)[1]
        jumps = after - before
        hits = np.flatnonzero(np.abs(jumps) > 1e-9 * max(float(np.max(np.abs(after))), 1e-300))
        places = {0.0: 0.0} | {float(curve.breaks[k]): float(jumps[k]) for k in hits}
        ends = [*places, FULL_TURN]
        for turn in range(self.turns):
            for low, high in pairwise(ends):
                yield turn * FULL_TURN + low, turn * FULL_TURN + high, places[low]

    def _phase(
        self, low: float, high: float, state: Array, z: float, *, flying: bool
    ) -> tuple[float, Array, float, bool, tuple[Array, Array]]:
        """Integrate until contact changes or the interval ends.

        Returns:
            cam angle, (y, y') and z there, whether contact changed, and sampled angles with the gap
            (in flight) or the contact force.
        """
        n, event = self.chain.count, self._gap if flying else self._force
        begin = np.append(state, z) if flying else state

        def crossing(theta: float, x: Array) -> float:
            return event(x)

        crossing.terminal = True  # type: ignore[attr-defined]
        crossing.direction = -1.0  # type: ignore[attr-defined]
        stroke = float(np.ptp(self.motion.curve(self.motion.curve.breaks)))
        found: Any = solve_ivp(
            self._rates(flying), (low, high), begin, method="DOP853", rtol=self.tolerance,
            atol=self.tolerance * stroke, events=crossing, max_step=FULL_TURN / MIN_STEPS,
            dense_output=True,
        )  # fmt: skip
        at, last = float(found.t[-1]), found.y[:, -1]
        between = np.linspace(found.t[:-1], found.t[1:], SAMPLES, axis=1).ravel()
        seen = between, np.array([event(x) for x in found.sol(between).T])
        return at, last[: 2 * n], float(last[2 * n] if flying else last[0]), found.status == 1, seen

    def _force(self, x: Array) -> float:
        chain, n = self.chain, self.chain.count
        return float(chain.preload - chain.springs[0] * x[0] - chain.dampers[0] * x[n])

    def _gap(self, x: Array) -> float:
        return float(x[0] - x[-1])

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
            found = np.concatenate([x[n : 2 * n], pulls])
            if flying:
                creep = (chain.preload - spring * x[-1]) / damper if damper > 0.0 else 0.0
                found = np.append(found, creep)
            return found / omega

        return rate

    def _with_phase(
        self, found: FlightResult, seen: tuple[Array, Array], at: float, *, flying: bool
    ) -> FlightResult:
        """The result with the peaks of one phase, and its time in flight within the last turn."""
        theta, values = seen
        most = float(np.max(values))
        if not flying:
            return replace(found, force=max(found.force, most))
        last = (self.turns - 1) * FULL_TURN
        share = max(at - max(float(theta[0]), last), 0.0) / FULL_TURN
        return replace(
            found, gap=max(found.gap, most), separated_share=found.separated_share + share
        )

    def _with_loss(self, found: FlightResult, at: float) -> FlightResult:
        turn, angle = divmod(at, FULL_TURN)
        return replace(found, lost=found.lost or (int(turn), angle), count=found.count + 1)


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
