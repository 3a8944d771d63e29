"""The closing spring: the least peak of the contact force at which the follower does not float.

At every cam angle and every speed asked for the contact force is linear in rate k and preload F0,

    N = (σ s k + F0 + σ (m s'' ω² + c s' ω + P + W)) / (λ cos α − friction),

and of the speed no more than three values can be extreme. So the best spring of a given motion is a
linear program in k, F0 and the peak, solved by exchange: rows at some cam angles, then at the worst
between them, until nothing is missed.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from synthesis.catalogue.followers.kinematics import pressure_angle_sine_cosine
from synthesis.catalogue.forces.reduced import MILLI, ReducedLoad
from synthesis.catalogue.limits.base import Machine
from synthesis.catalogue.motion import Motion, PlacedSegment
from synthesis.errors import SolverFailed
from synthesis.numerics.piecewise import Array, Piecewise
from synthesis.numerics.solvers.highs import LinearRows, minimise_each
from synthesis.numerics.solvers.statuses import StopReason
from synthesis.optimise.state.solve_state import Stage

FIRST, DENSE = 9, 33  # points on a piece: of the first rows, of the search for what they miss
ROUNDS, ZOOMS = 12, 10  # of adding rows; of narrowing the place of a peak
FAN: Final = np.linspace(-1.0, 1.0, 9)
MISSED = 1e-10  # of the peak: what rows between their points may miss
SPARE = 1e-4  # of the largest force without a spring: kept off float, for the certificate's sake
FLOATING = 1e4  # price of a newton of float, in newtons of peak: no spring helps where it is paid

Indices = NDArray[np.intp]


@dataclass(frozen=True)
class ChosenSpring:
    """A spring for a given motion.

    Attributes:
        rate, preload: along the displacement [N/mm, N].
        peak: largest contact force at any speed asked for [N]. lacking: what it floats by [N].
    """

    rate: float
    preload: float
    peak: float
    lacking: float
    stage: Stage


@dataclass(frozen=True, eq=False)
class _Rows:
    """N at n places: (s k + F0 + low)/grip at least, (s k + F0 + high)/grip at most; (n,) each."""

    s: Array
    low: Array
    high: Array
    grip: Array

    def joined(self, other: _Rows) -> _Rows:
        """These and the others."""
        pairs = zip(vars(self).values(), vars(other).values(), strict=True)
        return _Rows(*(np.concatenate(pair) for pair in pairs))


@dataclass(frozen=True, eq=False)
class SpringProgram:
    """A finished cam whose spring is sought.

    Attributes:
        rates, preloads: ends of what may be chosen, along the displacement.
        floor: contact force that must be left at least [N].
    """

    motion: Motion
    machine: Machine
    load: ReducedLoad
    size: tuple[float, ...]
    rates: tuple[float, float]
    preloads: tuple[float, float]
    floor: float = 0.0

    def chosen(self) -> ChosenSpring:
        """The best spring.

        Raises:
            SolverFailed: HiGHS gave no answer.
        """
        started = time.perf_counter()
        curve, _ = self.motion.curve.split_at(self.load.process.breaks[1:-1])
        piece, x = _spread(curve, FIRST)
        rows, steps, spring = self._at(curve, piece, x), 0, (0.0, 0.0, 0.0, 0.0)
        for _ in range(ROUNDS):
            steps += 1
            spring = self._solved(rows)
            violated = self._violated(curve, *spring)
            if violated is None:
                break
            rows = rows.joined(violated)
        seconds = time.perf_counter() - started
        stage = Stage(
            "spring", "LP", "HiGHS", 4, 2 * len(rows.s), steps, seconds, "solved",
            f"least peak of the contact force for this motion: {spring[2]:.6g} N",
        )  # fmt: skip
        return ChosenSpring(*spring, stage)

    def _solved(self, rows: _Rows) -> tuple[float, float, float, float]:
        """Rate, preload, peak and float of the rows at hand."""
        force = float(np.max(np.abs(rows.high) + np.abs(rows.low), initial=1e-300))
        long = float(np.max(np.abs(rows.s), initial=1e-300))
        unit = np.array([force / long, force, force, force])
        grip, one = rows.grip, np.ones(len(rows.s))
        floor = self.floor + SPARE * force
        off = np.stack([-rows.s, -one, 0.0 * one, -grip], axis=1)
        below = np.stack([rows.s, one, -grip, 0.0 * one], axis=1)
        matrix = np.concatenate([off, below]) * unit / force
        rhs = np.concatenate([rows.low - floor * grip, -rows.high]) / force
        ends = (self.rates, self.preloads, (-np.inf, np.inf), (0.0, np.inf))
        low, high = (np.array([end[k] for end in ends]) / unit for k in (0, 1))
        program = LinearRows(sparse.csc_matrix(matrix), rhs, 0, low, high)
        # of springs of one peak the softest
        price = np.array([1e-9, 1e-9, 1.0, FLOATING])
        (result,) = minimise_each(program, [price])
        if result.stopped is not StopReason.SOLVED:
            raise SolverFailed("HiGHS", result.stopped.value, "The spring's program has no answer.")
        rate, preload, peak, lacking = (result.x * unit).tolist()
        return rate, preload, peak, lacking if lacking > SPARE * force else 0.0

    def _violated(
        self, curve: Piecewise, rate: float, preload: float, peak: float, lacking: float
    ) -> _Rows | None:
        """Rows at the worst places of every piece where the spring violates them; None: nowhere."""
        result, pieces, allowed = None, np.arange(curve.count), MISSED * abs(peak)
        for largest in (True, False):
            piece, x = _spread(curve, DENSE)
            reach = np.diff(curve.breaks) / (DENSE - 1)
            for _ in range(ZOOMS):
                rows = self._at(curve, piece, x)
                spring = rows.s * rate + preload
                if largest:
                    excess = (spring + rows.high) / rows.grip - peak
                else:
                    excess = self.floor - lacking - (spring + rows.low) / rows.grip
                table = excess.reshape(curve.count, -1)
                best = np.argmax(table, axis=1)
                worst, centre = table[pieces, best], x.reshape(table.shape)[pieces, best]
                reach = reach / 3.0
                spread = centre[:, None] + reach[:, None] * FAN
                x = np.clip(spread, curve.breaks[:-1, None], curve.breaks[1:, None]).ravel()
                piece = np.repeat(pieces, len(FAN))
            beyond = np.flatnonzero(worst > allowed)
            if len(beyond):
                rows = self._at(curve, beyond, centre[beyond])
                result = rows if result is None else result.joined(rows)
        return result

    def _at(self, curve: Piecewise, piece: Indices, x: Array) -> _Rows:
        """What the force is made of at cam angles of pieces."""
        load, flank = self.load, self.machine.follower.flanks[0]
        s = curve.jet(x, piece, 3)
        middle = 0.5 * (curve.breaks[:-1] + curve.breaks[1:])
        process = load.process.at(x, load.process.piece_of(middle)[piece], 0)
        sine, cosine = pressure_angle_sine_cosine(flank.trace, s, self.size)
        starts = np.array([segment.start for segment in self._placed])
        which = np.searchsorted(starts, middle[piece], side="right") - 1
        sense = np.array([load.sliding_sense(segment) for segment in self._placed])[which]
        grip = cosine * flank.trace.lever(s, self.size)
        grip = grip - load.friction_loss(sense, sine, s[0], np.abs)
        slow, fast = load.speeds
        with np.errstate(all="ignore"):
            turning = -load.damping * s[1] / (2.0 * load.mass * s[2])
        turning = np.where(np.isfinite(turning), np.clip(turning, slow, fast), slow)
        moved = [
            load.side * MILLI * (load.mass * w * w * s[2] + load.damping * w * s[1])
            for w in (slow, fast, turning)
        ]
        rest = load.side * (process + load.weight)
        return _Rows(
            load.side * s[0], rest + np.min(moved, axis=0), rest + np.max(moved, axis=0), grip
        )

    @property
    def _placed(self) -> list[PlacedSegment]:
        return [segment for segment in self.motion.segments if segment.angle > 0.0]


def _spread(curve: Piecewise, count: int) -> tuple[Indices, Array]:
    """Points on every piece, ends included."""
    step = np.linspace(0.0, 1.0, count)
    x = (curve.breaks[:-1, None] + np.diff(curve.breaks)[:, None] * step).ravel()
    return np.repeat(np.arange(curve.count), count), x
