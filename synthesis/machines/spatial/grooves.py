"""The grooves of a spatial cam's body: sections of their walls by half-planes through the axis.

A row is a half-plane through the cam's axis, named by the cam angle t at which it faces the
follower; in it a wall has one place across at every depth. The contact of roller and wall that lies
in row t at depth d has a cam angle θ and a place ρ on the roller's axis, which solve

    turn(θ, ρ) = t,   depth(θ, ρ) = d

by Newton's method, vectorised over all rows and depths.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from synthesis.errors import InputError
from synthesis.machines.spatial.cam import SpatialCam
from synthesis.machines.spatial.machine import LEFT, RIGHT, Seat, SpatialMachine
from synthesis.numerics.geometry.charts import Chart
from synthesis.numerics.geometry.swept_roller import FollowerState, dot, norm
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE, FULL_TURN

MAX_ITERATIONS = 40
CONVERGED = 1e-10  # rad and mm: residual at which Newton's method stops
NO_ROOT = 1e-7  # rad and mm: a larger residual after all iterations means that there is no contact
MAX_TURN, MAX_PLACE = 0.05, 0.03  # longest steps: of θ [rad], of ρ in largest depths
DIFFERENCE = 1e-6  # rad and mm: step of central differences
SAME = 1e-6  # rad or mm: rollers at the same place
FAR = 1.0  # widths of the blank: walls are sought this far beyond its mesh
SAMPLES = 721  # cam angles at which the rollers' positions are sampled over the turn


@dataclass(frozen=True, eq=False)
class Grooves:
    """All grooves at rows t and depths d, ordered across the blank.

    Attributes:
        low, high: (k, n, m) places across of their two walls; ±∞ where they are off the blank, or
            where that side of the roller does not touch the cam.
        shift: groove i at the end of the turn is groove i + shift at its start.
    """

    low: Array
    high: Array
    shift: int


class _ChartContacts(NamedTuple):
    """Contacts (n,) in chart coordinates, and whether the wall is regular there."""

    turn: Array
    depth: Array
    across: Array
    regular: Array


@dataclass(frozen=True, eq=False)
class GrooveSections:
    """Sections through the grooves of one cam.

    Attributes:
        cam, machine: which. chart: of its blank.
        mesh: least and largest position q of a roller in mesh [rad or mm]; may be infinite.
        straight: whether walls continue along the rollers' axes below the rollers' ends, where
            nothing touches them; otherwise they are those of longer rollers.
    """

    cam: SpatialCam
    machine: SpatialMachine
    chart: Chart
    mesh: tuple[float, float]
    straight: bool = False

    @classmethod
    def of(cls, cam: SpatialCam, machine: SpatialMachine, straight: bool = False) -> GrooveSections:
        """The sections of a machine's cam."""
        chart, mesh = machine.chart(cam.sizes), machine.mesh_range(cam.sizes)
        return cls(cam, machine, chart, mesh, straight)

    def to_chart(self, point: Array) -> tuple[Array, Array, Array]:
        """Angle about the cam's axis, depth and place across of points (3, …), machine's frame."""
        away = point - self.cam.swept.centre.reshape((3,) + (1,) * (point.ndim - 1))
        x, y, z = np.tensordot(self.cam.axes, away, axes=1)
        depth, across = self.chart.from_meridian(np.hypot(x, y), z)
        return np.arctan2(y, x), depth, across

    def axes(self, rho: float) -> Array:
        """Points at ρ on all rollers' axes over the turn, while in mesh: (3, n, 1) [mm]."""
        swept = self.cam.swept
        q = np.concatenate([self._integrate_speed(seat) for seat in self.machine.seats()])
        return swept.joint.move_points((swept.origin + rho * swept.along).reshape(3, 1, 1), q)

    def directions(self) -> Array:
        """Directions of these axes, (3, n, 1)."""
        q = np.concatenate([self._integrate_speed(seat) for seat in self.machine.seats()])
        return self.cam.swept.joint.turn_direction(self.cam.swept.along.reshape(3, 1, 1), q)

    def _integrate_speed(self, seat: Seat) -> Array:
        q = self.cam.place(seat, np.linspace(0.0, FULL_TURN, SAMPLES)).q
        return np.asarray(np.append(q[(q >= self.mesh[0]) & (q <= self.mesh[1])],
                                    [end for end in self.mesh if np.isfinite(end)]))  # fmt: skip

    def grooves(self, turn: Array, depth: Array) -> Grooves:
        """The grooves at rows ``turn`` (n,) [rad] and ``depth`` (m,) [mm].

        Raises:
            InputError: a wall is undercut or has a step, so that its place is not unique.
        """
        seats = self.seats()
        low, high = (
            np.stack([self._wall(seat, side, turn, depth) for seat in seats])
            for side in (LEFT, RIGHT)
        )
        return Grooves(low, high, self._shift([seat.start for seat in seats]))

    def seats(self) -> list[Seat]:
        """All rollers that come near the blank, those of other turns included, by position."""
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
        return [seat for seat in kept if np.any(self._near(self._positions(seat)))]

    def _positions(self, seat: Seat) -> Array:
        return self.cam.place(seat, np.linspace(0.0, FULL_TURN, SAMPLES)).q

    def _near(self, q: Array) -> Array:
        least, most = self.mesh
        far = FAR * (most - least)
        return np.asarray((q > least - far) & (q < most + far))

    def _shift(self, starts: list[float]) -> int:
        """Number of rollers by which the follower advances in a turn."""
        if len(starts) < 2:
            return 0
        return round(self.cam.gain / (starts[1] - starts[0]))

    def _wall(self, seat: Seat, side: int, turn: Array, depth: Array) -> Array:
        """Places across of a wall, (n, m)."""
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
        return _extend_straight(across.reshape(shape), sound.reshape(shape))

    def walls(self, seat: Seat, side: int, t: Array, d: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Places across in rows t at depths d (n,), and where they are on a regular wall.

        Raises:
            InputError: as ``grooves``.
        """
        with np.errstate(all="ignore"):  # divergence far from the blank is handled below
            found, wrong = self._newton(seat, side, t, d)
        q = self.cam.place(seat, t).q
        solved = wrong < NO_ROOT
        met = (q > self.mesh[0]) & (q < self.mesh[1])
        bad = met & ~(solved & (found.regular > 0.0))
        ends = np.array([self.cam.swept.roller.inner, self.cam.swept.roller.outer])
        reached = d <= np.max(self.chart.depth_of_place(ends))
        self._check(t, d, bad & reached, side)
        away = np.where(q > np.clip(0.0, *self.mesh), np.inf, -np.inf)
        return np.where(solved, found.across, away), ~bad

    def _newton(self, seat: Seat, side: int, t: Array, d: Array) -> tuple[_ChartContacts, Array]:
        """The contacts in rows t at depths d (n,) by Newton's method, and their residuals."""
        theta, rho = t.copy(), self.chart.depth_of_place(d)
        size = float(np.max(np.abs(d)))
        for _ in range(MAX_ITERATIONS):
            found = self._chart_contacts(seat, side, theta, rho)
            turned, sunk = found.turn - t, found.depth - d
            if np.nanmax(np.abs([turned, sunk]), initial=0.0) < CONVERGED:
                break
            a, c = self._partials(seat, side, theta, rho, DIFFERENCE, 0.0)
            b, e = self._partials(seat, side, theta, rho, 0.0, DIFFERENCE)
            det = a * e - b * c
            theta = theta - np.clip((turned * e - b * sunk) / det, -MAX_TURN, MAX_TURN)
            rho = rho - np.clip((a * sunk - turned * c) / det, -MAX_PLACE * size, MAX_PLACE * size)
        wrong = np.maximum(np.abs(turned), np.abs(sunk))
        # Beyond a quarter of a turn it is the contact of the opposite half-plane.
        here = np.isfinite(wrong) & (np.abs(theta - t) < 0.25 * FULL_TURN)
        return found, np.where(here, wrong, np.inf)

    def _check(self, t: Array, d: Array, bad: NDArray[np.bool_], side: int) -> None:
        """Refuse walls that are not a graph over turn and depth."""
        if not np.any(bad):
            return
        first = int(np.argmax(bad))
        angle, place = t[first] / DEGREE % 360.0, float(self.chart.depth_of_place(d[first]))
        which = "right" if side == RIGHT else "left"
        raise InputError(
            "/machine",
            self.machine.kind,
            f"Near cam angle {angle:.4g}° and ρ = {place:.6g} mm the wall on the {which} side of a "
            "roller is undercut, has a step, or lies off the blank: there is no such body.",
            "Choose smaller rollers, a gentler law there or a smaller mesh angle; files of the "
            "flanks' points are available as they are.",
        )

    def _partials(
        self, seat: Seat, side: int, theta: Array, rho: Array, turn: float, along: float
    ) -> tuple[Array, Array]:
        """Derivatives of row and depth by θ, or by ρ, by central differences."""
        after = self._chart_contacts(seat, side, theta + turn, rho + along)
        before = self._chart_contacts(seat, side, theta - turn, rho - along)
        step = 2.0 * (turn + along)
        return (after.turn - before.turn) / step, (after.depth - before.depth) / step

    def _contact_places(self, rho: Array) -> Array:
        """Places on the rollers' axes where walls are contacts; if straight, up to their ends."""
        if not self.straight:
            return rho
        roller = self.cam.swept.roller
        deep = roller.outer if self.chart.depth_of_place(np.array(1.0)) > 0.0 else roller.inner
        return np.minimum(rho, deep) if deep == roller.outer else np.maximum(rho, deep)

    def _axis_step(self, place: FollowerState, rho: Array, normal: Array) -> Array:
        """Displacement (3, n) of a contact at ρ along the roller's profile, per unit of ρ."""
        swept = self.cam.swept
        axis = swept.joint.turn_direction(swept.along.reshape(3, 1, 1), place.q)[:, :, 0]
        outwards = normal - dot(normal, axis) * axis
        return np.asarray(axis + swept.roller.profile(rho)[1] * outwards / norm(outwards))

    def _chart_contacts(self, seat: Seat, side: int, theta: Array, rho: Array) -> _ChartContacts:
        swept = self.cam.swept
        place = self.cam.place(seat, theta)
        touched = self._contact_places(rho)
        found = swept.contacts(place, touched[:, None], side)
        point = found.point[:, :, 0]
        if self.straight:
            point = point + (rho - touched) * self._axis_step(place, touched, found.normal[:, :, 0])
        angle, depth, across = self.to_chart(point)
        turn = theta - swept.hand * angle
        return _ChartContacts(turn, depth, self.chart.unwrap(across, place.q), found.regular[:, 0])


def shifted(walls: NDArray[Any], shift: int, missing: float) -> NDArray[Any]:
    """Walls (k, …) of the next turn by their numbers in this one; ``missing`` where none is."""
    after, there = np.full_like(walls, missing), np.arange(len(walls)) + shift
    known = (there >= 0) & (there < len(walls))
    after[known] = walls[there[known]]
    return after


def _extend_straight(across: Array, sound: NDArray[np.bool_]) -> Array:
    """Walls (n, m), constant in depth below the rollers' ends where longer rollers would undercut.

    Nothing touches them there.
    """
    for k in range(1, across.shape[1]):
        across[:, k] = np.where(sound[:, k], across[:, k], across[:, k - 1])
    return across
