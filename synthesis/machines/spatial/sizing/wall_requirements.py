"""Enlarge a cam until its walls and ribs are sound, for laws that are given.

Checked on samples, quickly; ``measuring`` judges the result. Walls are neither undercut nor rounder
than allowed where a roller larger by the least convex radius would not undercut them; ribs are as
thick as allowed; the machine's clearances are positive. A larger cam and smaller rollers ease all
of it, so that the least size and the largest rollers are roots of monotone functions.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import inf

import numpy as np
from scipy.optimize import brentq

from synthesis.catalogue.motion import Motion
from synthesis.machines.spatial.cam import SpatialCam, build_cam
from synthesis.machines.spatial.measuring.patches import Patch, WallSamples, patches, sample_walls
from synthesis.machines.spatial.measuring.ribs import thinnest
from synthesis.machines.spatial.spec import SpatialCamSpec
from synthesis.numerics.piecewise import Array

ANGLES, PLACES = 240, 3  # samples of a wall: cam angles, and places along the roller
NEIGHBOURS, REFINEMENTS = 9, 5  # around the lowest sample; each refinement quarters the interval
WALL_ACCURACY, RIB_ACCURACY = 1e-7, 1e-4  # relative, of a size that is enlarged for walls, for ribs
FIRST_STEP = 0.02  # relative, of a size that is enlarged; doubled until it is enough
ROLLER_MARGIN = 1e-3  # of the ratio of areas: what larger rollers leave for what samples miss

Sizes = Mapping[str, float]


@dataclass(frozen=True, eq=False)
class WallRequirements:
    """What walls and ribs have to keep, for one motion.

    Attributes:
        radius: least convex radius of walls [mm]. rib: least thickness of ribs [mm].
        margin: kept in all of it, relative, for what samples may miss.
    """

    spec: SpatialCamSpec
    motion: Motion
    radius: float
    rib: float
    margin: float

    def wall_margin(self, sizes: Sizes) -> float:
        """The least clearance if one is negative, else the least ratio of areas; relative."""
        unit = sizes[self.spec.machine.size_field]
        clearances = self.spec.machine.clearances(sizes).values()
        least = min((clearance / unit for clearance in clearances), default=inf)
        if least <= 0.0:
            return least - self.margin
        return self._regularity(build_cam(self.spec, sizes, self.motion))

    def rib_margin(self, sizes: Sizes) -> float:
        """Thickness of the thinnest rib above the least one, relative to the size; slow."""
        cam = build_cam(self.spec, sizes, self.motion)
        found = thinnest(cam, list(patches(cam)), self.spec.machine.seats())
        if found is None:
            return inf
        return (found.limit - self.rib) / sizes[self.spec.machine.size_field]

    def _regularity(self, cam: SpatialCam) -> float:
        """Least ratio of areas, wall to swept surface, for rollers larger by the least radius."""
        roller = cam.swept.roller
        larger = replace(
            roller,
            radius=roller.radius + self.radius,
            crown=roller.crown + self.radius if roller.crown else 0.0,
        )
        offset = replace(cam, swept=replace(cam.swept, roller=larger))
        rho = np.linspace(roller.inner, roller.outer, PLACES)
        least, lowest = inf, None
        for wall in sample_walls(list(patches(offset)), ANGLES, ANGLES):
            contacts = wall.together.contacts(wall.theta.ravel(), rho)
            # Contacts beyond the end faces touch nothing.
            finite = np.all(np.isfinite(cam.faces))
            inside = np.asarray(cam.between_faces(contacts.point) if finite else True)
            values = np.where(inside, contacts.regular, inf)
            at, place = np.unravel_index(int(np.argmin(values)), values.shape)
            if values[at, place] < least:
                least, lowest = float(values[at, place]), (wall, int(at), rho[[place]])
        return least if lowest is None else min(least, _refined(*lowest))


def _refined(wall: WallSamples, at: int, place: Array) -> float:
    """The least ratio of areas between the neighbours of the lowest sample, number ``at``."""
    piece, own = divmod(at, wall.theta.shape[1])
    angles = wall.theta[piece]
    ends = angles[max(own - 1, 0)], angles[min(own + 1, len(angles) - 1)]
    together = wall.together
    patch = Patch(together.cam, together.wall, int(np.asarray(together.piece)[at]), *ends)
    for _ in range(REFINEMENTS):
        theta = np.linspace(*ends, NEIGHBOURS)
        values = patch.contacts(theta, place).regular[:, 0]
        best = int(np.argmin(values))
        ends = theta[max(best - 1, 0)], theta[min(best + 1, NEIGHBOURS - 1)]
    return float(values[best])


def enlarge_cam(
    required: WallRequirements, sizes: Sizes, largest: float, *, ribs: bool
) -> Sizes | None:
    """The sizes with the minimised one enlarged as little as walls, and ribs, need.

    Args:
        largest: allowed [mm]. ribs: whether ribs count; most cams have room for theirs.

    Returns:
        None where no size up to the largest is enough.
    """
    name, enlarged = required.spec.machine.size_field, dict(sizes)

    def at_size(margin: Callable[[Sizes], float]) -> Callable[[float], float]:
        return lambda size: margin({**sizes, name: size}) - required.margin

    wanted = ((required.wall_margin, WALL_ACCURACY), (required.rib_margin, RIB_ACCURACY))
    for margin, accuracy in wanted if ribs else wanted[:1]:
        size = _least_feasible(at_size(margin), enlarged[name], largest, accuracy)
        if size is None:
            return None
        enlarged[name] = size
    return enlarged


def _least_feasible(
    margin: Callable[[float], float], low: float, largest: float, accuracy: float
) -> float | None:
    """The least number from ``low`` on with a margin ≥ 0; None where there is none."""
    at, step = low, FIRST_STEP * low
    if margin(low) >= 0.0:
        return low
    while at < largest:
        at, before = min(low + step, largest), at
        if margin(at) >= 0.0:
            return _feasible_root(margin, before, at, accuracy)
        step *= 2.0
    return None


def enlarge_rollers(required: WallRequirements, sizes: Sizes, largest: float) -> Sizes:
    """The sizes with rollers enlarged as far as walls allow, up to a largest radius [mm]."""
    name = required.spec.machine.radius_field
    low = sizes[name]

    def margin(less: float) -> float:
        radius = largest - less
        return required.wall_margin({**sizes, name: radius}) - max(required.margin, ROLLER_MARGIN)

    if largest <= low * (1.0 + ROLLER_MARGIN) or margin(largest - low) < 0.0:
        return sizes
    less = 0.0
    if margin(0.0) < 0.0:
        less = _feasible_root(margin, 0.0, largest - low, WALL_ACCURACY)
    return {**sizes, name: largest - less}


def _feasible_root(
    margin: Callable[[float], float], low: float, high: float, accuracy: float
) -> float:
    """Where the margin becomes positive, on the positive side."""
    step = accuracy * high
    root = float(brentq(margin, low, high, xtol=step, rtol=1e-12))
    while margin(root) < 0.0 and root < high:
        root = min(root + step, high)
    return root
