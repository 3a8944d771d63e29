"""What is told of the forces of a finished cam: proven extremes, and integrals over the turn."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from scipy.optimize import brentq

from synthesis.certify.course import Course
from synthesis.certify.loaded import Loaded, cuts
from synthesis.certify.quantities import Size, enclose_all, infinite
from synthesis.followers.flank import Flank
from synthesis.forces.history import History, history
from synthesis.forces.reduced import MILLI, Reduced
from synthesis.forces.told import FlankForces, FloatArc, ForcePeak, Forces, RollerLife, Torque
from synthesis.limits.base import Machine, where
from synthesis.motion import Motion
from synthesis.numerics.enclosure import Question
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE, FULL_TURN

NODES: Final = 24  # of a Gauss rule on a piece without waves: exact up to degree 47
WAVE_NODES: Final = 64
SAMPLES: Final = 33  # on a piece, where signs are looked for
ZOOMS: Final = 12
FAN: Final = np.linspace(-1.0, 1.0, 9)
FASTEST: Final = 1e6  # times the cam's speed: beyond, nobody asks
PER_MINUTE: Final = 60.0 / FULL_TURN


def forces(motion: Motion, machine: Machine, size: tuple[float, ...]) -> Forces | None:
    """What the cam's forces come to; None where no load is told."""
    if machine.load is None:
        return None
    return _Cam(Course(motion, cuts(machine)), machine, machine.load, tuple(size)).told()


@dataclass(frozen=True, eq=False)
class _Cam:
    """A finished cam with its load."""

    course: Course
    machine: Machine
    load: Reduced
    size: Size

    def told(self) -> Forces:
        """All of it."""
        flanks = self.machine.follower.flanks
        both = self.load.both_ways
        return Forces(
            flanks=[self._flank(flank) for flank in flanks],
            torque=self._torque(flanks[0]),
            floats=[] if both else list(self._arcs()),
            floats_from_rpm=None if both else self._floats_from(),
            changes_flank_deg=self._crossings() if both else [],
            rollers=[
                self._roller(path)
                for path in dict.fromkeys(flank.path for flank in flanks if flank.roller > 0.0)
            ],
        )

    # -- extremes ----------------------------------------------------------------------------

    def _flank(self, flank: Flank) -> FlankForces:
        pressure = self._peaks.get(("pressure_square", flank.name, 1))
        largest, smallest = (
            self._peaks.get(("contact_force", flank.name, side * flank.side)) for side in (1, -1)
        )
        return FlankForces(
            flank=flank.name,
            largest_n=None if largest is None else _times(largest, flank.side),
            smallest_n=None if smallest is None else _times(smallest, flank.side),
            largest_pressure_mpa=None if pressure is None else _root(pressure),
        )

    def _wanted(self) -> Iterator[tuple[str, Flank, int]]:
        """What is enclosed: quantity, flank, 1 for its largest value or −1 for its smallest."""
        flanks = self.machine.follower.flanks
        for flank in flanks:
            yield "contact_force", flank, 1
            yield "contact_force", flank, -1
            round_ = flank.roller > 0.0 or self.machine.follower.always_convex
            if self.load.contact is not None and round_:
                yield "pressure_square", flank, 1
        yield "camshaft_torque", flanks[0], 1
        yield "camshaft_torque", flanks[0], -1

    @cached_property
    def _peaks(self) -> dict[tuple[str, str, int], ForcePeak]:
        """Finite extremes by quantity, flank and sense, all enclosed at once."""
        everywhere = where(self.course.motion.stretches)
        pieces = self.course.pieces(everywhere)
        wanted = list(self._wanted())
        each = {(name, flank.name): flank for name, flank, _ in wanted}
        subjects = [
            (Loaded(name, self.machine, self.load, self.course, flank, self.size), flank.path)
            for (name, _), flank in each.items()
        ]
        if infinite(subjects[0][0], self.course, everywhere):
            return {}
        ends = {1: (-math.inf, 0.0), -1: (0.0, math.inf)}
        which = {key: k for k, key in enumerate(each)}
        questions = [
            Question(pieces, *ends[side], function=which[name, flank.name])
            for name, flank, side in wanted
        ]
        answers = enclose_all(subjects, self.course, self.machine, self.size, questions)
        found = {}
        for (name, flank, side), answer in zip(wanted, answers, strict=True):
            peak = answer.extreme
            if math.isfinite(peak.width):
                found[name, flank.name, side] = ForcePeak(
                    value=peak.value, angle_deg=peak.angle / DEGREE, width=peak.width
                )
        return found

    # -- integrals ---------------------------------------------------------------------------

    @cached_property
    def _nodes(self) -> tuple[Array, Array]:
        """Cam angles of a Gauss rule on every piece, inside it, and the weights: (n,) each."""
        curve = self.course.curve
        count = WAVE_NODES if curve.waves.shape[1] else NODES
        nodes, weights = np.polynomial.legendre.leggauss(count)
        half = 0.5 * np.diff(curve.breaks)[:, None]
        middle = 0.5 * (curve.breaks[1:] + curve.breaks[:-1])[:, None]
        return (middle + half * nodes).ravel(), (half * weights).ravel()

    @cached_property
    def _turn(self) -> History:
        return self._history(self._nodes[0])

    def _history(self, theta: Array) -> History:
        machine, motion = self.machine, self.course.motion
        return history(machine.follower, self.load, machine.omega, motion, self.size, theta)

    def _torque(self, flank: Flank) -> Torque:
        turn, (_, weights) = self._turn, self._nodes
        speed = turn.s[1] * MILLI  # m per rad
        work = float(weights @ turn.torque)
        against = self.load.process(turn.theta) * speed
        process = float(weights @ against)
        loss = float(weights @ ((turn.damping + turn.friction) * speed))
        return Torque(
            largest_n_m=self._peaks.get(("camshaft_torque", flank.name, 1)),
            smallest_n_m=self._peaks.get(("camshaft_torque", flank.name, -1)),
            mean_n_m=work / FULL_TURN,
            rms_n_m=math.sqrt(float(weights @ turn.torque**2) / FULL_TURN),
            power_w=work / FULL_TURN * self.machine.omega,
            work_j=work,
            process_work_j=process,
            loss_j=loss,
            imbalance_j=work - process - loss,
        )

    def _roller(self, path: str) -> RollerLife:
        turn, (_, weights), bearing = self._turn, self._nodes, self.load.bearing
        mine = [flank.name for flank in self.machine.follower.flanks if flank.path == path]
        forces = np.array([turn.contact[name] for name in mine])
        pressed = np.argmax(forces, axis=0), np.arange(forces.shape[1])
        speed = np.array([turn.rolling[name] for name in mine])[pressed]
        mean = float(weights @ speed) / FULL_TURN
        known = RollerLife(
            path=path, mean_speed_rpm=mean * PER_MINUTE,
            largest_speed_rpm=float(speed.max()) * PER_MINUTE,
            equivalent_load_n=None, life_million_turns=None, life_hours=None,
        )  # fmt: skip
        if bearing is None or mean <= 0.0:
            return known
        borne = np.maximum(forces[pressed], 0.0)
        p = bearing.life_exponent
        largest = float(borne.max())
        if largest <= 0.0:
            return known
        share = float(weights @ ((borne / largest) ** p * speed)) / (mean * FULL_TURN)
        equal = largest * share ** (1.0 / p)
        life = (bearing.dynamic_rating_n / equal) ** p
        hours = life * 1e6 / (60.0 * mean * PER_MINUTE)
        return known.model_copy(
            update={"equivalent_load_n": equal, "life_million_turns": life, "life_hours": hours}
        )

    # -- float -------------------------------------------------------------------------------

    @cached_property
    def _grid(self) -> Array:
        """Cam angles (pieces, samples), just inside the pieces at their ends."""
        breaks = self.course.curve.breaks
        step = np.linspace(1e-9, 1.0 - 1e-9, SAMPLES)
        return np.asarray(breaks[:-1, None] + np.diff(breaks)[:, None] * step)

    def _pressed(self, theta: Array) -> Array:
        """The drive in the sense in which the follower is pressed on its cam [N]."""
        return self.load.side * self._history(theta).drive

    def _arcs(self) -> Iterator[FloatArc]:
        theta = self._grid.ravel()
        force = self._pressed(theta)
        apart = force <= 0.0
        if not apart.any():
            return
        shift = 0 if apart.all() else int(np.argmin(apart))
        theta = np.concatenate([theta[shift:], theta[:shift] + FULL_TURN])
        force, apart = np.roll(force, -shift), np.roll(apart, -shift)
        ends = np.flatnonzero(np.diff(np.concatenate([[False], apart, [False]])))
        contact = self.machine.follower.flanks[0].name
        for first, stop in zip(ends[::2], ends[1::2], strict=True):
            at = theta[first:stop]
            pressed = self._history(at % FULL_TURN).contact[contact]
            worst = int(np.argmin(pressed))
            yield FloatArc(
                start_deg=self._zero(theta, force, first) / DEGREE % 360.0,
                end_deg=self._zero(theta, force, stop) / DEGREE % 360.0,
                lowest_n=float(pressed[worst]), angle_deg=float(at[worst] / DEGREE) % 360.0,
            )  # fmt: skip

    def _crossings(self) -> list[float]:
        theta = self._grid.ravel()
        force = self._pressed(theta)
        sign = np.flatnonzero(np.sign(force[1:]) * np.sign(force[:-1]) < 0.0)
        return [self._zero(theta, force, k + 1) / DEGREE % 360.0 for k in sign.tolist()]

    def _zero(self, theta: Array, force: Array, k: int) -> float:
        """Where the drive vanishes between sample k − 1 and k; of a jump, its place."""
        if k in (0, len(theta)):
            return float(theta[min(k, len(theta) - 1)])
        low, high = float(theta[k - 1]), float(theta[k])

        def at(x: float) -> float:
            return float(self._pressed(np.array([x % FULL_TURN]))[0])

        if at(low) * at(high) >= 0.0:
            return high
        return float(brentq(at, low, high, xtol=1e-14))

    def _floats_from(self) -> float | None:
        """The lowest speed at which the drive vanishes somewhere [rpm]."""
        theta = self._grid
        reach = np.diff(self.course.curve.breaks)[:, None] / (SAMPLES - 1)
        low, high = theta[:, :1], theta[:, -1:]
        for _ in range(ZOOMS):
            value = self._critical(theta.ravel()).reshape(theta.shape)
            best = np.argmin(value, axis=1)[:, None]
            theta = np.clip(np.take_along_axis(theta, best, 1) + reach * FAN, low, high)
            reach = reach / 3.0
        least = float(np.min(value))
        return least * PER_MINUTE if least <= FASTEST * self.machine.omega else None

    def _critical(self, theta: Array) -> Array:
        """The least ω ≥ 0 at which the drive vanishes at a cam angle, ∞ where none does [rad/s]."""
        load, s = self.load, self.course.motion.derivatives(theta, 2)
        rest = load.side * (load.rate * s[0] + load.constant + load.process(theta))
        a, b = (
            load.side * MILLI * m * each for m, each in ((load.mass, s[2]), (load.damping, s[1]))
        )
        with np.errstate(all="ignore"):
            # a ω² + b ω + rest = 0 by the stable formula: 2 rest/(−b ± √(b² − 4 a rest))
            root = np.sqrt(b * b - 4.0 * a * rest)
            found = [2.0 * rest / (-b + root), 2.0 * rest / (-b - root)]
        each = [np.where(np.isfinite(w) & (w > 0.0), w, np.inf) for w in found]
        return np.where(rest <= 0.0, 0.0, np.minimum(*each))


def _times(peak: ForcePeak, factor: int) -> ForcePeak:
    return peak.model_copy(update={"value": factor * peak.value})


def _root(square: ForcePeak) -> ForcePeak:
    value = math.sqrt(max(square.value, 0.0))
    width = 0.5 * square.width / value if value > 0.0 else math.sqrt(max(square.width, 0.0))
    return ForcePeak(value=value, angle_deg=square.angle_deg, width=width)
