"""The frame in which files of spatial cams are written, the same for all machines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from synthesis.numerics.geometry.swept_roller import SweptRoller
from synthesis.numerics.piecewise import Array

DESCRIPTION = (
    "Fixed to the cam, right-handed, lengths in mm: z along the cam's axis, x at cam angle 0 "
    "parallel to the axis of a roller at position 0, from the cam towards the roller."
)


@dataclass(frozen=True, eq=False)
class CamFrame:
    """z along the cam's axis, x at θ = 0 along the axis of a roller at q = 0, towards it.

    Its origin lies on the cam's axis: of a turret, at the foot of the common perpendicular.

    Attributes:
        swept: kinematics of the machine. axes: (3, 3) directions in the machine's frame, by rows.
    """

    swept: SweptRoller
    axes: Array

    @classmethod
    def of(cls, swept: SweptRoller) -> CamFrame:
        """The frame of a machine's cam."""
        away = swept.origin + swept.roller.middle * swept.along - swept.centre
        along = np.copysign(1.0, np.dot(away, swept.along)) * swept.along
        across = along - np.dot(along, swept.axis) * swept.axis
        x = across / np.linalg.norm(across)
        return cls(swept, np.stack([x, np.cross(swept.axis, x), swept.axis]))

    def points(self, theta: Array, point: Array) -> Array:
        """Points (3, n, …) of the machine's frame at θ (n,), in the cam's frame [mm]."""
        return self._to_axes(self.swept.on_cam(theta, point))

    def directions(self, theta: Array, direction: Array) -> Array:
        """Directions (3, n, …) of the machine's frame at θ (n,), in the cam's frame."""
        centre = self.swept.centre.reshape((3,) + (1,) * (direction.ndim - 1))
        return self._to_axes(self.swept.on_cam(theta, centre + direction))

    def _to_axes(self, vectors: Array) -> Array:
        return np.asarray(np.tensordot(self.axes, vectors, axes=1))
