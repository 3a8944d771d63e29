"""The grooves of a spatial cam's body: where a cut through the blank finds their walls.

A row is a half-plane through the cam's axis, named by the cam angle t at which it faces the
follower; in it a wall is one place across at every depth. The contact of roller and wall that lies
in row t at depth d belongs to another cam angle θ and a place ρ on the roller's axis; these two
follow from two equations, by Newton's method for all rows and depths at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from synthesis.errors import InputError
from synthesis.geometry.charts import Chart
from synthesis.geometry.swept_roller import Place, dot, norm
from synthesis.numerics.piecewise import Array
from synthesis.spatial.cam import SpatialCam
from synthesis.spatial.frame import CamFrame
from synthesis.spatial.machine import LEFT, RIGHT, Seat, SpatialMachine
from synthesis.units import DEGREE, FULL_TURN

STEPS = 40
NEAR = 1e-10  # of a root: in rad and mm
WRONG = 1e-7  # no root
TURN, PLACE = 0.05, 0.03  # longest steps: of θ [rad], and of ρ in largest depths
NUDGE = 1e-6  # for differences: rad and mm
SAME = 1e-6  # of places of rollers
FAR = 1.0  # how far from the blank a roller's wall is still looked for, in widths of the blank
FOLLOWED = 721  # cam angles at which the rollers are followed over the turn


@dataclass(frozen=True, eq=False)
class Grooves:
    """All grooves at rows t and depths d, in order of their places.

    Attributes:
        low, high: (k, n, m) places across of their two walls; ±∞ where they are off the blank, or
            where that side of the roller does not run on the cam.
        shift: the groove i at the end of the turn is the groove i + shift at its start.
    """

    low: Array
    high: Array
    shift: int


class _Laid(NamedTuple):
    """Contacts (n,) as a chart has them, and whether their wall is regular there."""

    turn: Array
    depth: Array
    across: Array
    regular: Array


@dataclass(frozen=True, eq=False)
class Cuts:
    """Cuts through the grooves of one cam.

    Attributes:
        cam, machine: whose. chart: of its blank.
        mesh: least and largest place q of a roller in mesh [rad or mm], maybe infinite.
        straight: whether walls run on along the rollers' axes below the rollers' ends, where
            nothing touches them, and not as longer rollers would leave them.
    """

    cam: SpatialCam
    machine: SpatialMachine
    chart: Chart
    mesh: tuple[float, float]
    straight: bool = False

    @classmethod
    def of(cls, cam: SpatialCam, machine: SpatialMachine, straight: bool = False) -> Cuts:
        """Of a machine's cam."""
        chart, mesh = machine.chart(cam.sizes), machine.mesh(cam.sizes)
        return cls(cam, machine, chart, mesh, straight)

    def laid(self, point: Array) -> tuple[Array, Array, Array]:
        """Angle about the cam's axis, depth and place across of points of the machine's frame.

        Args:
            point: (3, …) as they stand; the cam is not turned.
        """
        swept = self.cam.swept
        away = point - swept.centre.reshape((3,) + (1,) * (point.ndim - 1))
        x, y, z = np.tensordot(CamFrame.of(swept).axes, away, axes=1)
        depth, across = self.chart.laid(np.hypot(x, y), z)
        return np.arctan2(y, x), depth, across

    def axes(self, rho: float) -> Array:
        """Places ρ of all rollers' axes over the turn, while they are in mesh: (3, n, 1) [mm]."""
        swept = self.cam.swept
        q = np.concatenate([self._followed(seat) for seat in self.machine.seats()])
        return swept.joint.moved((swept.origin + rho * swept.along).reshape(3, 1, 1), q)

    def directions(self) -> Array:
        """Directions of these axes: (3, n, 1)."""
        q = np.concatenate([self._followed(seat) for seat in self.machine.seats()])
        return self.cam.swept.joint.turned(self.cam.swept.along.reshape(3, 1, 1), q)

    def _followed(self, seat: Seat) -> Array:
        q = self.cam.place(seat, np.linspace(0.0, FULL_TURN, FOLLOWED)).q
        return np.asarray(np.append(q[(q >= self.mesh[0]) & (q <= self.mesh[1])],
                                    [end for end in self.mesh if np.isfinite(end)]))  # fmt: skip

    def grooves(self, turn: Array, depth: Array) -> Grooves:
        """The grooves at rows ``turn`` (n,) [rad] and ``depth`` (m,) [mm].

        Raises:
            InputError: a wall is undercut, or has a step, so that there is no single place.
        """
        seats = self.seats()
        low, high = (
            np.stack([self._wall(seat, side, turn, depth) for seat in seats])
            for side in (LEFT, RIGHT)
        )
        return Grooves(low, high, self._shift([seat.start for seat in seats]))

    def seats(self) -> list[Seat]:
        """All rollers that may come near, those of other turns too, in order of their places."""
        gain, (least, most) = self.cam.gain, self.mesh
        reach = int(np.ceil(FAR * (most - least) / abs(gain))) + 2 if gain else 0
        found = [
            Seat(seat.number, seat.start + gain * turn, seat.sides)
            for seat in self.machine.seats()
            for turn in range(-reach, reach + 1)
        ]
        found.sort(key=lambda seat: seat.start)
        kept = [a for a, b in zip(found, [*found[1:], None], strict=True)
                if b is None or b.start - a.start > SAME]  # fmt: skip
        return [seat for seat in kept if np.any(self._near(self._followed_all(seat)))]

    def _followed_all(self, seat: Seat) -> Array:
        return self.cam.place(seat, np.linspace(0.0, FULL_TURN, FOLLOWED)).q

    def _near(self, q: Array) -> Array:
        least, most = self.mesh
        far = FAR * (most - least)
        return np.asarray((q > least - far) & (q < most + far))

    def _shift(self, starts: list[float]) -> int:
        """How many places of the order the follower goes on by in a turn."""
        if len(starts) < 2:
            return 0
        return round(self.cam.gain / (starts[1] - starts[0]))

    def _wall(self, seat: Seat, side: int, turn: Array, depth: Array) -> Array:
        """Places across (n, m)."""
        t, d = (each.ravel() for each in np.meshgrid(turn, depth, indexing="ij"))
        if side not in seat.sides:
            return np.full((len(turn), len(depth)), side * np.inf)
        q = self.cam.place(seat, t).q
        across = np.where(q > self.mesh[1], np.inf, -np.inf)
        sound = np.full(len(t), True)
        near = self._near(q)
        if np.any(near):
            across[near], sound[near] = self.walls(seat, side, t[near], d[near])
        shape = len(turn), len(depth)
        return _straight_down(across.reshape(shape), sound.reshape(shape))

    def walls(self, seat: Seat, side: int, t: Array, d: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Places across in rows t at depths d (n,), and where they are a wall's.

        Raises:
            InputError: as ``grooves``.
        """
        with np.errstate(all="ignore"):  # what runs off far from the blank is seen below
            found, wrong = self._solved(seat, side, t, d)
        q = self.cam.place(seat, t).q
        solved = wrong < WRONG
        met = (q > self.mesh[0]) & (q < self.mesh[1])
        bad = met & ~(solved & (found.regular > 0.0))
        ends = np.array([self.cam.swept.roller.inner, self.cam.swept.roller.outer])
        reached = d <= np.max(self.chart.nominal(ends))
        self._check(t, d, bad & reached, side)
        away = np.where(q > np.clip(0.0, *self.mesh), np.inf, -np.inf)
        return np.where(solved, found.across, away), ~bad

    def _solved(self, seat: Seat, side: int, t: Array, d: Array) -> tuple[_Laid, Array]:
        """The contacts in rows t at depths d (n,), and how wrong they are."""
        theta, rho = t.copy(), self.chart.nominal(d)
        size = float(np.max(np.abs(d)))
        for _ in range(STEPS):
            found = self._laid(seat, side, theta, rho)
            turned, sunk = found.turn - t, found.depth - d
            if np.nanmax(np.abs([turned, sunk]), initial=0.0) < NEAR:
                break
            a, c = self._difference(seat, side, theta, rho, NUDGE, 0.0)
            b, e = self._difference(seat, side, theta, rho, 0.0, NUDGE)
            det = a * e - b * c
            theta = theta - np.clip((turned * e - b * sunk) / det, -TURN, TURN)
            rho = rho - np.clip((a * sunk - turned * c) / det, -PLACE * size, PLACE * size)
        wrong = np.maximum(np.abs(turned), np.abs(sunk))
        # beyond a quarter of a turn it is the contact of another row, that looks the other way
        here = np.isfinite(wrong) & (np.abs(theta - t) < 0.25 * FULL_TURN)
        return found, np.where(here, wrong, np.inf)

    def _check(self, t: Array, d: Array, bad: NDArray[np.bool_], side: int) -> None:
        """Refuse what a graph over the turn cannot show."""
        if not np.any(bad):
            return
        first = int(np.argmax(bad))
        angle, place = t[first] / DEGREE % 360.0, float(self.chart.nominal(d[first]))
        which = "right" if side == RIGHT else "left"
        raise InputError(
            "/machine",
            self.machine.kind,
            f"Near cam angle {angle:.4g}° and ρ = {place:.6g} mm the wall on the {which} side of a "
            "roller is undercut, has a step, or lies off the blank: the rollers leave no such "
            "body.",
            "Take smaller rollers, a gentler law there or a smaller mesh angle; the flanks' points "
            "can be had as they are.",
        )

    def _difference(
        self, seat: Seat, side: int, theta: Array, rho: Array, turn: float, along: float
    ) -> tuple[Array, Array]:
        """How row and depth change with θ, or with ρ."""
        after = self._laid(seat, side, theta + turn, rho + along)
        before = self._laid(seat, side, theta - turn, rho - along)
        step = 2.0 * (turn + along)
        return (after.turn - before.turn) / step, (after.depth - before.depth) / step

    def _touched(self, rho: Array) -> Array:
        """Where on the rollers walls are contacts: of those that run on straight, up to the end."""
        if not self.straight:
            return rho
        roller = self.cam.swept.roller
        deep = roller.outer if self.chart.nominal(np.array(1.0)) > 0.0 else roller.inner
        return np.minimum(rho, deep) if deep == roller.outer else np.maximum(rho, deep)

    def _onwards(self, place: Place, rho: Array, normal: Array) -> Array:
        """The way (3, n) on along rollers from contacts at ρ, for a step of 1 along their axes."""
        swept = self.cam.swept
        axis = swept.joint.turned(swept.along.reshape(3, 1, 1), place.q)[:, :, 0]
        outwards = normal - dot(normal, axis) * axis
        return np.asarray(axis + swept.roller.profile(rho)[1] * outwards / norm(outwards))

    def _laid(self, seat: Seat, side: int, theta: Array, rho: Array) -> _Laid:
        swept = self.cam.swept
        place = self.cam.place(seat, theta)
        touched = self._touched(rho)
        found = swept.contacts(place, touched[:, None], side)
        point = found.point[:, :, 0]
        if self.straight:
            point = point + (rho - touched) * self._onwards(place, touched, found.normal[:, :, 0])
        angle, depth, across = self.laid(point)
        turn = theta - swept.hand * angle
        return _Laid(turn, depth, self.chart.beside(across, place.q), found.regular[:, 0])


def _straight_down(across: Array, sound: NDArray[np.bool_]) -> Array:
    """Walls (n, m) that below the rollers' ends go straight down where longer ones would undercut.

    There nothing touches them.
    """
    for k in range(1, across.shape[1]):
        across[:, k] = np.where(sound[:, k], across[:, k], across[:, k - 1])
    return across
