"""The size of a follower's cam: size variables z, their domain, and constraints on them.

Symbols as in ``kinematics``. Lengths are in the problem's unit of length, see ``constraints``.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from synthesis.catalogue.constraints import (
    AffineNorm,
    LinearInequality,
    NonconvexConstraint,
    NormBounds,
)
from synthesis.catalogue.motion import PlacedSegment
from synthesis.catalogue.ranges import Range


@dataclass(frozen=True)
class SizeDomain:
    """Domain of the size variables.

    Attributes:
        bounds: (lower, upper) of every size variable, finite.
        norm_bounds: second-order cones that bound them further.
        min_norm: smallest value of ``radius_norm``: reverse convex, so that bounds and cones
            contain points that break it.
    """

    bounds: tuple[tuple[float, float], ...]
    norm_bounds: tuple[NormBounds, ...]
    min_norm: float


class SizedFollower(ABC):
    """The part of a follower that the optimiser asks: its size z is a variable."""

    # -- the size --------------------------------------------------------------------------------

    @abstractmethod
    def size_domain(self, base_radius: tuple[float, float]) -> SizeDomain:
        """Domain of z for base radii between two ends."""

    @abstractmethod
    def radius_norm(self) -> AffineNorm:
        """The norm of z that grows with the prime radius Rp, or Rp itself: minimised for size."""

    def radius_from_norm(self, value: float) -> float:
        """Rp where ``radius_norm`` has this value: a monotone map."""
        return value

    @abstractmethod
    def enlarged_to(self, z: tuple[float, ...], radius: float) -> tuple[float, ...]:
        """z with its last variable enlarged until ``radius_norm`` is at least ``radius``."""

    def adjustable_dimensions(self) -> Mapping[str, float | Range | None]:
        """Dimensions that the size variables determine where they are left free: field, value."""
        return {}

    def searched_dimensions(
        self, base_radius: tuple[float, float]
    ) -> Mapping[str, tuple[float | Range, tuple[float, float]]]:
        """Dimensions that an outer search varies where they are left free.

        Args:
            base_radius: ends of the requested base radius [mm], open ones infinite.

        Returns:
            by field: the requested value, and the ends [mm] between which a cam can exist at all.
        """
        return {}

    @property
    def reason_without_minimum(self) -> str:
        """Why its cam can shrink to a point while only undercut is excluded; "" if it cannot."""
        return ""

    def check_dimensions(
        self, base_radius: tuple[float, float], segments: Sequence[PlacedSegment]
    ) -> None:
        """Refuse dimensions with which no base radius between two ends [mm] works.

        Args:
            segments: the program placed on the cam, displacements from the lowest position.
        """
        return None

    def feasible_base_radii(
        self, base_radius: tuple[float, float], stroke: float
    ) -> tuple[float, float]:
        """The part of a range of base radii at which the follower can move through a stroke."""
        return base_radius

    # -- constraints: () where the follower does not state the limit in this form ------------------

    def pressure_angle_constraints(self, slope: float) -> tuple[NonconvexConstraint, ...]:
        """|tan α| ≤ slope where it is not linear in s, s' and z together."""
        return ()

    def profile_radius_rows(self, least: float) -> tuple[LinearInequality, ...]:
        """Radius of the convex profile ≥ least, linear in s to s'' and z."""
        return ()

    def profile_radius_constraints(self, least: float) -> tuple[NonconvexConstraint, ...]:
        """Radius of the convex profile ≥ least where its half-planes of the size are known."""
        return ()

    def outer_radius_constraints(self, largest: float) -> tuple[NonconvexConstraint, ...]:
        """Largest radius of the traced curve ≤ largest where ``outer_radius_norm`` is None."""
        return ()


def enlarged(z: tuple[float, ...], amount: float) -> tuple[float, ...]:
    """z with its last variable larger by ``amount``, which eases every geometric limit."""
    return (*z[:-1], z[-1] + amount)


def max_enlargement(
    z: tuple[float, ...], bounds: Sequence[tuple[float, float]], norms: Sequence[NormBounds]
) -> float:
    """The largest amount by which ``enlarged`` keeps z within bounds and norms; 0 if none."""
    steps = [bounds[-1][1] - z[-1], *(norm.growth_to_upper(z) for norm in norms)]
    return max(min(steps), 0.0)


def prime_radius(follower: SizedFollower, z: tuple[float, ...]) -> float:
    """Rp at a size: the distance of the trace point from the cam's axis at the lowest position."""
    return follower.radius_from_norm(follower.radius_norm().value(z))
