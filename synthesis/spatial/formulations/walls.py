"""Whether walls of a settled motion are sound, quickly: sampled, and judged elsewhere.

Walls are neither undercut nor rounder than allowed where a roller larger by the least radius leaves
none undercut; ribs are as thick as allowed; what else needs room has it. All of it is eased by a
larger cam and by smaller rollers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import inf

import numpy as np
from scipy.optimize import brentq

from synthesis.motion import Motion
from synthesis.numerics.piecewise import Array
from synthesis.spatial.cam import SpatialCam, settled
from synthesis.spatial.measuring.patches import Patch, Tried, patches, tried
from synthesis.spatial.measuring.ribs import thinnest
from synthesis.spatial.spec import SpatialCamSpec

ANGLES, PLACES = 240, 3  # of a wall
NEAR, ROUNDS = 9, 5  # looked at beside the lowest sample, every time a quarter as far
EXACT, ROUGH = 1e-7, 1e-4  # relative, of a size that is grown for walls, and for ribs
ROOM = 1e-3  # relative: what larger rollers leave for what samples miss
RADIUS = "roller_radius_mm"  # the field of it, of every machine

Sizes = Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Soundness:
    """What walls have to keep, for one motion.

    Attributes:
        radius: least convex radius of walls. rib: least thickness of ribs [mm].
        kept: what has to be left over, relative, for what samples may miss.
    """

    spec: SpatialCamSpec
    motion: Motion
    radius: float
    rib: float
    kept: float

    def spare(self, sizes: Sizes) -> float:
        """How much of what is needed is left over, relative; negative where some is missing."""
        cam = settled(self.spec, sizes, self.motion)
        unit = sizes[self.spec.machine.sought]
        rooms = self.spec.machine.rooms(sizes).values()
        least = min((room / unit for room in rooms), default=inf)
        return least - self.kept if least <= 0.0 else self._regular(cam)

    def thickness(self, sizes: Sizes) -> float:
        """What the thinnest rib has left over, relative; that takes a while."""
        cam = settled(self.spec, sizes, self.motion)
        found = thinnest(cam, list(patches(cam)), self.spec.machine.seats())
        return inf if found is None else (found.limit - self.rib) / sizes[self.spec.machine.sought]

    def _regular(self, cam: SpatialCam) -> float:
        """Least ratio of areas, of rollers larger by the least radius."""
        roller = cam.swept.roller
        larger = replace(
            roller,
            radius=roller.radius + self.radius,
            crown=roller.crown + self.radius if roller.crown else 0.0,
        )
        offset = replace(cam, swept=replace(cam.swept, roller=larger))
        rho = np.linspace(roller.inner, roller.outer, PLACES)
        found, lowest = inf, None
        for wall in tried(list(patches(offset)), ANGLES, ANGLES):
            contacts = wall.together.contacts(wall.theta.ravel(), rho)
            values = np.where(_inside(cam, contacts.point), contacts.regular, inf)
            at, place = np.unravel_index(int(np.argmin(values)), values.shape)
            if values[at, place] < found:
                found, lowest = float(values[at, place]), (wall, int(at), rho[[place]])
        return found if lowest is None else min(found, _closer(*lowest))


def _closer(wall: Tried, at: int, place: Array) -> float:
    """The least ratio of areas beside the lowest sample, number ``at`` of a wall's."""
    piece, own = divmod(at, wall.theta.shape[1])
    angles = wall.theta[piece]
    ends = angles[max(own - 1, 0)], angles[min(own + 1, len(angles) - 1)]
    together = wall.together
    patch = Patch(together.cam, together.wall, int(np.asarray(together.piece)[at]), *ends)
    for _ in range(ROUNDS):
        theta = np.linspace(*ends, NEAR)
        values = patch.contacts(theta, place).regular[:, 0]
        best = int(np.argmin(values))
        ends = theta[max(best - 1, 0)], theta[min(best + 1, NEAR - 1)]
    return float(values[best])


def _inside(cam: SpatialCam, points: Array) -> Array:
    return np.asarray(cam.between_faces(points) if np.all(np.isfinite(cam.faces)) else True)


def grown(sound: Soundness, sizes: Sizes, largest: float, *, ribs: bool) -> Sizes | None:
    """The same sizes with the one sought as little larger as walls need; None: no size will do."""
    name, found = sound.spec.machine.sought, dict(sizes)

    def by(left: Callable[[Sizes], float]) -> Callable[[float], float]:
        return lambda at: left({**sizes, name: at}) - sound.kept

    wanted = ((sound.spare, EXACT), (sound.thickness, ROUGH))
    for left, accuracy in wanted if ribs else wanted[:1]:
        size = _enough(by(left), found[name], largest, accuracy)
        if size is None:
            return None
        found[name] = size
    return found


def _enough(
    spare: Callable[[float], float], low: float, largest: float, accuracy: float
) -> float | None:
    """The least number from ``low`` on that leaves nothing missing; None where none does."""
    at, step = low, 0.02 * low
    if spare(low) >= 0.0:
        return low
    while at < largest:
        at, before = min(low + step, largest), at
        if spare(at) >= 0.0:
            return _crossing(spare, before, at, accuracy)
        step *= 2.0
    return None


def enlarged(sound: Soundness, sizes: Sizes, largest: float) -> Sizes:
    """The same sizes with rollers as much larger as walls leave room for [mm]."""
    low = sizes[RADIUS]

    def spare(less: float) -> float:
        return sound.spare({**sizes, RADIUS: largest - less}) - max(sound.kept, ROOM)

    if largest <= low * (1.0 + ROOM) or spare(largest - low) < 0.0:
        return sizes
    less = 0.0 if spare(0.0) >= 0.0 else _crossing(spare, 0.0, largest - low, EXACT)
    return {**sizes, RADIUS: largest - less}


def _crossing(spare: Callable[[float], float], low: float, high: float, accuracy: float) -> float:
    """Where the spare becomes positive, on that side of it."""
    wide = accuracy * high
    found = float(brentq(spare, low, high, xtol=wide, rtol=1e-12))
    while spare(found) < 0.0 and found < high:
        found = min(found + wide, high)
    return found
