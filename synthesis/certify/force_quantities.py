"""Forces, camshaft torque and contact pressure as quantities of the finished cam.

As for all measured quantities, the geometry comes from the path of the traced point alone: the
pressure angle from its tangent and the direction of drive, the curvature from the turning of the
tangent.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final

import numpy as np

from synthesis.catalogue.followers.flank import Flank
from synthesis.catalogue.forces.reduced import (
    ContactState,
    face_pressure_square,
    pressure_square,
)
from synthesis.certify.quantities import (
    QUANTITIES,
    MeasuredCam,
    Quantity,
    TracedPoint,
    face_radius,
    pitch_curvature,
)

FORCES: Final = ("drive_force", "contact_force", "camshaft_torque", "pressure_square")
NEGLIGIBLE: Final = 1e-11  # width of an enclosure that suffices, as a share of the largest sample
SAMPLES: Final = (0.02, 0.5, 0.98)  # places on each piece where those samples are taken


def quantity_of(name: str, flank: str, cam: MeasuredCam) -> Quantity:
    """The quantity of this name; a force is that on the named flank, or on the first one."""
    if name not in FORCES:
        return QUANTITIES[name]
    flanks = cam.machine.follower.flanks
    return force_quantity(name, next((f for f in flanks if f.name == flank), flanks[0]), cam)


def force_quantity(name: str, flank: Flank, cam: MeasuredCam) -> Quantity:
    """A force, the torque, or the square of the pressure on a flank, by equilibrium."""
    load, segments = cam.machine.load, cam.motion.segments
    assert load is not None
    # sense in which friction acts on each piece: against the sliding of the follower in its guide
    sliding = np.array([load.sliding_sense(s) for s in segments])[cam.motion.segment_of_piece]

    def formula(at: TracedPoint) -> Any:
        if at.trace is not flank.trace:  # on this flank's path, whichever the subject names
            at = replace(at, trace=flank.trace)
        # sine and cosine of the pressure angle, from the normal and the direction of drive
        nx, ny = at.trace.normal(at.tangent, at.s, at.size)
        (gx, gy), _ = at.trace.drive_direction(at.s, at.size)
        length = np.sqrt(nx * nx + ny * ny)
        place = ContactState(
            load, cam.machine.omega, at.s, at.process, sliding[at.piece],
            (gx * ny - gy * nx) / length, (gx * nx + gy * ny) / length,
            at.trace.lever(at.s, at.size),
        )  # fmt: skip
        if name == "drive_force":
            return place.drive()
        if name == "camshaft_torque":
            return place.torque()
        force = place.contact_force()
        if name == "contact_force":
            return force
        if cam.machine.follower.always_convex:
            return face_pressure_square(load, force, face_radius(at))
        return pressure_square(load, flank, force, pitch_curvature(at))

    corners = name == "pressure_square"  # infinite there, as the curvature is
    quantity = Quantity(formula, 2, 2, infinite_at_corners=corners, loaded=True)
    # a force may vanish where its bound is 0: the width that suffices is a share of its samples
    curve = cam.motion.curve
    x = (curve.breaks[:-1, None] + np.diff(curve.breaks)[:, None] * SAMPLES).ravel()
    piece = np.arange(curve.count).repeat(len(SAMPLES))
    with np.errstate(all="ignore"):
        (values,) = cam.values([(quantity, flank.path)], piece, x)
    size = float(np.max(np.abs(values)[np.isfinite(values)], initial=0.0))
    return replace(quantity, absolute_width=NEGLIGIBLE * size)
