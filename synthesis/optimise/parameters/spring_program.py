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
ROUNDS, ZOOMS = 12, 10
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

    def least(self, rate: float, preload: float) -> Array:
        """The least force at each place over the speeds [N]."""
        return np.asarray((self.s * rate + preload + self.low) / self.grip)

    def most(self, rate: float, preload: float) -> Array:
        """The largest [N]."""
        return np.asarray((self.s * rate + preload + self.high) / self.grip)


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
            rate, preload, peak, lacking = spring
            missed = self._missed(curve, rate, preload, peak, lacking)
            if missed is None:
                break
            rows = rows.joined(missed)
        seconds = time.perf_counter() - started
        stage = Stage(
            "spring", "LP", "HiGHS", 4, 2 * len(rows.s), steps, seconds, "solved",
            f"least peak of the contact force for this motion: {peak:.6g} N",
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
        (found,) = minimise_each(program, [price])
        if found.stopped is not StopReason.SOLVED:
            raise SolverFailed("HiGHS", found.stopped.value, "The spring's program has no answer.")
        rate, preload, peak, lacking = (found.x * unit).tolist()
        return rate, preload, peak, lacking if lacking > SPARE * force else 0.0

    def _missed(
        self, curve: Piecewise, rate: float, preload: float, peak: float, lacking: float
    ) -> _Rows | None:
        """Rows at the worst places of every piece where the spring breaks them; None: nowhere."""
        found = []
        allowed = MISSED * abs(peak)
        for largest in (True, False):
            piece, x = _spread(curve, DENSE)
            reach = np.diff(curve.breaks) / (DENSE - 1)
            for _ in range(ZOOMS):
                rows = self._at(curve, piece, x)
                value = self._excess(rows, rate, preload, peak, lacking, largest=largest)
                table = value.reshape(curve.count, -1)
                best = np.argmax(table, axis=1)
                x = x.reshape(table.shape)[np.arange(curve.count), best]
                worst = table[np.arange(curve.count), best]
                centre, reach = x, reach / 3.0
                spread = centre[:, None] + reach[:, None] * FAN
                x = np.clip(spread, curve.breaks[:-1, None], curve.breaks[1:, None]).ravel()
                piece = np.repeat(np.arange(curve.count), len(FAN))
            broken = np.flatnonzero(worst > allowed)
            if len(broken):
                found.append(self._at(curve, broken, centre[broken]))
        if not found:
            return None
        return found[0] if len(found) == 1 else found[0].joined(found[1])

    def _excess(
        self, rows: _Rows, rate: float, preload: float, peak: float, lacking: float, *,
        largest: bool,
    ) -> Array:  # fmt: skip
        if largest:
            return np.asarray(rows.most(rate, preload) - peak)
        return np.asarray(self.floor - lacking - rows.least(rate, preload))

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
