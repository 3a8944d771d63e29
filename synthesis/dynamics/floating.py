"""A train that leaves its cam: integrated in time, from one loss of contact to the next landing.

In contact the cam presses with N = P − k_1 y_1 − c_1 y_1', P the preload. Where that comes to 0 the
end of the first link leaves the cam: the link then carries nothing, and its end, which has no mass,
creeps by k_1 z + c_1 z' = P to its free length (it is there at once without a damper). The train is
on the cam again when the gap y_1 − z closes. A train whose fastest mode swings too often to be
integrated is left alone.
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

from synthesis import clock
from synthesis.dynamics.chain import Chain
from synthesis.motion import Motion
from synthesis.numerics.piecewise import Array, Piecewise
from synthesis.units import FULL_TURN

COARSE, FINE = 1e-6, 1e-8  # relative tolerances: the second tells, the first how far off it is
SWINGS = 3000.0  # of the fastest mode, in all: more are not integrated
FLIGHTS = 400  # in all; more are a rattle
OFTEN = 96  # steps of a turn at least
READ = 6  # places of a step where gap and force are read


@dataclass(frozen=True)
class Flights:
    """What became of the train from rest.

    Attributes:
        lost: turn (from 0) and cam angle [rad] where contact is lost first; None: never.
        count: losses of contact. in_air: share of the last turn. gap: largest [mm].
        force: largest contact force [N]. output: of the last mass at the end, from the cam [mm].
        rattles: given up, as contact was lost too often.
    """

    lost: tuple[int, float] | None
    count: int
    in_air: float
    gap: float
    force: float
    output: float
    rattles: bool


def flights(chain: Chain, motion: Motion, omega: float, turns: int) -> tuple[Flights, float] | None:
    """What becomes of the train, and how far its last place is from a coarser integration's [mm].

    None where the fastest mode swings too often to be integrated.
    """
    fastest = float(np.max(np.abs(chain.modes.rates))) / omega
    if fastest * turns > SWINGS:
        return None
    found = [_Flight(chain, motion, omega, turns, each).flown() for each in (COARSE, FINE)]
    return found[1], abs(found[1].output - found[0].output)


@dataclass(frozen=True)
class _Flight:
    chain: Chain
    motion: Motion
    omega: float
    turns: int
    tolerance: float

    def flown(self) -> Flights:
        """The whole of it: (y, y', z) in the air, (y, y') on the cam."""
        n, found = self.chain.count, Flights(None, 0, 0.0, 0.0, 0.0, 0.0, False)
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
                found = self._noted(found, seen, at, flying=flying)
                if not lost:
                    break
                flying = not flying
                found = self._lost(found, at) if flying else found
                if found.count > FLIGHTS:
                    return replace(found, rattles=True, output=float(state[n - 1]))
        return replace(found, output=float(state[n - 1]))

    def _stages(self) -> Iterator[tuple[float, float, float]]:
        """Parts of the turns between jumps of the velocity, and that at their beginning."""
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
        """On from one cam angle until contact changes or the part ends.

        Returns:
            cam angle, (y, y'), z there, whether contact changed, angles and (gap or force) on the
            way.
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
            atol=self.tolerance * stroke, events=crossing, max_step=FULL_TURN / OFTEN,
            dense_output=True,
        )  # fmt: skip
        at, last = float(found.t[-1]), found.y[:, -1]
        between = np.linspace(found.t[:-1], found.t[1:], READ, axis=1).ravel()
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
        driven = _driven(self.motion.curve)

        def rate(theta: float, x: Array) -> Array:
            s, v, a = driven(theta)
            force = chain.stiffness @ x[:n] + chain.damping @ x[n : 2 * n]
            force = force + chain.ground_springs * s + chain.ground_dampers * (v * omega)
            if flying:  # what the link would carry is taken out, and the preload with it
                force[0] += chain.preload - spring * x[0] - damper * x[n]
            pulls = -force / chain.masses - a * omega**2
            found = np.concatenate([x[n : 2 * n], pulls])
            if flying:
                creep = (chain.preload - spring * x[-1]) / damper if damper > 0.0 else 0.0
                found = np.append(found, creep)
            return found / omega

        return rate

    def _noted(
        self, found: Flights, seen: tuple[Array, Array], at: float, *, flying: bool
    ) -> Flights:
        """With the peaks of one phase, and its time in the air if that is in the last turn."""
        theta, values = seen
        most = float(np.max(values))
        if not flying:
            return replace(found, force=max(found.force, most))
        last = (self.turns - 1) * FULL_TURN
        share = max(at - max(float(theta[0]), last), 0.0) / FULL_TURN
        return replace(found, gap=max(found.gap, most), in_air=found.in_air + share)

    def _lost(self, found: Flights, at: float) -> Flights:
        turn, angle = divmod(at, FULL_TURN)
        return replace(found, lost=found.lost or (int(turn), angle), count=found.count + 1)


def _driven(curve: Piecewise) -> Callable[[float], tuple[float, float, float]]:
    """s, s' and s'' at a cam angle of any turn, in plain numbers: integrators ask one by one."""
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
