"""What a finished spatial cam does: every quantity's extreme, where it is, how that is known."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from synthesis import clock
from synthesis.spatial.cam import SpatialCam
from synthesis.spatial.design import SpatialExtreme
from synthesis.spatial.measuring import demands, follower, ribs, walls
from synthesis.spatial.measuring.found import Bound, Bounds, Found, Kind, told
from synthesis.spatial.measuring.patches import patches
from synthesis.spatial.spec import SpatialCamSpec

__all__ = ["NO_BOUNDS", "Bound", "Bounds", "measured"]
NO_BOUNDS: Mapping[str, Bound] = {}


def measured(
    spec: SpatialCamSpec, cam: SpatialCam, bounds: Bounds = NO_BOUNDS
) -> list[SpatialExtreme]:
    """Every quantity of a cam against what the spec allows.

    Args:
        bounds: by quantity, in its unit on the wire; what every cam must keep counts anyway.

    Raises:
        Cancelled: nobody waits for it.
    """
    extremes = []
    for kind, found in _all(spec, cam, bounds):
        extremes.append(told(kind, found, bounds))
        clock.now()  # between two of them whoever waits no longer is heard
    return extremes


def _all(spec: SpatialCamSpec, cam: SpatialCam, bounds: Bounds) -> Iterator[tuple[Kind, Found]]:
    parts = list(patches(cam))
    yield from walls.extremes(cam, parts, spec.omega, bounds)
    thinnest = ribs.thinnest(cam, parts, spec.machine.seats())
    if thinnest is not None:
        yield ribs.RIB, thinnest
    for name, room in spec.machine.rooms(cam.sizes).items():
        yield Kind(name, "mm", largest=False, must=Bound(0.0)), Found(room, room, "closed form")
    yield from follower.holding(cam)
    yield from follower.in_time(cam, spec.machine.travel, spec.omega)
    yield from demands.kept(spec, cam)
