"""The exact response of a linear train to a cam's motion, mode by mode and step by step.

Within a step the motion is its Taylor series: exact on a polynomial piece, truncated below rounding
on short steps of a sinusoid. Every mode is then advanced by φ-functions, exactly but for rounding
and however stiff it is; a jump of the velocity is an impact. The periodic state solves (1 − e^(λT))
ξ_0 = contribution of one turn.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from synthesis.catalogue.motion import Motion
from synthesis.machines.dynamics.chain import Chain, Complex, Modes
from synthesis.machines.dynamics.phi import phi
from synthesis.numerics.piecewise import Array
from synthesis.units import FULL_TURN

WAVE = 0.5  # rad: largest phase of a law's own sinusoids in one step
SERIES = 18  # terms of their Taylor series: 0.5^18/18! is below rounding
IMPACT = 1e-9  # of the largest velocity: smaller jumps are rounding


@dataclass(frozen=True, eq=False)
class Steps:
    """One turn cut into steps within pieces of the motion; a step of length 0 is an impact.

    Attributes:
        theta: (k+1,) cam angles at their ends [rad]. taylor: (d+1, k) s^(j) Δθ^j at their
        beginnings [mm]. jump: (k,) by how much s' jumps there [mm/rad]. s: (2, k+1) s and s' at
        the ends.
    """

    theta: Array
    taylor: Array
    jump: Array
    s: Array

    @classmethod
    def of(cls, motion: Motion, per_turn: int) -> Steps:
        """Steps of a motion, at least ``per_turn``, with its breaks among their ends."""
        curve = motion.curve
        width = np.diff(curve.breaks)
        fastest = np.zeros(curve.count)
        degree = curve.poly.shape[1] - 1
        if curve.waves.shape[1]:
            real = curve.waves[..., 0] != 0.0
            fastest = np.max(np.abs(curve.waves[..., 1]) * real, axis=1)
            degree = max(degree, SERIES)
        count = np.ceil(np.maximum(width * per_turn / FULL_TURN, fastest * width / WAVE))
        count = np.maximum(count, 1.0).astype(int)
        ends = [
            np.linspace(low, high, n + 1)[:-1]
            for low, high, n in zip(curve.breaks[:-1], curve.breaks[1:], count, strict=True)
        ]
        start = np.concatenate(ends)
        piece = np.repeat(np.arange(curve.count), count)
        step = np.diff(np.append(start, curve.breaks[-1]))
        taylor = curve.jet(start, piece, degree) * step ** np.arange(degree + 1)[:, None]
        jump = np.zeros(len(start))
        first = np.cumsum(count) - count
        after = curve.jet(curve.breaks[:-1], np.arange(curve.count), 1)[1]
        before = np.roll(curve.jet(curve.breaks[1:], np.arange(curve.count), 1)[1], 1)
        jump[first] = after - before
        speed = float(np.max(np.abs(curve.jet(start, piece, 1)[1])))
        hits = np.flatnonzero(np.abs(jump) > IMPACT * speed)
        start, taylor = np.insert(start, hits, start[hits]), np.insert(taylor, hits, 0.0, axis=1)
        placed = np.zeros(len(start))
        placed[hits + np.arange(len(hits))] = jump[hits]
        theta = np.append(start, curve.breaks[-1])
        known = np.stack([motion.derivatives(theta, 1, side) for side in ("right", "left")])
        s = known[0]
        s[:, hits + np.arange(len(hits))] = known[1][:, hits + np.arange(len(hits))]
        s[:, -1] = known[1][:, -1]
        return cls(theta, taylor, placed, s)


@dataclass(frozen=True, eq=False)
class Response:
    """A train's response over one turn.

    Attributes:
        chain, steps: of what. omega: ω [rad/s]. state: (2n, k+1) ξ at the ends of the steps.
    """

    chain: Chain
    steps: Steps
    omega: float
    state: Complex

    @property
    def theta(self) -> Array:
        """Cam angles (k+1,) [rad]."""
        return self.steps.theta

    @property
    def deflection(self) -> Array:
        """(n, k+1) y: displacements of the masses minus the cam's motion [mm]."""
        return np.asarray((self.chain.modes.shapes @ self.state).real)

    @property
    def speed(self) -> Array:
        """(n, k+1) y' [mm/s]."""
        return np.asarray((self.chain.modes.speeds @ self.state).real)

    @property
    def contact_force(self) -> Array:
        """(k+1,) contact force [N]; where it is negative the train would leave the cam."""
        chain = self.chain
        link = chain.springs[0] * self.deflection[0] + chain.dampers[0] * self.speed[0]
        return np.asarray(chain.preload - link)

    def free_amplitudes(self, angle: float) -> Array:
        """(n, modes) amplitudes of the free vibration where a dwell begins at this angle [mm].

        Of damped modes the envelope's, of overdamped ones the deflection.
        """
        at = int(np.argmin(np.abs(self.theta[::-1] - angle)))  # after an impact at that angle
        k = len(self.theta) - 1 - at
        free = self.state[:, k] - self.chain.modes.rest_state(float(self.steps.s[0, k]))
        return self.chain.modes.amplitudes(free)


def steady(chain: Chain, steps: Steps, omega: float) -> Response:
    """The periodic (steady-state) response."""
    alone = _recursion(np.zeros(2 * chain.count, complex), *_transition(chain.modes, steps, omega))
    times = (steps.theta - steps.theta[0]) / omega
    free = np.exp(np.multiply.outer(chain.modes.rates, times))
    start = alone[:, -1] / (1.0 - free[:, -1])
    return Response(chain, steps, omega, alone + free * start[:, None])


def from_rest(chain: Chain, steps: Steps, omega: float, turns: int) -> list[Response]:
    """The transient response from rest at the program's start, turn by turn."""
    factor, added = _transition(chain.modes, steps, omega)
    state, found = chain.modes.rest_state(float(steps.s[0, 0])), []
    for _ in range(turns):
        whole = _recursion(state, factor, added)
        found.append(Response(chain, steps, omega, whole))
        state = whole[:, -1]
    return found


def resonance(modes: Modes, omega: float, nearness: float = 1e-9) -> tuple[float, int] | None:
    """The undamped mode whose frequency is a harmonic of the cam's, and that harmonic.

    There the response grows from turn to turn, and no periodic one exists.

    Returns:
        its natural frequency [Hz] and the harmonic of the shaft; None where there is none.
    """
    turn = modes.rates * FULL_TURN / omega
    for k in modes.independent.tolist():
        if abs(np.expm1(turn[k] - 2j * np.pi * round(turn[k].imag / FULL_TURN))) < nearness:
            return float(abs(modes.rates[k]) / FULL_TURN), round(turn[k].imag / FULL_TURN)
    return None


def _transition(modes: Modes, steps: Steps, omega: float) -> tuple[Complex, Complex]:
    """Factor of ξ over every step and what the motion adds to it: (2n, k) each."""
    degree = len(steps.taylor) - 1
    length = np.diff(steps.theta) / omega
    sizes, which = np.unique(length, return_inverse=True)
    functions = phi(np.multiply.outer(modes.rates, sizes), degree + 1)  # (d+2, 2n, sizes)
    whole = np.vstack([steps.taylor, np.zeros((2, steps.taylor.shape[1]))])
    moving = length > 0.0
    h = np.where(moving, length, 1.0)
    added = np.zeros((len(modes.rates), len(length)), complex)
    for k in range(degree + 1):
        force = (
            np.multiply.outer(modes.by_acceleration, whole[k + 2] / h)
            + np.multiply.outer(modes.by_velocity, whole[k + 1])
            + np.multiply.outer(modes.by_displacement, whole[k] * h)
        )
        added += functions[k + 1][:, which] * force
    added = np.where(moving, added, np.multiply.outer(modes.by_acceleration, steps.jump * omega))
    return functions[0][:, which], added


def _recursion(start: Complex, factor: Complex, added: Complex) -> Complex:
    """ξ at the ends of all steps: (2n, k+1)."""
    found, state = [start], start
    for each, more in zip(
        np.ascontiguousarray(factor.T), np.ascontiguousarray(added.T), strict=True
    ):
        state = each * state + more
        found.append(state)
    return np.array(found).T
