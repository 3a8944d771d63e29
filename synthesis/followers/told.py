"""What a follower tells people: its dimensions, and how a drawing shows it."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

from synthesis.followers.trace import Trace
from synthesis.motion import Motion
from synthesis.units import SLIDE, Travel


@dataclass(frozen=True)
class Shape:
    """The follower's end as a drawing shows it, in the machine frame of a ccw cam [mm].

    Attributes:
        centre: where its stem begins. roller: radius about it, 0 where there is no roller.
        left, right: how far a face reaches from there to either side, both 0 where there is none.
        along: unit vector along the face, to the right.
        pivot: of an arm, None where the follower slides.
    """

    centre: tuple[float, float]
    roller: float
    left: float = 0.0
    right: float = 0.0
    along: tuple[float, float] = (1.0, 0.0)
    pivot: tuple[float, float] | None = None


class Told(Trace):
    """A follower as something that is told and drawn."""

    @property
    def travel(self) -> Travel:
        """How its displacement is told on the wire."""
        return SLIDE

    @property
    @abstractmethod
    def roller_radius(self) -> float:
        """Distance of the profile from the curve of the traced point [mm]; 0 at a knife edge."""

    @abstractmethod
    def dimensions(self, z: tuple[float, ...]) -> Mapping[str, float]:
        """The cam's dimensions as named on the wire [mm, deg]."""

    def motion_dimensions(self, motion: Motion, z: tuple[float, ...]) -> Mapping[str, float]:
        """Dimensions that follow from the finished motion [mm]."""
        return {}

    def shape(self, motion: Motion, z: tuple[float, ...]) -> Shape:
        """What a drawing shows at cam angle 0."""
        s = motion.derivatives([0.0])
        (x, y), *_ = self.traced_point(s, z)
        return Shape((float(x[0]), float(y[0])), self.roller_radius)
