"""The grooves of a spatial cam's body: sections of their walls by half-planes through the axis.

A row is a half-plane through the cam's axis, named by the cam angle t at which it faces the
follower; in it a wall has one place across at every depth. The contact of roller and wall that lies
in row t at depth d has a cam angle θ and a place ρ on the roller's axis, which solve

    turn(θ, ρ) = t,   depth(θ, ρ) = d

by Newton's method, vectorised over all rows and depths.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from synthesis.errors import InputError
from synthesis.machines.spatial.cam import SpatialCam
from synthesis.machines.spatial.machine import LEFT, RIGHT, Seat, SpatialMachine
from synthesis.numerics.geometry.charts import Chart
from synthesis.numerics.geometry.swept_roller import dot, norm
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE, FULL_TURN

MAX_ITERATIONS = 40  # of Newton's method
CONVERGED = 1e-10  # rad and mm: residual at which Newton's method stops
NO_ROOT = 1e-7  # rad and mm: a larger residual after all iterations means that there is no contact
MAX_TURN, MAX_PLACE = 0.05, 0.03  # longest steps: of θ [rad], of ρ in largest depths
DIFFERENCE = 1e-6  # rad and mm: step of central differences
SAME = 1e-6  # rad or mm: rollers at the same place
SAMPLES = 721  # cam angles at which the rollers' positions are sampled over the turn


@dataclass(frozen=True, eq=False)
class GrooveSections:
    """Sections through the grooves of one cam.

    Where ``straight`` walls continue along the rollers' axes below the rollers' ends, where nothing
    touches them; otherwise they are those of longer rollers.
    """

    cam: SpatialCam
    machine: SpatialMachine
    straight: bool = False

    @cached_property
    def chart(self) -> Chart:
        """Of the blank."""
        return self.machine.chart(self.cam.sizes)

    @cached_property
    def mesh(self) -> tuple[float, float]:
        """Least and largest position q of a roller in mesh [rad or mm]; may be infinite."""
        return self.machine.mesh_range(self.cam.sizes)

    def to_chart(self, point: Array) -> tuple[Array, Array, Array]:
        """Angle about the cam's axis, depth and place across of points (3, …), machine's frame."""
        away = point - self.cam.swept.centre.reshape((3,) + (1,) * (point.ndim - 1))
        x, y, z = np.tensordot(self.cam.axes, away, axes=1)
        depth, across = self.chart.from_meridian(np.hypot(x, y), z)
        return np.arctan2(y, x), depth, across

    def axes(self, rho: float) -> Array:
        """Points at ρ on all rollers' axes over the turn, while in mesh: (3, n, 1) [mm]."""
        swept = self.cam.swept
        start = (swept.origin + rho * swept.along).reshape(3, 1, 1)
        return swept.joint.move_points(start, self._mesh_positions)

    def directions(self) -> Array:
        """Directions of these axes, (3, n, 1)."""
        swept = self.cam.swept
        return swept.joint.turn_direction(swept.along.reshape(3, 1, 1), self._mesh_positions)

    @cached_property
    def _mesh_positions(self) -> Array:
        """Positions q of all rollers over the turn while in mesh, and the ends of the mesh."""
        q = np.concatenate([self._positions(seat) for seat in self.machine.seats()])
        inside = q[(q >= self.mesh[0]) & (q <= self.mesh[1])]
        return np.append(inside, [end for end in self.mesh if np.isfinite(end)])

    def grooves(self, turn: Array, depth: Array) -> tuple[Array, int]:
        """The grooves at rows ``turn`` (n,) [rad] and ``depth`` (m,) [mm], by place across.

        Returns:
            (2, k, n, m) places across of their low and high walls, ±∞ where they are off the blank,
            or where that side of the roller does not touch the cam; and the shift: groove i at the
            end of the turn is groove i + shift at its start.

        Raises:
            InputError: a wall is undercut or has a step, so that its place is not unique.
        """
        seats = self.seats()
        walls = np.array([
            [self._wall(seat, side, turn, depth) for seat in seats] for side in (LEFT, RIGHT)
        ])  # fmt: skip
        shift = 0
        if len(seats) > 1:  # the rollers by which the follower advances in a turn
            shift = round(self.cam.gain / (seats[1].start - seats[0].start))
        return walls, shift

    def seats(self) -> list[Seat]:
        """All rollers that come near the blank, those of other turns included, by position."""
        gain, (least, most) = self.cam.gain, self.mesh
        reach = int(np.ceil((most - least) / abs(gain))) + 2 if gain else 0
        seats = [
            Seat(seat.number, seat.start + gain * turn, seat.sides)
            for seat in self.machine.seats()
            for turn in range(-reach, reach + 1)
        ]
        seats.sort(key=lambda seat: seat.start)
        kept = [a for a, b in pairwise(seats) if b.start - a.start > SAME] + seats[-1:]
        return [seat for seat in kept if np.any(self._near(self._positions(seat)))]

    def _positions(self, seat: Seat) -> Array:
        return self.cam.place(seat, np.linspace(0.0, FULL_TURN, SAMPLES)).q

    def _near(self, q: Array) -> Array:
        """Which positions are within the mesh, or beyond it by less than its width."""
        least, most = self.mesh
        return np.asarray((q > 2.0 * least - most) & (q < 2.0 * most - least))

    def _wall(self, seat: Seat, side: int, turn: Array, depth: Array) -> Array:
        """Places across of a wall, (n, m)."""
        t, d = np.meshgrid(turn, depth, indexing="ij")
        if side not in seat.sides:
            return np.full(t.shape, side * np.inf)
        q = np.broadcast_to(self.cam.place(seat, turn).q[:, None], t.shape)
        across, sound = np.where(q > self.mesh[1], np.inf, -np.inf), np.full(t.shape, True)
        near = self._near(q)
        if np.any(near):
            across[near], sound[near] = self.walls(seat, side, t[near], d[near])
        # Below the rollers' ends nothing touches the wall: it is constant in depth where longer
        # rollers would undercut it.
        for k in range(1, len(depth)):
            across[:, k] = np.where(sound[:, k], across[:, k], across[:, k - 1])
        return across

    def walls(self, seat: Seat, side: int, t: Array, d: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Places across in rows t at depths d (n,), and where they are on a regular wall.

        Raises:
            InputError: as ``grooves``.
        """
        with np.errstate(all="ignore"):  # divergence far from the blank is handled below
            theta, rho, across, solved = self._newton(seat, side, t, d)
            touched = self._contact_places(rho)[:, None]
            contacts = self.cam.swept.contacts(self.cam.place(seat, theta), touched, side)
        # While the roller meshes, down to its end, a wall has to be there and regular.
        q = self.cam.place(seat, t).q
        met = (q > self.mesh[0]) & (q < self.mesh[1])
        bad = met & ~(solved & (contacts.regular[:, 0] > 0.0))
        bad_rows = np.flatnonzero(bad & (d <= self._deepest))
        if len(bad_rows):
            raise self._no_graph(t[bad_rows[0]], d[bad_rows[0]], side)
        away = np.where(q > np.clip(0.0, *self.mesh), np.inf, -np.inf)
        return np.where(solved, across, away), ~bad

    def _newton(
        self, seat: Seat, side: int, t: Array, d: Array
    ) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
        """The contacts in rows t at depths d (n,): θ, ρ, place across, and which were found."""
        theta, rho = t.copy(), self.chart.depth_of_place(d)
        size = float(np.max(np.abs(d)))

        def partials(by_theta: float, by_rho: float) -> tuple[Array, Array]:
            """Derivatives of row and depth by θ, or by ρ, by central differences."""
            after = self._chart_point(seat, side, theta + by_theta, rho + by_rho)
            before = self._chart_point(seat, side, theta - by_theta, rho - by_rho)
            step = 2.0 * (by_theta + by_rho)
            return (after[0] - before[0]) / step, (after[1] - before[1]) / step

        for _ in range(MAX_ITERATIONS):
            turn, depth, across = self._chart_point(seat, side, theta, rho)
            turned, sunk = turn - t, depth - d
            if np.nanmax(np.abs([turned, sunk]), initial=0.0) < CONVERGED:
                break
            (a, c), (b, e) = partials(DIFFERENCE, 0.0), partials(0.0, DIFFERENCE)
            det = a * e - b * c
            last = theta, rho
            theta = theta - np.clip((turned * e - b * sunk) / det, -MAX_TURN, MAX_TURN)
            rho = rho - np.clip((a * sunk - turned * c) / det, -MAX_PLACE * size, MAX_PLACE * size)
        else:
            theta, rho = last
        wrong = np.maximum(np.abs(turned), np.abs(sunk))
        # Beyond a quarter of a turn it is the contact of the opposite half-plane.
        here = np.isfinite(wrong) & (np.abs(theta - t) < 0.25 * FULL_TURN)
        return theta, rho, across, here & (wrong < NO_ROOT)

    def _no_graph(self, t: Array, d: Array, side: int) -> InputError:
        """Refusal of a wall that is not a graph over turn and depth."""
        angle, place = t / DEGREE % 360.0, float(self.chart.depth_of_place(d))
        which = "right" if side == RIGHT else "left"
        return InputError(
            "/machine",
            self.machine.kind,
            f"Near cam angle {angle:.4g}° and ρ = {place:.6g} mm the wall on the {which} side of a "
            "roller is undercut, has a step, or lies off the blank: there is no such body.",
            "Choose smaller rollers, a gentler law there or a smaller mesh angle; files of the "
            "flanks' points are available as they are.",
        )

    def _contact_places(self, rho: Array) -> Array:
        """Places on the rollers' axes where walls are contacts; if straight, up to their ends."""
        if not self.straight:
            return rho
        depth_of = self.chart.depth_of_place  # and back
        return depth_of(np.minimum(depth_of(rho), self._deepest))

    @cached_property
    def _deepest(self) -> float:
        """Depth of the rollers' deeper end [mm]."""
        roller = self.cam.swept.roller
        return float(np.max(self.chart.depth_of_place(roller.places(2))))

    def _chart_point(
        self, seat: Seat, side: int, theta: Array, rho: Array
    ) -> tuple[Array, Array, Array]:
        """Row, depth and place across (n,) of the wall at θ and ρ (n,)."""
        swept, place = self.cam.swept, self.cam.place(seat, theta)
        touched = self._contact_places(rho)
        points, normals = swept.contact_points(place, touched[:, None], side)
        point = points[:, :, 0]
        if self.straight:
            # Beyond the roller's end the wall goes on along the tangent of the roller's profile.
            normal = normals[:, :, 0]
            axis = swept.joint.turn_direction(swept.along.reshape(3, 1, 1), place.q)[:, :, 0]
            outwards = normal - dot(normal, axis) * axis
            along = axis + swept.roller.profile(touched)[1] * outwards / norm(outwards)
            point = point + (rho - touched) * along
        angle, depth, across = self.to_chart(point)
        return theta - swept.hand * angle, depth, self.chart.unwrap(across, place.q)


def shifted(walls: NDArray[Any], shift: int, missing: float) -> NDArray[Any]:
    """Walls (k, …) of the next turn by their numbers in this one; ``missing`` where none is."""
    after, there = np.full_like(walls, missing), np.arange(len(walls)) + shift
    known = (there >= 0) & (there < len(walls))
    after[known] = walls[there[known]]
    return after
