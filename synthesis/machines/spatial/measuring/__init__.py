"""Measuring: every quantity of a finished spatial cam, its extreme, where and how it is known.

In: a SpatialCam and the bounds of its spec. Out: a ``SpatialExtreme`` for each quantity; the cam is
accepted where all of them hold. Open ``walls`` first: pressure angle, undercut, wall radii and ribs
over all contacts, found on samples of ``patches`` of walls. ``enclosure`` proves what was found for
cylindrical rollers, by branch and bound with Taylor models. ``quantities`` holds quantities and
bounds, and measures the follower's derivatives and the windows and points of the program.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from synthesis.machines.spatial.cam import SpatialCam
from synthesis.machines.spatial.design import SpatialExtreme
from synthesis.machines.spatial.measuring import quantities, walls
from synthesis.machines.spatial.measuring.patches import patches
from synthesis.machines.spatial.measuring.quantities import (
    Bound,
    Bounds,
    Extremum,
    Quantity,
    to_wire,
)
from synthesis.machines.spatial.spec import SpatialCamSpec
from synthesis.numerics import clock

__all__ = ["NO_BOUNDS", "Bound", "Bounds", "measure"]
NO_BOUNDS: Mapping[str, Bound] = {}


def measure(
    spec: SpatialCamSpec, cam: SpatialCam, bounds: Bounds = NO_BOUNDS
) -> list[SpatialExtreme]:
    """Measure every quantity of a cam against what the spec allows.

    Args:
        spec, cam: the question and its cam.
        bounds: by quantity, in its unit on the wire; bounds that every cam must keep apply anyway.

    Raises:
        Cancelled: the caller has gone.
    """
    extremes = []
    for quantity, extremum in _all(spec, cam, bounds):
        extremes.append(to_wire(quantity, extremum, bounds))
        clock.now()  # raises Cancelled between two quantities
    return extremes


def _all(
    spec: SpatialCamSpec, cam: SpatialCam, bounds: Bounds
) -> Iterator[tuple[Quantity, Extremum]]:
    parts = list(patches(cam))
    yield from walls.contact_extrema(cam, parts, spec.omega, bounds)
    thinnest = walls.thinnest_rib(cam, parts, spec.machine.seats())
    if thinnest is not None:
        yield walls.RIB, thinnest
    for name, clearance in spec.machine.clearances(cam.sizes).items():
        positive = Quantity(name, "mm", largest=False, required=Bound(0.0))
        yield positive, Extremum(clearance, clearance, "closed form")
    yield from quantities.contact_counts(cam)
    yield from quantities.follower_peaks(cam, spec.machine.travel, spec.omega)
    yield from quantities.segment_bound_extremes(spec, cam)
