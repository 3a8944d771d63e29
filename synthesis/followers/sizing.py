"""What whoever sizes a cam asks of its follower: size variables, their range, limits as rows.

Symbols as in ``trace``.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from synthesis.motion import Stretch
from synthesis.ranges import Range
from synthesis.terms import Cone, Curved, Norm, Row


@dataclass(frozen=True)
class Sizing:
    """Where the size variables may lie.

    Attributes:
        bounds: (lower, upper) of every size variable, finite [mm].
        cones: what else is convex.
        least: smallest value of the norm ``prime_radius`` [mm]; not convex, so bounds and cones
            say only part of it.
    """

    bounds: tuple[tuple[float, float], ...]
    cones: tuple[Cone, ...]
    least: float


class Sized(ABC):
    """A follower as something whose size z is sought."""

    # -- the size --------------------------------------------------------------------------------

    @abstractmethod
    def sizing(self, base_radius: tuple[float, float]) -> Sizing:
        """Where z may lie for a base radius between two ends [mm]."""

    @abstractmethod
    def prime_radius(self) -> Norm:
        """The norm of z that is pushed down for a small cam: Rp, or what grows with it."""

    def radius(self, z: tuple[float, ...]) -> float:
        """The prime radius itself [mm]."""
        return self.prime_radius().value(z)

    def radius_of(self, value: float) -> float:
        """Rp at a value of the norm ``prime_radius`` [mm]: a monotone map."""
        return value

    def raised(self, z: tuple[float, ...], amount: float) -> tuple[float, ...]:
        """The last size variable larger by ``amount`` [mm], which eases every geometric limit."""
        return (*z[:-1], z[-1] + amount)

    def room(
        self, z: tuple[float, ...], bounds: Sequence[tuple[float, float]], cones: Sequence[Cone]
    ) -> float:
        """How far ``raised`` can go within bounds and cones of the size [mm]."""
        steps = [bounds[-1][1] - z[-1], *(cone.step(z) for cone in cones)]
        return max(min(steps), 0.0)

    @abstractmethod
    def reaching(self, z: tuple[float, ...], radius: float) -> tuple[float, ...]:
        """The size raised until the norm ``prime_radius`` is at least ``radius`` [mm]."""

    def adjustable(self) -> Mapping[str, float | Range | None]:
        """Its dimensions that may also be left free: field and value."""
        return {}

    def left_open(
        self, base_radius: tuple[float, float]
    ) -> Mapping[str, tuple[float | Range, tuple[float, float]]]:
        """Its dimensions that may be left free and are searched around everything else.

        Args:
            base_radius: ends of the base radius asked for [mm], open ones infinite.

        Returns:
            by field: what is asked, and the ends between which it can serve at all.
        """
        return {}

    @property
    def vanishing(self) -> str:
        """What lets its cam shrink to a point while nothing but undercut is excluded; or empty."""
        return ""

    # -- what it can serve at all ----------------------------------------------------------------

    def check_reach(self, base_radius: tuple[float, float], stretches: Sequence[Stretch]) -> None:
        """Refuse dimensions that no base radius between two ends [mm] can serve.

        ``stretches``: the program on the cam, displacements from the lowest position.
        """
        return None

    def reachable(self, base_radius: tuple[float, float], stroke: float) -> tuple[float, float]:
        """The part of a range of base radii at which it can move through a stroke [mm]."""
        return base_radius

    # -- limits ----------------------------------------------------------------------------------

    def pressure_angle_curves(self, slope: float) -> tuple[Curved, ...]:
        """|tan α| ≤ slope where it is not linear in s, s' and z together; otherwise ()."""
        return ()

    def profile_radius_rows(self, least: float) -> tuple[Row, ...]:
        """Profile radius ≥ least as rows linear in s to s'' and z; () where it is not linear."""
        return ()

    def profile_radius_curves(self, least: float) -> tuple[Curved, ...]:
        """Profile radius ≥ least [mm] where every half-plane of the size is known; otherwise ()."""
        return ()

    def contact_rows(self, left: float, right: float) -> tuple[Row, ...]:
        """Contact within left and right [mm] of a face's middle, in this order; () without one."""
        return ()

    def contact_curves(self, end: str, reach: float) -> tuple[Curved, ...]:
        """Contact on this side of an end of the face, ``reach`` [mm] from its middle, likewise."""
        return ()

    def outer_radius_curves(self, largest: float) -> tuple[Curved, ...]:
        """Largest radius of the traced curve ≤ largest [mm] where it is not a norm of z."""
        return ()
