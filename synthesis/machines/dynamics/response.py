"""The exact response of a linear train to a cam's motion, mode by mode and step by step.

Within a step the motion is its Taylor series: exact on a polynomial piece, truncated below rounding
on short steps of a sinusoid. Every mode is then advanced by φ-functions, exactly but for rounding
and however stiff it is; a jump of the velocity is an impact. The periodic state solves (1 − e^(λT))
ξ_0 = contribution of one turn. The residual spectrum of a motion is a sum of φ-functions too.

φ_0(z) = e^z and φ_k(z) = ∫_0^1 e^((1−u) z) u^(k−1)/(k−1)! du, so that ξ' = λξ + Σ f_k t^k/k! over
a step h gives ξ(h) = e^(λh) ξ(0) + Σ f_k h^(k+1) φ_(k+1)(λh) (Hochbruck & Ostermann, Exponential
integrators, Acta Numerica 19, 2010).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import factorial, sqrt

import numpy as np
from scipy.linalg import toeplitz

from synthesis.catalogue.motion import Motion
from synthesis.machines.dynamics.chain import Chain, Complex, Modes
from synthesis.numerics.box_search import Boxes
from synthesis.numerics.piecewise import Array, Piecewise
from synthesis.units import FULL_TURN

TERMS = 22  # of the series of φ in the unit disc, where the last is below rounding
WAVE = 0.5  # rad: largest phase of a law's own sinusoids in one step
SERIES = 18  # terms of their Taylor series: 0.5^18/18! is below rounding
RESONANT = 1e-9  # change of a mode over one turn below which the response grows
IMPACT = 1e-9  # of the largest velocity: smaller jumps of it are rounding


def phi(z: Complex, highest: int) -> Complex:
    """φ_0 to φ_highest of complex numbers: (highest + 1, *z.shape).

    By their series in the unit disc, and outside by doubling the argument, φ_k(2z) = 2^(−k)
    [e^z φ_k(z) + Σ_j φ_j(z)/(k−j)!], which is stable where the real part is not positive.
    """
    halvings = np.ceil(np.log2(np.maximum(np.abs(z), 1.0))).astype(int)
    small = z / 2.0**halvings
    # φ_k(z) = Σ_j z^j/(j + k)!, all k at once.
    orders = np.arange(highest + 1).reshape(-1, *(1,) * z.ndim)
    first = [1.0 / factorial(k) for k in range(highest + 1)]
    term = np.multiply.outer(first, np.ones(z.shape, complex))
    values = term.copy()
    for j in range(1, TERMS):
        term = term * small / (j + orders)
        values += term
    # Doublings: 1/(k − j)! for 1 ≤ j ≤ k, and 2^(−k).
    weights = np.tril(toeplitz(first))
    weights[:, 0] = 0.0
    scale = 0.5 ** np.arange(highest + 1)
    for done in range(int(halvings.max(initial=0))):
        active = halvings > done
        part = values[:, active]
        exponential = np.exp(small[active] * 2.0**done)
        values[:, active] = scale[:, None] * (exponential * part + weights @ part)
    values[0] = np.exp(z)
    return values


@dataclass(frozen=True, eq=False)
class Steps:
    """One turn cut into steps within pieces of the motion; a step of length 0 is an impact."""

    theta: Array  # (k+1,) cam angles at their ends [rad]
    taylor: Array  # (d+1, k) s^(j) Δθ^j at their beginnings [mm]
    jump: Array  # (k,) by how much s' jumps there [mm/rad]
    s: Array  # (2, k+1) s and s' at the ends

    @classmethod
    def of(cls, motion: Motion, per_turn: int) -> Steps:
        """Steps of a motion, at least ``per_turn``, with its breaks among their ends."""
        curve, width = motion.curve, np.diff(motion.curve.breaks)
        real = curve.waves[..., 0] != 0.0
        fastest = np.max(np.abs(curve.waves[..., 1]) * real, axis=1, initial=0.0)
        degree = max(curve.poly.shape[1] - 1, SERIES if curve.waves.shape[1] else 0)
        count = np.ceil(np.maximum(width * per_turn / FULL_TURN, fastest * width / WAVE))
        count = np.maximum(count, 1.0).astype(int)
        parts = Boxes.from_spans(np.arange(curve.count), curve.breaks[:-1], curve.breaks[1:], count)
        start, step = parts.lo, np.diff(np.append(parts.lo, curve.breaks[-1]))
        taylor = curve.jet(start, parts.piece, degree) * step ** np.arange(degree + 1)[:, None]
        # An impact is a step of length 0 before the first one of its piece.
        jumps = derivative_jumps(curve, 1, IMPACT)
        hits = (np.cumsum(count) - count)[jumps != 0.0]
        start, taylor = np.insert(start, hits, start[hits]), np.insert(taylor, hits, 0.0, axis=1)
        impacts = hits + np.arange(len(hits))
        jump = np.zeros(len(start))
        jump[impacts] = jumps[jumps != 0.0]
        theta = np.append(start, curve.breaks[-1])
        s, before = motion.derivatives(theta, 1), motion.derivatives(theta, 1, "left")
        s[:, impacts], s[:, -1] = before[:, impacts], before[:, -1]
        return cls(theta, taylor, jump, s)


def derivative_jumps(curve: Piecewise, order: int, rounding: float) -> Array:
    """By how much a derivative jumps where each piece begins: (pieces,).

    Jumps of less than ``rounding`` of its largest value at the pieces' ends are 0.
    """
    pieces = np.arange(curve.count)
    after = curve.at(curve.breaks[:-1], pieces, order)
    before = np.roll(curve.at(curve.breaks[1:], pieces, order), 1)
    least = rounding * max(float(np.max(np.abs(each))) for each in (after, before))
    return np.where(np.abs(after - before) > least, after - before, 0.0)


@dataclass(frozen=True, eq=False)
class Response:
    """A train's response over one turn."""

    chain: Chain
    steps: Steps
    omega: float  # [rad/s]
    state: Complex  # (2n, k+1) ξ at the ends of the steps

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
        return self.chain.contact_force(self.deflection[0], self.speed[0])

    @property
    def output_acceleration(self) -> Array:
        """(k+1,) acceleration of the last mass, from the forces on it [mm/s²]."""
        chain, (s, v) = self.chain, self.steps.s
        link = chain.stiffness[-1] @ self.deflection + chain.damping[-1] @ self.speed
        ground = chain.ground_springs[-1] * s + chain.ground_dampers[-1] * v * self.omega
        return np.asarray(-(link + ground) / chain.masses[-1])

    def free_amplitudes(self, angle: float) -> Array:
        """(n, modes) amplitudes of the free vibration where a dwell begins at this angle [mm].

        Of damped modes the envelope's, of overdamped ones the deflection.
        """
        theta = self.steps.theta
        # The last of equal angles: after an impact there.
        k = len(theta) - 1 - int(np.argmin(np.abs(theta[::-1] - angle)))
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
    state, responses = chain.modes.rest_state(float(steps.s[0, 0])), []
    for _ in range(turns):
        states = _recursion(state, factor, added)
        responses.append(Response(chain, steps, omega, states))
        state = states[:, -1]
    return responses


def resonance(modes: Modes, omega: float) -> tuple[float, int] | None:
    """The undamped mode whose frequency [Hz] is a harmonic of the cam's, and that harmonic.

    There the response grows from turn to turn, and no periodic one exists. None: no such mode.
    """
    for rate in modes.rates[modes.independent].tolist():
        harmonic = round(rate.imag / omega)
        # Over a turn the mode changes by this factor, less 1: 0 where it comes back as it was.
        if abs(np.expm1((rate - 1j * harmonic * omega) * FULL_TURN / omega)) < RESONANT:
            return abs(rate) / FULL_TURN, harmonic
    return None


def _transition(modes: Modes, steps: Steps, omega: float) -> tuple[Complex, Complex]:
    """Factor of ξ over every step and what the motion adds to it: (2n, k) each."""
    degree = len(steps.taylor) - 1
    # The φ-functions of every mode at every length of a step [s], of which there are few.
    length = np.diff(steps.theta) / omega
    sizes, which = np.unique(length, return_inverse=True)
    functions = phi(np.multiply.outer(modes.rates, sizes), degree + 1)  # (d+2, 2n, sizes)
    # Order k of the force's Taylor series on ξ, from s, s' and s''; an impact adds s' ω at once.
    derivatives = np.vstack([steps.taylor, np.zeros((2, steps.taylor.shape[1]))])
    moving = length > 0.0
    h = np.where(moving, length, 1.0)
    added = np.zeros((len(modes.rates), len(length)), complex)
    for k in range(degree + 1):
        force = (
            np.multiply.outer(modes.by_acceleration, derivatives[k + 2] / h)
            + np.multiply.outer(modes.by_velocity, derivatives[k + 1])
            + np.multiply.outer(modes.by_displacement, derivatives[k] * h)
        )
        added += functions[k + 1][:, which] * force
    added = np.where(moving, added, np.multiply.outer(modes.by_acceleration, steps.jump * omega))
    return functions[0][:, which], added


def _recursion(start: Complex, factor: Complex, added: Complex) -> Complex:
    """ξ at the ends of all steps: (2n, k+1)."""
    states, state = [start], start
    for each, more in zip(
        np.ascontiguousarray(factor.T), np.ascontiguousarray(added.T), strict=True
    ):
        state = each * state + more
        states.append(state)
    return np.array(states).T


def residual_spectrum(
    motion: Motion, run: Sequence[int], frequencies: Array, damping: float
) -> Array:
    """Residual amplitude at the end of a run of segments, of oscillators at rest before it.

    Exact but for rounding: within every step ∫ s' e^(−λ(Θ − θ)) dθ is a sum of φ-functions. Of
    undamped natural frequencies over the cam's, ω_n/ω (f,), and a damping ratio ζ the amplitudes
    (f,) in the unit of s; ``run`` has the indices of its segments in order.
    """
    steps = Steps.of(motion, 1)
    rate: Complex = np.asarray(frequencies * complex(damping, -sqrt(1.0 - damping**2)), complex)
    total, after = np.zeros(len(frequencies), complex), 0.0
    by_index = {s.index: s for s in motion.segments}
    middle = 0.5 * (steps.theta[1:] + steps.theta[:-1])
    # The later segments first, so that what follows a segment is known: e^(−λ · angle after it).
    for segment in (by_index[index] for index in reversed(run)):
        inside = (middle > segment.start) & (middle < segment.end) & (np.diff(steps.theta) > 0.0)
        width, taylor = np.diff(steps.theta)[inside], steps.taylor[:, inside]
        sizes, which = np.unique(width, return_inverse=True)
        functions = phi(np.multiply.outer(-rate, sizes), len(taylor) - 1)
        each = sum(functions[k][:, which] * taylor[k] for k in range(1, len(taylor)))
        rest = segment.end - steps.theta[1:][inside] + after
        total += np.sum(each * np.exp(-np.multiply.outer(rate, rest)), axis=1)
        after += segment.angle
    return np.asarray(np.abs(total) / sqrt(1.0 - damping**2))
