"""The forces of a finished cam: proven extremes, integrals over the turn, lift-off, roller life."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from scipy.optimize import brentq

from synthesis.catalogue.followers.kinematics import Flank
from synthesis.catalogue.forces.reduced import MILLI, ForceHistory, ReducedLoad, history
from synthesis.catalogue.limits.base import Machine, segment_indices
from synthesis.catalogue.motion import Motion
from synthesis.certify.quantities import BOUNDS, MeasuredCam, force_quantity, infinite_by_jump
from synthesis.design.design import FlankForces, FloatArc, ForcePeak, Forces, RollerLife, Torque
from synthesis.numerics.enclosure import ExtremumQuery
from synthesis.numerics.maxima import maximise_between
from synthesis.numerics.piecewise import Array, Indices, gauss_points
from synthesis.units import DEGREE, FULL_TURN, PER_MINUTE

NODES: Final = 24  # of the Gauss rule on a piece without sinusoids: exact up to degree 47
WAVE_NODES: Final = 64  # Gauss points on a piece with sinusoids
SAMPLES: Final = 33  # on a piece, between which the drive is searched for changes of sign
INSIDE: Final = 1e-9  # of a piece: samples at its ends lie so far inside, on this side of jumps
HIGHEST_SPEED: Final = 1e6  # times the cam's speed: a lift-off beyond is not reported


def report_forces(motion: Motion, machine: Machine, size: tuple[float, ...]) -> Forces | None:
    """What the cam's forces come to; None if the spec gives no load."""
    if machine.load is None:
        return None
    return _LoadedCam(MeasuredCam.of(motion, machine, size), machine.load).report()


@dataclass(frozen=True, eq=False)
class _LoadedCam:
    """A finished cam with its load."""

    cam: MeasuredCam
    load: ReducedLoad

    def report(self) -> Forces:
        flanks = self.cam.machine.follower.flanks
        both = self.load.pushed_both_ways
        return Forces(
            flanks=[self._flank(flank) for flank in flanks],
            torque=self._torque(flanks[0]),
            floats=[] if both else list(self._lift_off_arcs()),
            float_onset_rpm=None if both else self._lift_off_speed(),
            changes_flank_deg=self._flank_changes() if both else [],
            rollers=[
                self._roller(path)
                for path in dict.fromkeys(flank.path for flank in flanks if flank.roller > 0.0)
            ],
        )

    def _flank(self, flank: Flank) -> FlankForces:
        pressure = self._peaks.get(("pressure_square", flank.name, 1))
        return FlankForces(
            flank=flank.name,
            largest_n=self._peaks.get(("contact_force", flank.name, 1)),
            smallest_n=self._peaks.get(("contact_force", flank.name, -1)),
            largest_pressure_mpa=None if pressure is None else _square_root(pressure),
        )

    @cached_property
    def _peaks(self) -> dict[tuple[str, str, int], ForcePeak]:
        """Finite extremes by quantity, flank and sense, all enclosed together."""
        cam, flanks = self.cam, self.cam.machine.follower.flanks
        everywhere, both = segment_indices(cam.motion.segments), (1, -1)
        # 1. what is measured on which flank, and in which senses
        convex, lined = cam.machine.follower.always_convex, self.load.contact is not None
        measured = [
            *(("contact_force", flank, both) for flank in flanks),
            *(("pressure_square", f, (1,)) for f in flanks if lined and (f.roller > 0.0 or convex)),
            ("camshaft_torque", flanks[0], both),
        ]
        subjects = [(force_quantity(name, flank, cam), flank.path) for name, flank, _ in measured]
        if infinite_by_jump(subjects[0][0], cam.motion, everywhere):
            return {}
        # 2. enclose
        wanted = [(k, side) for k, (_, _, sides) in enumerate(measured) for side in sides]
        pieces = cam.motion.pieces_of(everywhere)
        questions = [ExtremumQuery(pieces, *BOUNDS[side], function=k) for k, side in wanted]
        found = {}
        for (k, side), answer in zip(wanted, cam.enclose(subjects, questions), strict=True):
            (name, flank, _), peak = measured[k], answer.enclosure
            # a contact force is reported as it presses its flank, whichever side that is on
            sign = flank.side if name == "contact_force" else 1
            if math.isfinite(peak.width):
                found[name, flank.name, side * sign] = ForcePeak(
                    value=sign * peak.value, angle_deg=peak.angle / DEGREE, width=peak.width
                )
        return found

    @cached_property
    def _nodes(self) -> tuple[Array, Array]:
        """Nodes inside the pieces [rad] and weights: (n,) each."""
        curve = self.cam.motion.curve
        nodes, weights = gauss_points(curve.breaks, WAVE_NODES if curve.waves.shape[1] else NODES)
        return nodes.ravel(), weights.ravel()

    @cached_property
    def _turn(self) -> ForceHistory:
        return self._history(self._nodes[0])

    def _history(self, theta: Array) -> ForceHistory:
        machine, motion = self.cam.machine, self.cam.motion.original
        return history(machine.follower, self.load, machine.omega, motion, self.cam.size, theta)

    def _torque(self, flank: Flank) -> Torque:
        """Torque over the turn; its work less the process's and the losses is the imbalance."""
        turn, (_, weights) = self._turn, self._nodes
        speed = turn.s[1] * MILLI  # m per rad
        work = float(weights @ turn.torque)
        process = float(weights @ (self.load.process(turn.theta) * speed))
        loss = float(weights @ ((turn.damping + turn.friction) * speed))
        return Torque(
            largest_n_m=self._peaks.get(("camshaft_torque", flank.name, 1)),
            smallest_n_m=self._peaks.get(("camshaft_torque", flank.name, -1)),
            mean_n_m=work / FULL_TURN,
            rms_n_m=math.sqrt(float(weights @ turn.torque**2) / FULL_TURN),
            power_w=work / FULL_TURN * self.cam.machine.omega,
            work_j=work,
            process_work_j=process,
            loss_j=loss,
            balance_error_j=work - process - loss,
        )

    def _roller(self, path: str) -> RollerLife:
        """Speed of a roller and its bearing's basic rating life at varying load and speed."""
        (_, weights), bearing = self._nodes, self.load.bearing
        force, speed = self._pressed(path, self._turn)
        mean = float(weights @ speed) / FULL_TURN
        force = np.maximum(force, 0.0)
        largest, equivalent, life, hours = float(force.max()), None, None, None
        if bearing is not None and mean > 0.0 and largest > 0.0:
            # equivalent load: the mean of F^p over the roller's revolutions, to the power 1/p
            p = bearing.life_exponent
            share = float(weights @ ((force / largest) ** p * speed)) / (mean * FULL_TURN)
            equivalent = largest * share ** (1.0 / p)
            life = (bearing.dynamic_rating_n / equivalent) ** p
            hours = life * 1e6 / (60.0 * mean * PER_MINUTE)
        return RollerLife(
            path=path, mean_speed_rpm=mean * PER_MINUTE,
            largest_speed_rpm=self._largest_speed(path) * PER_MINUTE, equivalent_load_n=equivalent,
            life_million_turns=life, life_hours=hours,
        )  # fmt: skip

    def _pressed(self, path: str, turn: ForceHistory) -> tuple[Array, Array]:
        """Contact force [N] and speed on its pin [rad/s] of a roller: (n,) each.

        Of a roller between two flanks they are those of the flank that it presses.
        """
        mine = [flank.name for flank in self.cam.machine.follower.flanks if flank.path == path]
        forces = np.array([turn.contact[name] for name in mine])
        pressed = np.argmax(forces, axis=0), np.arange(forces.shape[1])
        return forces[pressed], np.array([turn.rolling[name] for name in mine])[pressed]

    def _largest_speed(self, path: str) -> float:
        """The largest speed of a roller on its pin [rad/s]."""

        def speed(theta: Array, _: Indices) -> Array:
            return self._pressed(path, self._history(theta))[1].reshape(theta.shape)

        return maximise_between(speed, self._grid[:, 0], self._grid[:, -1])[0]

    @cached_property
    def _grid(self) -> Array:
        """Cam angles (pieces, samples), just inside the pieces at their ends [rad]."""
        breaks = self.cam.motion.curve.breaks
        step = np.linspace(INSIDE, 1.0 - INSIDE, SAMPLES)
        return np.asarray(breaks[:-1, None] + np.diff(breaks)[:, None] * step)

    def _pressing(self, theta: Array) -> Array:
        """The drive, positive where it presses the follower on its cam [N]."""
        return self.load.side * self._history(theta).drive

    @cached_property
    def _samples(self) -> tuple[Array, Array]:
        """All sampled cam angles, and the drive there."""
        theta = self._grid.ravel()
        return theta, self._pressing(theta)

    def _lift_off_arcs(self) -> Iterator[FloatArc]:
        """Arcs of cam angle on which the follower would lift off, from the signs of samples."""
        theta, force = self._samples
        off = force <= 0.0
        if not off.any():
            return
        # from one sample in contact round to the same: no arc lies across the end of the turn
        around = int(np.argmin(off)) + np.arange(len(off) + (not off.all()))
        turns, index = np.divmod(around, len(off))
        theta, force, off = theta[index] + FULL_TURN * turns, force[index], off[index]
        ends = np.flatnonzero(np.diff(np.concatenate([[False], off, [False]])))
        contact = self.cam.machine.follower.flanks[0].name
        for first, stop in zip(ends[::2], ends[1::2], strict=True):
            lowest, where = self._lowest(theta[first:stop], contact)
            yield FloatArc(
                start_deg=self._zero(theta, force, first) / DEGREE % 360.0,
                end_deg=self._zero(theta, force, stop) / DEGREE % 360.0,
                lowest_n=lowest, angle_deg=where / DEGREE % 360.0,
            )  # fmt: skip

    def _lowest(self, theta: Array, flank: str) -> tuple[float, float]:
        """Lowest contact force [N] on neighbouring samples and beside the lowest of them, where."""

        def contact(theta: Array, _: object = None) -> Array:
            force = self._history(theta.ravel() % FULL_TURN).contact[flank]
            return np.asarray(-force).reshape(theta.shape)

        forces = contact(theta)
        worst = int(np.argmax(forces))
        most, where = float(forces[worst]), float(theta[worst])
        beside = theta[max(worst - 1, 0) : worst + 2]  # breaks are samples: no jump between them
        if len(beside) > 1:
            most, where = max((most, where), maximise_between(contact, beside[:-1], beside[1:]))
        return -most, where

    def _flank_changes(self) -> list[float]:
        """Cam angles at which the drive changes its sign, and the follower its flank [deg]."""
        theta, force = self._samples
        sign = np.flatnonzero(np.sign(force[1:]) * np.sign(force[:-1]) < 0.0)
        return [self._zero(theta, force, k + 1) / DEGREE % 360.0 for k in sign.tolist()]

    def _zero(self, theta: Array, force: Array, k: int) -> float:
        """Where the drive vanishes between samples k − 1 and k; at a jump, where it is [rad]."""
        if k in (0, len(theta)):
            return float(theta[min(k, len(theta) - 1)])
        low, high = float(theta[k - 1]), float(theta[k])

        def at(x: float) -> float:
            return float(self._pressing(np.array([x % FULL_TURN]))[0])

        if at(low) * at(high) >= 0.0:
            return high
        return float(brentq(at, low, high))

    def _lift_off_speed(self) -> float | None:
        """The lowest speed at which the drive vanishes somewhere [rpm]."""
        low, high = self._grid[:, 0], self._grid[:, -1]
        least = -maximise_between(lambda x, _: -self._critical_speed(x), low, high)[0]
        return least * PER_MINUTE if least <= HIGHEST_SPEED * self.cam.machine.omega else None

    def _critical_speed(self, theta: Array) -> Array:
        """The least ω ≥ 0 at which the drive vanishes at cam angles; ∞ if at none [rad/s]."""
        load, s = self.load, self.cam.motion.original.derivatives(theta, 2)
        s = s.reshape(3, *theta.shape)
        rest = load.side * (load.rate * s[0] + load.constant_force + load.process(theta))
        a, b = (
            load.side * MILLI * m * each for m, each in ((load.mass, s[2]), (load.damping, s[1]))
        )
        with np.errstate(all="ignore"):
            # a ω² + b ω + rest = 0, without cancellation: 2 rest/(−b ± √(b² − 4 a rest)). With
            # rest > 0 the root of the upper sign is the least positive one, or there is none.
            found = 2.0 * rest / (-b + np.sqrt(b * b - 4.0 * a * rest))
        positive = np.where(np.isfinite(found) & (found > 0.0), found, np.inf)
        return np.where(rest <= 0.0, 0.0, positive)


def _square_root(square: ForcePeak) -> ForcePeak:
    value = math.sqrt(max(square.value, 0.0))
    width = 0.5 * square.width / value if value > 0.0 else math.sqrt(max(square.width, 0.0))
    return ForcePeak(value=value, angle_deg=square.angle_deg, width=width)
