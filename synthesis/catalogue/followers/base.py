"""The base of every follower family: given dimensions, size variables, and the cam's curves."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from synthesis.catalogue.constraints import (
    AffineNorm,
    Ends,
    LinearInequality,
    NonconvexConstraints,
    SizeDomain,
    Vector,
)
from synthesis.catalogue.fields import FiniteModel, Range
from synthesis.catalogue.followers.closures import SINGLE_FLANK, Closure
from synthesis.catalogue.followers.kinematics import Flank, Link, TracePoint, Vector2
from synthesis.catalogue.motion import Motion, Segments
from synthesis.units import MILLIMETRES, Travel

MIN_PRIME_RADIUS_RATIO = 1e-3  # of the base radius: smallest prime radius sought inside a ring


@dataclass(frozen=True)
class FixableDimension:
    """A free dimension, as the followers for which it is fixed; an outer search varies it.

    Attributes:
        name: as in a message to a user.
        low, high: its range [mm], ends may be infinite. unit: its order of magnitude [mm].
        value_in: its value at size variables of the follower for which it is free.
        full_size: the inverse, from a value and the size variables of the follower fixed there.
        needed: whether the sizes allowed are stated in full only where it is fixed.
    """

    name: str
    low: float
    high: float
    unit: float
    value_in: Callable[[Vector], float]
    fixed_at: Callable[[float], Follower]
    full_size: Callable[[float, Vector], Vector]
    needed: bool = False


class Follower(FiniteModel, TracePoint, ABC):
    """A follower family: a bare mechanism that traces a curve on the cam, and its size.

    ``TracePoint`` is its kinematics; symbols and frames as there.

    Attributes:
        kind: name on the wire. title: name for people.
        size_charts: names of the size variables z, one tuple for each choice of given dimensions.
        always_convex: a profile without undercut has no hollows.
        redundant_fields: fields that would fix the base radius by another name.
        roller_radius_mm: Rr, 0 of a knife edge or a face. closure: what keeps it on the cam.
    """

    kind: str
    title: ClassVar[str]
    size_charts: ClassVar[tuple[tuple[str, ...], ...]]
    always_convex: ClassVar[bool] = False
    redundant_fields: ClassVar[tuple[str, ...]] = ()

    if TYPE_CHECKING:  # fields of the families with a roller, constants of those with a face
        roller_radius_mm: float
        closure: Closure

    @property
    def size_names(self) -> tuple[str, ...]:
        """Names of the size variables for the dimensions that are given here."""
        return self.size_charts[0]

    @property
    def travel(self) -> Travel:
        """Units of its displacement on the wire."""
        return MILLIMETRES

    @property
    def flanks(self) -> tuple[Flank, ...]:
        """The curves that the cam is made of; the base radius is that of the first."""
        return self.closure.flanks(self, self.roller_radius_mm)

    def with_closure(self, closure: Closure) -> Self:
        """The same held by another closure."""
        return self if closure == self.closure else self.model_copy(update={"closure": closure})

    def without_free_counter(self) -> Self:
        """The same without a counter roller whose place is chosen after the size and still free."""
        return self.with_closure(self.closure.without_free_counter())

    @abstractmethod
    def link(self, z: Any, degree: Any) -> Link:
        """The output link at displacement 0, in the arithmetic of z; ``degree``: π/180 in it."""

    @abstractmethod
    def size_domain(self, base_radius: Ends) -> SizeDomain:
        """Domain of z for base radii between two ends."""

    def allows(self, z: Vector) -> bool:
        """Whether z keeps the ranges of dimensions that ``size_domain`` leaves out."""
        return True

    def radius_norm(self) -> AffineNorm:
        """The norm of z that grows with the prime radius Rp, or Rp itself: minimised for size."""
        lowest = self.outer_radius_norm(0.0)
        assert lowest is not None
        return lowest

    def radius_from_norm(self, value: float) -> float:
        """Rp where ``radius_norm`` has this value: a monotone map."""
        return value

    def adjustable_dimensions(self) -> Mapping[str, float | Range | None]:
        """Dimensions that the size variables determine where they are left free: field, value."""
        return {}

    def searched_dimensions(self, base_radius: Ends) -> Mapping[str, tuple[float | Range, Ends]]:
        """Dimensions that an outer search varies where they are left free, for base radii [mm].

        By field: the requested value, and the ends [mm] between which a cam can exist at all.
        """
        return {}

    def searched_norm(self, base_radius: Ends) -> float:
        """``radius_norm`` of the smallest cam that is sought for base radii between two ends."""
        return self.norm_from_radius(base_radius[0] + base_gap(self))

    @property
    def reason_without_minimum(self) -> str:
        """Why its cam can shrink to a point while only undercut is excluded; "" if it cannot."""
        return ""

    def check_dimensions(self, base_radius: Ends, segments: Segments) -> None:
        """Refuse dimensions with which no base radius between two ends [mm] works.

        Displacements of the segments count from the lowest position.
        """
        return None

    def feasible_base_radii(self, base_radius: Ends, stroke: float) -> Ends:
        """The part of a range of base radii at which the follower can move through a stroke."""
        return base_radius

    def pressure_angle_constraints(self, slope: float) -> NonconvexConstraints:
        """|tan α| ≤ slope where it is not linear in s, s' and z together."""
        return ()

    def profile_radius_rows(self, least: float) -> tuple[LinearInequality, ...]:
        """Radius of the convex profile ≥ least, linear in s to s'' and z."""
        return ()

    def profile_radius_constraints(self, least: float) -> NonconvexConstraints:
        """Radius of the convex profile ≥ least where its half-planes of the size are known."""
        return ()

    def outer_radius_constraints(self, largest: float) -> NonconvexConstraints:
        """Largest radius of the traced curve ≤ largest where ``outer_radius_norm`` is None."""
        return ()

    @abstractmethod
    def dimensions(self, z: Vector) -> Mapping[str, float]:
        """The cam's dimensions as named on the wire [mm, deg]."""

    def motion_dimensions(self, motion: Motion, z: Vector) -> Mapping[str, float]:
        """Dimensions that depend on the finished motion too [mm]."""
        return {}

    def displacement_range(self, z: Vector) -> tuple[float, float, Callable[[float], float]] | None:
        """Ends of the displacements that it can reach, and their map to the wire; None: all."""
        return None

    def fixable_dimension(self) -> FixableDimension | None:
        """A free dimension which, fixed, leaves half-planes of the size; None where none is."""
        return None


class InverseKinematics(ABC):
    """What a family has if a measured profile is read back with it."""

    @abstractmethod
    def pose(self, point: Any, normal: Any) -> tuple[Any, Any]:
        """Where the follower has its trace point at a point of the cam.

        Point [mm] and outward unit normal, (2, n) each, are in the frame of a ccw cam. Out come the
        cam angle θ [rad], any turn, and position [mm], (n,) each: the displacement from a place
        that is the family's own. Not a number where the follower does not reach.
        """

    @abstractmethod
    def size_at_lowest(self, position: float) -> Vector:
        """The size z of a cam whose lowest position is this one [mm]; see ``pose``."""

    @abstractmethod
    def clearance(self, away: Any, up: Any) -> Any:
        """How far points, (2, n) from the trace point, lie outside the follower's body [mm].

        ``up``: (2,) the drive direction; both in the cam's frame.
        """


class RollerFollower(Follower, InverseKinematics, ABC):
    """A follower with a roller; its closure says which curves the cam is made of."""

    roller_radius_mm: float
    closure: Closure

    def prime_radii(self, base_radius: Ends) -> Ends:
        """Prime radii of base radii between two ends; inside a ring any positive one is a cam."""
        low, high = (radius + base_gap(self) for radius in base_radius)
        return max(low, 0.0), high if high > 0.0 else MIN_PRIME_RADIUS_RATIO * base_radius[1]

    def searched_norm(self, base_radius: Ends) -> float:
        low, high = self.prime_radii(base_radius)
        return self.norm_from_radius(min(max(low, MIN_PRIME_RADIUS_RATIO * base_radius[0]), high))

    def clearance(self, away: Any, up: Any) -> Any:
        return np.hypot(away[0], away[1]) - self.roller_radius_mm


class FlatFaceFollower(Follower, ABC):
    """A follower with a flat face. Its trace point is the contact point.

    The last of its size variables is the base radius.

    Attributes:
        face_ends: names of the two ends of the face, as in the limit on its width: the first lies
            against the direction of ``face_axis``, the second along it.
    """

    always_convex: ClassVar[bool] = True
    face_ends: ClassVar[tuple[str, str]]
    roller_radius_mm: ClassVar[float] = 0.0  # type: ignore[misc]
    closure: ClassVar[Closure] = SINGLE_FLANK  # type: ignore[misc]

    @abstractmethod
    def face_radius(self, s: Any, z: Any) -> Any:
        """Signed radius of curvature of the profile [mm], negative where it is undercut."""

    def curvature_terms(self, s: Any, z: Any) -> tuple[Any, Any]:
        radius = self.face_radius(s, z)
        return radius * abs(radius), radius * radius

    @abstractmethod
    def face_normal_rate(self, s: Any, z: Any) -> Vector2:
        """Rate at which the face's unit normal n turns as seen from the cam: n' + J n."""

    @abstractmethod
    def face_axis(self, s: Any, z: Any) -> tuple[Vector2, Vector2]:
        """The point of the face from which reach is measured, and the unit vector along it."""

    def contact_rows(self, end: str, reach: float) -> tuple[LinearInequality, ...]:
        """Contact on the inner side of an end at ``reach`` from the reference point, if linear."""
        return ()

    def contact_constraints(self, end: str, reach: float) -> NonconvexConstraints:
        """The same where it is not linear."""
        return ()


def flat_face(follower: TracePoint) -> FlatFaceFollower | None:
    """The follower as one with a flat face; None where it has rollers."""
    return follower if isinstance(follower, FlatFaceFollower) else None


def paths(follower: Follower) -> Mapping[str, TracePoint]:
    """The trace points behind the flanks by name; the follower's own is the first."""
    return {flank.path: flank.trace for flank in follower.flanks}


def base_gap(follower: Follower) -> float:
    """Prime radius less base radius [mm]: negative where the cam is touched from inside."""
    first = follower.without_free_counter().flanks[0]
    return first.side * first.distance


def prime_radius(follower: Follower, z: Vector) -> float:
    """Rp at a size: the distance of the trace point from the cam's axis at the lowest position."""
    return follower.radius_from_norm(follower.radius_norm().value(z))
