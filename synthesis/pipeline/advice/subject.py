"""The cam that rules judge: its spec, and its curves over the turn, each computed once.

Pressure angles are sampled: at every degree, and on both sides of every end of a piece of the
motion. A rule compares them with rules of thumb, so that a sample's error does not matter; what the
certificate has enclosed, or the summary has, is taken from there.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from synthesis.catalogue.followers.base import paths
from synthesis.catalogue.followers.kinematics import Flank, labelled, pressure_angle_sine_cosine
from synthesis.catalogue.forces.reduced import MILLI
from synthesis.catalogue.limits import Limit
from synthesis.catalogue.motion import Sense
from synthesis.design.design import Design, Extreme
from synthesis.design.summary import FlankGeometry, MotionSummary
from synthesis.numerics.piecewise import Array, Mask
from synthesis.spec.design_spec import DesignSpec
from synthesis.units import DEGREE, FULL_TURN

BESIDE: Final = 1e-9  # of a piece: how far inside its ends it is sampled
GRID: Final = np.arange(0.5, 360.0) * DEGREE  # rad: cam angles that are sampled besides


@dataclass(frozen=True, eq=False)
class Subject:
    """A design as rules see it; lengths in mm, derivatives per radian, unless a name has a unit."""

    design: Design

    @cached_property
    def spec(self) -> DesignSpec:
        """The spec with everything that was chosen."""
        return self.design.completed_spec if self.has_cam else self.design.spec

    @property
    def has_cam(self) -> bool:
        """Whether there is a cam, whether it keeps its limits or not."""
        return bool(self.design.motion)

    @property
    def stroke(self) -> float:
        """Highest less lowest displacement."""
        return self.spec.stroke()

    @property
    def is_arm(self) -> bool:
        """Whether the follower swings."""
        return self.spec.follower.travel.unit == "deg"

    @property
    def base_radius(self) -> float:
        return self.design.dimensions["base_radius_mm"]

    @property
    def base_radius_is_set(self) -> bool:
        """Whether the spec gives the base radius, a least one, or the shaft or hub in it."""
        return self.spec.requested_radii()[0] > 0.0

    @property
    def is_force_closed(self) -> bool:
        """Whether nothing but a force keeps the follower on its cam."""
        follower = self.spec.follower
        return len(follower.flanks) == 1 and not follower.closure.counter_paths

    @property
    def is_touched_from_outside(self) -> bool:
        return self.spec.follower.flanks[0].side > 0

    def limits(self, *kinds: str) -> Iterator[Limit]:
        """The limits of these kinds that the spec sets."""
        return (limit for limit in self.spec.limits if limit.kind in kinds)

    def limited(self, *kinds: str) -> bool:
        """Whether the spec sets a limit of one of these kinds."""
        return any(self.limits(*kinds))

    def minimises(self, *kinds: str) -> bool:
        """Whether the first objective that the spec names is of one of these kinds."""
        return self.spec.objective is not None and self.spec.objectives()[0].kind in kinds

    def extreme(self, name: str, label: str = "") -> Extreme | None:
        """A line of the certificate, of the named flank or path."""
        wanted = labelled(name, label)
        return next((each for each in self.design.extremes if each.limit == wanted), None)

    @cached_property
    def theta(self) -> Array:
        """Sampled cam angles in order (n,) [rad]."""
        breaks = self.design.curve.curve.breaks
        inside = BESIDE * np.diff(breaks)
        return np.sort(np.concatenate([GRID, breaks[:-1] + inside, breaks[1:] - inside]))

    @cached_property
    def s(self) -> Array:
        """s to s''' there: (4, n)."""
        return self.design.curve.derivatives(self.theta, 3)

    def on(self, *senses: Sense) -> Mask:
        """Which samples lie on segments that move so (n,)."""
        mask = np.zeros(len(self.theta), dtype=bool)
        for segment in self.spec.placed_segments():
            if not set(senses).isdisjoint(segment.senses):
                mask |= (self.theta >= segment.start) & (self.theta <= segment.end)
        return mask

    @cached_property
    def pressure_angles_deg(self) -> Mapping[str, Array]:
        """|α| there, by the name of each traced curve (n,)."""
        rates = [*self.s, np.zeros_like(self.theta)]
        found = {}
        for name, path in paths(self.spec.follower).items():
            sine, cosine = pressure_angle_sine_cosine(path, rates, self.design.size)
            found[name] = np.arctan2(np.abs(sine), cosine) / DEGREE
        return found

    @property
    def summary(self) -> MotionSummary:
        """Peaks, coefficients and jumps of the motion; there is a cam."""
        found = self.design.motion_summary
        assert found is not None
        return found

    def in_metres(self, value: float) -> float:
        """A rate on the wire, in mm or degrees of an arm, as one along the path in metres."""
        return value * self.spec.follower.travel.per_unit * MILLI

    @property
    def flanks(self) -> Iterator[tuple[Flank, FlankGeometry]]:
        """The working curves of the cam, and what was measured of each."""
        geometry = self.design.geometry
        assert geometry is not None
        return zip(self.spec.follower.flanks, geometry.flanks, strict=True)

    def degrees_at(self, index: int) -> float:
        """Cam angle of a sample [deg]."""
        return float(self.theta[index] % FULL_TURN / DEGREE)
