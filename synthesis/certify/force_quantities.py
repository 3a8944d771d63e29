"""Forces, camshaft torque and contact pressure as quantities of the finished cam.

As for all measured quantities, the geometry comes from the path of the traced point alone: the
pressure angle from its tangent and the direction of drive, the curvature from the turning of the
tangent. The process force is linear on every piece, because the motion is cut where it bends.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np

from synthesis.catalogue.followers.flank import Flank
from synthesis.catalogue.forces.reduced import (
    ContactState,
    ReducedLoad,
    face_pressure_square,
    pressure_square,
)
from synthesis.catalogue.limits.base import Machine
from synthesis.certify.piecewise_motion import Indices, PiecewiseMotion
from synthesis.certify.quantities import (
    QUANTITIES,
    Box,
    Points,
    Quantity,
    Size,
    TracedPoint,
    face_radius,
    pitch_curvature,
)
from synthesis.numerics.jets import Jets
from synthesis.numerics.piecewise import Array

FORCES: Final = ("drive_force", "contact_force", "camshaft_torque", "pressure_square")
NEGLIGIBLE: Final = 1e-11  # width of an enclosure that suffices, as a share of the largest sample
SAMPLES: Final = (0.02, 0.5, 0.98)  # places on each piece where those samples are taken


def load_cuts(machine: Machine) -> Sequence[float]:
    """Cam angles at which the process force bends or jumps [rad]."""
    return () if machine.load is None else machine.load.process.breaks[1:-1].tolist()


def quantity_of(
    name: str, flank: str, motion: PiecewiseMotion, machine: Machine, size: Size
) -> Quantity:
    """The quantity of this name; a force is that on the named flank, or on the first one."""
    if name not in FORCES:
        return QUANTITIES[name]
    assert machine.load is not None
    flanks = machine.follower.flanks
    mine = next((each for each in flanks if each.name == flank), flanks[0])
    return ForceQuantity(name, machine, machine.load, motion, mine, size)


@dataclass(frozen=True, eq=False)
class ForceQuantity:
    """A force, the torque, or the square of the pressure on a flank; attributes as ``Quantity``."""

    name: str
    machine: Machine
    load: ReducedLoad
    motion: PiecewiseMotion
    flank: Flank
    size: Size
    order: int = 2
    continuous_below: int = 2
    width_per_size: float = 0.0

    @property
    def infinite_at_corners(self) -> bool:
        """The pressure is infinite at a corner, as the curvature is."""
        return self.name == "pressure_square"

    @cached_property
    def absolute_width(self) -> float:
        """Width of an enclosure that suffices, since a force may vanish where its bound is 0."""
        curve = self.motion.curve
        piece = np.repeat(np.arange(curve.count), len(SAMPLES))
        x = (curve.breaks[:-1, None] + np.diff(curve.breaks)[:, None] * SAMPLES).ravel()
        with np.errstate(all="ignore"):
            values = np.abs(self.values_at(piece, x))
        return NEGLIGIBLE * float(np.max(values[np.isfinite(values)], initial=0.0))

    def values_at(self, piece: Indices, x: Array) -> Array:
        """Its values (n,) at cam angles of pieces."""
        s = tuple(self.motion.curve.jet(x, piece, 3))
        return self.values(TracedPoint(self.flank.trace, self.size, s), (piece, x))

    def values(self, point: TracedPoint, points: Points) -> Array:
        """Its values (n,) at cam angles, from s to s''' there."""
        piece, x = points
        process, piece_of_force = self._process
        force = process.curve.at(x, piece_of_force[piece], 0)
        return np.asarray(self._evaluate(point, force, piece))

    def model(self, point: TracedPoint, box: Box) -> Any:
        """Its Taylor models on boxes."""
        piece, lo, hi = box
        process, piece_of_force = self._process
        (force,) = process.models(piece_of_force[piece], lo, hi, 0)
        return self._evaluate(point, force, piece)

    @cached_property
    def _process(self) -> tuple[Jets, Indices]:
        """The process force, and the index of its piece over each piece of the motion."""
        breaks = self.motion.curve.breaks
        process = self.load.process
        return Jets(process), process.piece_of(0.5 * (breaks[1:] + breaks[:-1]))

    @cached_property
    def _sliding(self) -> Array:
        """Sign of the sliding velocity on each piece (n,): the sense in which friction acts."""
        segments = self.motion.segments
        return np.array([self.load.sliding_sense(s) for s in segments])[
            self.motion.segment_of_piece
        ]

    def _evaluate(self, point: TracedPoint, process: Any, piece: Indices) -> Any:
        trace, size, s = self.flank.trace, self.size, point.s
        point = TracedPoint(trace, size, s)  # on this flank's path, whichever was enclosed
        nx, ny = trace.normal(point.tangent, s, size)
        (gx, gy), _ = trace.drive_direction(s, size)
        length = np.sqrt(nx * nx + ny * ny)
        # sin α and cos α from normal and direction of drive, then the equilibrium of the follower
        place = ContactState(
            self.load, self.machine.omega, s, process, self._sliding[piece],
            (gx * ny - gy * nx) / length, (gx * nx + gy * ny) / length, trace.lever(s, size),
        )  # fmt: skip
        if self.name == "drive_force":
            return place.drive()
        if self.name == "camshaft_torque":
            return place.torque()
        force = place.contact_force()
        if self.name == "contact_force":
            return force
        if self.machine.follower.always_convex:
            return face_pressure_square(self.load, force, face_radius(point))
        return pressure_square(self.load, self.flank, force, pitch_curvature(point))
