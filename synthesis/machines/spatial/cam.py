"""SpatialCam: a spatial cam with its motion and all dimensions given, its walls and its frame.

A wall is there at cam angles at which its roller meshes with the cam: by position, and between the
end faces.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
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

    def between_faces(self, point: Array) -> Array:
        """Which points (3, …) of the machine's frame lie between the end faces."""
        shape = (3,) + (1,) * (point.ndim - 1)
        along = dot(self.swept.axis.reshape(shape), point - self.swept.centre.reshape(shape))
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
    machine, faces = spec.machine, spec.machine.end_faces()
    swept, mesh = machine.swept_roller(sizes, spec.rotation_sign), machine.mesh_range(sizes)
    walls = []
    for seat in machine.seats():
        met = mesh_intervals(motion, seat, mesh, machine.period)
        for side in seat.sides if met else ():
            spans = tuple(
                part for span in met
                for part in intervals_between_faces(swept, motion, seat, side, span, faces)
            )  # fmt: skip
            if spans:
                walls.append(Wall(seat, side, spans))
    return SpatialCam(swept, motion, tuple(walls), sizes, faces, machine.period)


def mesh_intervals(motion: Motion, seat: Seat, mesh: Span, period: float) -> tuple[Span, ...]:
    """Intervals of cam angle in one turn in which a roller meets the blank [rad].

    Args:
        mesh: range of q in mesh [rad or mm]. period: of q, after which a roller is back at its
            place; may be infinite.
    """
    places = seat.start + motion.curve(np.linspace(0.0, FULL_TURN, SAMPLES * motion.curve.count))
    around = [0.0]
    if math.isfinite(period):  # the periods by which the mesh may be met between these places
        first = math.floor((float(places.min()) - mesh[1]) / period)
        last = math.ceil((float(places.max()) - mesh[0]) / period)
        around = [period * k for k in range(first, last + 1)]

    def within(theta: Array) -> Inside:
        q = seat.start + motion.derivatives(theta, 0)[0]
        rounds = np.array(around)[:, None]
        return np.asarray(((q > mesh[0] + rounds) & (q < mesh[1] + rounds)).any(axis=0))

    def crossing(level: float) -> Callable[[Array], Array]:
        return lambda theta: motion.curve(theta) - level

    ends = [0.0, *(segment.end for segment in motion.segments)]
    levels = [crossing(q - seat.start + shift) for q in mesh for shift in around]
    return _intervals(ends, motion.curve.breaks.tolist(), levels, within)


def intervals_between_faces(
    swept: SweptRoller, motion: Motion, seat: Seat, side: int, span: Span, faces: Span
) -> tuple[Span, ...]:
    """The parts of an interval in which some contact of a wall lies between the end faces.

    Args:
        faces: their positions along the cam's axis from its centre [mm].
    """
    if all(math.isinf(face) for face in faces):
        return (span,)
    rho = swept.roller.places(PLACES)

    def beyond(theta: Array) -> Array:
        """Distance of the nearest contact beyond the end faces, negative between them, (n,)."""
        q, q1, q2 = motion.derivatives(theta, 2)
        point, _ = swept.contact_points(FollowerState(seat.start + q, q1, q2), rho, side)
        along = dot(swept.axis.reshape(3, 1, 1), point - swept.centre.reshape(3, 1, 1))
        return np.asarray(np.maximum(faces[0] - along, along - faces[1]).min(axis=1))

    inner = [float(b) for b in motion.curve.breaks if span[0] < b < span[1]]
    return _intervals(span, [span[0], *inner, span[1]], [beyond], lambda t: beyond(t) < 0.0)


def _intervals(
    ends: Sequence[float],
    breaks: Sequence[float],
    functions: Sequence[Callable[[Array], Array]],
    within: Callable[[Array], Inside],
) -> tuple[Span, ...]:
    """Intervals between ends and roots of functions, merged where they meet.

    Args:
        breaks: between which the functions are sampled; tangent roots may be missed.
        within: whether an interval counts, by its middle.
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
    return tuple(spans)
