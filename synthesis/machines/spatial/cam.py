"""SpatialCam: a spatial cam with its motion and all dimensions given, its walls and its frame.

A wall is there at cam angles at which its roller meshes with the cam: by position, and between the
end faces.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from synthesis.catalogue.motion import Motion
from synthesis.machines.spatial.machine import LEFT, Seat
from synthesis.machines.spatial.spec import SpatialCamSpec
from synthesis.numerics.geometry.swept_roller import (
    Contacts,
    FollowerState,
    SweptRoller,
    dot,
    rotate,
)
from synthesis.numerics.piecewise import Array
from synthesis.units import FULL_TURN

FRAME = (
    "Fixed to the cam, right-handed, lengths in mm: z along the cam's axis, x at cam angle 0 "
    "parallel to the axis of a roller at position 0, from the cam towards the roller."
)
Span = tuple[float, float]
Inside = NDArray[np.bool_]
SAMPLES = 33  # on every piece of the motion, between which crossings are sought
PLACES = 5  # on the roller's axis, where a contact may lie between the end faces


@dataclass(frozen=True)
class Wall:
    """The surface of the cam that one side of one roller envelops in one turn.

    Attributes:
        seat: the roller.
        side: RIGHT for the wall ahead of the roller as q grows, LEFT for the other; so they appear
            from the cam, where a turret turns counter-clockwise seen from above.
        spans: cam angles between which the roller meets the blank [rad].
    """

    seat: Seat
    side: int
    spans: tuple[Span, ...]

    @property
    def letter(self) -> Literal["L", "R"]:
        """L or R."""
        return "L" if self.side == LEFT else "R"

    @property
    def name(self) -> str:
        """Name of the flank: ``2R`` is on the side towards which roller 2 moves as q grows."""
        return f"{self.seat.number}{self.letter}"


@dataclass(frozen=True, eq=False)
class SpatialCam:
    """A spatial cam.

    Attributes:
        swept: kinematics of the roller against the cam. motion: q(θ) over one turn.
        walls: by roller, then by side.
        sizes: the machine's dimensions by the names of their fields [mm].
        faces: positions of the end faces along its axis, from ``swept.centre`` [mm].
        period: of q, after which a roller is back at its place [rad or mm].
    """

    swept: SweptRoller
    motion: Motion
    walls: tuple[Wall, ...]
    sizes: Mapping[str, float]
    faces: Span = (-math.inf, math.inf)
    period: float = math.inf

    def place(self, seat: Seat, theta: Array) -> FollowerState:
        """Position and derivatives of a roller at θ (n,) [rad], in any turn."""
        q, q1, q2 = self.motion.derivatives(theta, 2)
        turns = np.floor(theta / FULL_TURN)
        return FollowerState(seat.start + self.gain * turns + q, q1, q2)

    @property
    def gain(self) -> float:
        """Net displacement of the follower in one turn [rad or mm]."""
        return self.motion.segments[-1].s_end - self.motion.segments[0].s_start

    def contacts(self, wall: Wall, theta: Array, rho: Array) -> Contacts:
        """Contacts of a wall at θ (n,) [rad] and places on the roller's axis (m,) [mm]."""
        return self.swept.contacts(self.place(wall.seat, theta), rho, wall.side)

    def surface(self, wall: Wall, theta: Array, rho: Array) -> tuple[Array, Array]:
        """Points [mm] and unit normals out of the material, in the cam's frame: (3, n, m) each."""
        swept = self.swept
        point, normal = swept.contact_points(self.place(wall.seat, theta), rho, wall.side)
        outward = rotate(-normal, -swept.hand * theta, swept.axis)
        return swept.on_cam(theta, point), outward

    def along_axis(self, point: Array) -> Array:
        """Positions along the cam's axis of points (3, …) of the machine's frame [mm]."""
        shape = (3,) + (1,) * (point.ndim - 1)
        return dot(self.swept.axis.reshape(shape), point - self.swept.centre.reshape(shape))

    def between_faces(self, point: Array) -> Array:
        """Which points (3, …) of the machine's frame lie between the end faces."""
        along = self.along_axis(point)
        return np.asarray((along >= self.faces[0]) & (along <= self.faces[1]))

    @cached_property
    def axes(self) -> Array:
        """(3, 3) directions of the files' frame in the machine's frame, by rows: x, y, z.

        z is along the cam's axis, x at θ = 0 along the axis of a roller at q = 0, towards it. The
        origin lies on the cam's axis: of a turret, at the foot of the common perpendicular.
        """
        swept = self.swept
        away = swept.origin + swept.roller.middle * swept.along - swept.centre
        along = np.copysign(1.0, np.dot(away, swept.along)) * swept.along
        across = along - np.dot(along, swept.axis) * swept.axis
        x = across / np.linalg.norm(across)
        return np.stack([x, np.cross(swept.axis, x), swept.axis])

    def frame_points(self, theta: Array, point: Array) -> Array:
        """Points (3, n, …) of the machine's frame at θ (n,), in the files' frame [mm]."""
        return np.asarray(np.tensordot(self.axes, self.swept.on_cam(theta, point), axes=1))

    def frame_directions(self, theta: Array, direction: Array) -> Array:
        """Directions (3, n, …) of the machine's frame at θ (n,), in the files' frame."""
        centre = self.swept.centre.reshape((3,) + (1,) * (direction.ndim - 1))
        return self.frame_points(theta, centre + direction)


def build_cam(spec: SpatialCamSpec, sizes: Mapping[str, float], motion: Motion) -> SpatialCam:
    """The cam with these dimensions [mm] and this motion."""
    machine, walls = spec.machine, []
    swept, mesh = machine.swept_roller(sizes, spec.rotation_sign), machine.mesh_range(sizes)
    cam = SpatialCam(swept, motion, (), sizes, machine.end_faces(), machine.period)
    for seat in machine.seats():
        met = _mesh_intervals(cam, seat, mesh)
        for side in seat.sides:
            spans = [
                part for span in met for part in _intervals_between_faces(cam, seat, side, span)
            ]
            if spans:
                walls.append(Wall(seat, side, tuple(spans)))
    return replace(cam, walls=tuple(walls))


def _mesh_intervals(cam: SpatialCam, seat: Seat, mesh: Span) -> list[Span]:
    """Intervals of cam angle in one turn in which a roller meets the blank, q within its mesh."""
    curve = cam.motion.curve
    around = [0.0]
    if math.isfinite(cam.period):  # the periods by which the mesh may be met between these places
        q = cam.place(seat, np.linspace(0.0, FULL_TURN, SAMPLES * curve.count)).q
        first = math.floor((float(q.min()) - mesh[1]) / cam.period)
        last = math.ceil((float(q.max()) - mesh[0]) / cam.period)
        around = [cam.period * k for k in range(first, last + 1)]

    def within(theta: Array) -> Inside:
        q = cam.place(seat, theta).q - np.array(around)[:, None]
        return np.asarray(((q > mesh[0]) & (q < mesh[1])).any(axis=0))

    def crossing(level: float) -> Callable[[Array], Array]:
        return lambda theta: curve(theta) - level

    ends = [0.0, *(segment.end for segment in cam.motion.segments)]
    levels = [crossing(q - seat.start + shift) for q in mesh for shift in around]
    return _intervals(ends, curve.breaks, levels, within)


def _intervals_between_faces(cam: SpatialCam, seat: Seat, side: int, span: Span) -> list[Span]:
    """The parts of an interval in which some contact of a wall lies between the end faces."""
    if np.all(np.isinf(cam.faces)):
        return [span]
    rho = cam.swept.roller.places(PLACES)

    def beyond(theta: Array) -> Array:
        """Distance of the nearest contact beyond the end faces, negative between them, (n,)."""
        point, _ = cam.swept.contact_points(cam.place(seat, theta), rho, side)
        along = cam.along_axis(point)
        return np.asarray(np.maximum(cam.faces[0] - along, along - cam.faces[1]).min(axis=1))

    breaks = cam.motion.curve.breaks
    inner = breaks[(breaks > span[0]) & (breaks < span[1])]
    return _intervals(span, [span[0], *inner, span[1]], [beyond], lambda t: beyond(t) < 0.0)


def _intervals(
    ends: Sequence[float],
    breaks: Iterable[float],
    functions: Sequence[Callable[[Array], Array]],
    within: Callable[[Array], Inside],
) -> list[Span]:
    """Intervals between ends and roots of functions, merged where they meet.

    The functions are sampled between ``breaks``; tangent roots may be missed. ``within`` says
    whether an interval counts, by its middle.
    """
    samples = np.unique(np.concatenate([np.linspace(a, b, SAMPLES) for a, b in pairwise(breaks)]))
    roots = set(ends)
    for of in functions:
        above = of(samples) > 0.0
        for i in np.flatnonzero(above[1:] != above[:-1]):
            low, high = float(samples[i]), float(samples[i + 1])
            roots.add(brentq(lambda t, of=of: of(np.array([t]))[0], low, high, xtol=1e-14))
    marks = sorted(roots)
    spans: list[Span] = []
    inside = within(np.array([0.5 * (a + b) for a, b in pairwise(marks)]))
    for (a, b), counts in zip(pairwise(marks), inside, strict=True):
        if counts and spans and spans[-1][1] == a:
            spans[-1] = (spans[-1][0], b)
        elif counts:
            spans.append((a, b))
    return spans
