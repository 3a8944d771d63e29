"""Forces, torque and pressure as quantities of the finished cam.

Geometry is taken from the path of the traced point alone, as everywhere here: the pressure angle
from tangent and drive, the curvature from the tangent's turning. The process force is straight on
every piece of a course that is cut where it bends.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np

from synthesis.certify.course import Course, Indices
from synthesis.certify.quantities import (
    QUANTITIES,
    Measurable,
    Sight,
    Size,
    face_radius,
    pitch_curvature,
)
from synthesis.followers.flank import Flank
from synthesis.forces.kinetostatics import Place, face_pressure_square, pressure_square
from synthesis.forces.reduced import Reduced
from synthesis.limits.base import Machine
from synthesis.numerics.jets import Jets
from synthesis.numerics.piecewise import Array

FORCES: Final = ("drive_force", "contact_force", "camshaft_torque", "pressure_square")
NEGLIGIBLE: Final = 1e-11  # of the largest value sampled: width of an enclosure that is enough


def cuts(machine: Machine) -> Sequence[float]:
    """Cam angles at which the load bends or jumps [rad]."""
    return () if machine.load is None else machine.load.process.breaks[1:-1].tolist()


def measurable(name: str, flank: str, course: Course, machine: Machine, size: Size) -> Measurable:
    """A quantity by its name; of forces, on a flank, or on the first one for no name."""
    if name not in FORCES:
        return QUANTITIES[name]
    assert machine.load is not None
    flanks = machine.follower.flanks
    mine = next((each for each in flanks if each.name == flank), flanks[0])
    return Loaded(name, machine, machine.load, course, mine, size)


@dataclass(frozen=True, eq=False)
class Loaded:
    """A force, the torque or the square of the pressure on a flank; see ``Quantity``."""

    name: str
    machine: Machine
    load: Reduced
    course: Course
    flank: Flank
    size: Size
    order: int = 2
    smooth: int = 2
    share: float = 0.0

    @property
    def turns(self) -> bool:
        """A corner of the path makes the pressure infinite."""
        return self.name == "pressure_square"

    @cached_property
    def _process(self) -> tuple[Jets, Indices]:
        """The process force, and which piece of it lies over each piece of the course."""
        breaks = self.course.curve.breaks
        process = self.load.process
        return Jets(process), process.piece_of(0.5 * (breaks[1:] + breaks[:-1]))

    @cached_property
    def _senses(self) -> Array:
        """Which way each piece slides."""
        stretches = self.course.motion.stretches
        return np.array([self.load.sliding(s) for s in stretches])[self.course.stretch]

    @cached_property
    def absolute(self) -> float:
        """Width that is good enough, besides a share of the value."""
        curve = self.course.curve
        piece = np.repeat(np.arange(curve.count), 3)
        x = (curve.breaks[:-1, None] + np.diff(curve.breaks)[:, None] * [0.02, 0.5, 0.98]).ravel()
        with np.errstate(all="ignore"):
            values = np.abs(self.values(piece, x))
        return NEGLIGIBLE * float(np.max(values[np.isfinite(values)], initial=0.0))

    def values(self, piece: Indices, x: Array) -> Array:
        """Its values at cam angles of pieces: (n,)."""
        s = tuple(self.course.curve.jet(x, piece, 3))
        return self.at(Sight(self.flank.trace, self.size, s), (piece, x))

    def at(self, seen: Sight, points: tuple[Indices, Array]) -> Array:
        """Its values at points, from s to s''' there: (n,)."""
        piece, x = points
        process, over = self._process
        return np.asarray(self._value(seen, process.curve.at(x, over[piece], 0), piece))

    def on(self, seen: Sight, box: tuple[Indices, Array, Array]) -> Any:
        """Its model on boxes."""
        piece, lo, hi = box
        process, over = self._process
        (model,) = process.models(over[piece], lo, hi, 0)
        return self._value(seen, model, piece)

    def _value(self, seen: Sight, process: Any, piece: Indices) -> Any:
        seen = Sight(self.flank.trace, self.size, seen.s)  # of the flank, whatever path was named
        place = self._place(seen, process, piece)
        if self.name == "drive_force":
            return place.drive()
        if self.name == "camshaft_torque":
            return place.torque()
        force = place.contact_force()
        if self.name == "contact_force":
            return force
        if self.machine.follower.always_convex:
            return face_pressure_square(self.load, force, face_radius(seen))
        return pressure_square(self.load, self.flank, force, pitch_curvature(seen))

    def _place(self, seen: Sight, process: Any, piece: Indices) -> Place:
        trace, size, s = seen.trace, seen.size, seen.s
        nx, ny = trace.normal(seen.tangent, s, size)
        (gx, gy), _ = trace.direction(s, size)
        length = np.sqrt(nx * nx + ny * ny)
        return Place(
            self.load, self.machine.omega, s, process, self._senses[piece],
            (gx * ny - gy * nx) / length, (gx * nx + gy * ny) / length, trace.lever(s, size),
        )  # fmt: skip
