"""What every follower family promises."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from pydantic import BaseModel, ConfigDict

from synthesis.errors import InputError
from synthesis.followers.flank import Flank, Places, Trace, Vector2
from synthesis.motion import Motion, Stretch
from synthesis.ranges import Range
from synthesis.terms import Cone, Curved, Implied, Norm, Row
from synthesis.units import Travel


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


@dataclass(frozen=True)
class Pinning:
    """A dimension that is free within low and high, as followers for which it is fixed.

    Attributes:
        name: as a person would say it.
        low, high: its range [mm], may be open. unit: a value of its order of magnitude.
        of: its value for size variables of the free follower.
        at: the follower with it fixed.
        whole: value and size variables of that follower to those of the free one.
    """

    name: str
    low: float
    high: float
    unit: float
    of: Callable[[tuple[float, ...]], float]
    at: Callable[[float], Follower]
    whole: Callable[[float, tuple[float, ...]], tuple[float, ...]]


@dataclass(frozen=True)
class Measure:
    """What the certificate has to measure for a bound: lower ≤ quantity ≤ upper [core units].

    ``to_wire``: monotone map to the wire's ``unit``; None where the wire has no value.
    """

    quantity: str
    lower: float | None
    upper: float | None
    to_wire: Callable[[float], float | None]
    unit: str = "mm"


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


class Follower(BaseModel, ABC):
    """A follower family: given dimensions, free dimensions (the size z), and its geometry.

    Symbols: s to s''' displacement and derivatives per radian [mm]; z size variables [mm];
    Rp prime radius. Vectors are in the machine frame: origin on the cam's axis, y along an
    upward follower, the cam turning counter-clockwise (a clockwise cam is the mirror image).
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    kind: str
    title: ClassVar[str]
    size_charts: ClassVar[tuple[tuple[str, ...], ...]]  # names of z, by what is given
    always_convex: ClassVar[bool] = False  # a profile that is not undercut has no hollows
    face_ends: ClassVar[tuple[str, ...]] = ()  # of a flat face, as in the limit on its width

    @property
    def size_names(self) -> tuple[str, ...]:
        """Names of the size variables for the dimensions that are given here."""
        return self.size_charts[0]

    @property
    def travel(self) -> Travel:
        """How its displacement is told on the wire."""
        return Travel()

    @property
    @abstractmethod
    def roller_radius(self) -> float:
        """Distance of the profile from the curve of the traced point [mm]; 0 at a knife edge."""

    @property
    def flanks(self) -> tuple[Flank, ...]:
        """The curves that the cam is made of; the base radius is that of the first."""
        return (Flank("", 1, self.roller_radius, "", self),)

    @property
    def paths(self) -> Mapping[str, Trace]:
        """The traced curves behind the flanks, by name; its own is the first."""
        return {flank.path: flank.trace for flank in self.flanks}

    @property
    def base_gap(self) -> float:
        """Prime radius less base radius [mm]: negative where the cam is touched from inside."""
        first = self.alone().flanks[0]
        return first.side * first.distance

    @abstractmethod
    def sizing(self, base_radius: tuple[float, float]) -> Sizing:
        """Where z may lie for a base radius between two ends [mm]."""

    @abstractmethod
    def prime_radius(self) -> Norm:
        """The norm of z that is pushed down for a small cam: Rp, or what grows with it."""

    def radius(self, z: tuple[float, ...]) -> float:
        """The prime radius itself [mm]."""
        return self.prime_radius().value(z)

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

    @abstractmethod
    def pressure_angle_rows(self, slope: float) -> tuple[Row, ...]:
        """|tan α| ≤ slope as rows linear in s, s' and z; () where none say it."""

    def pressure_angle_curves(self, slope: float) -> tuple[Curved, ...]:
        """|tan α| ≤ slope where it is not linear in s, s' and z together; otherwise ()."""
        return ()

    def profile_radius_curves(self, least: float) -> tuple[Curved, ...]:
        """Profile radius ≥ least [mm] where every half-plane of the size is known; otherwise ()."""
        return ()

    def contact_curves(self, end: str, reach: float) -> tuple[Curved, ...]:
        """Contact on this side of an end of the face, ``reach`` [mm] from its middle, likewise."""
        return ()

    def outer_radius_curves(self, largest: float) -> tuple[Curved, ...]:
        """Largest radius of the traced curve ≤ largest [mm] where it is not a norm of z."""
        return ()

    def pinning(self) -> Pinning | None:
        """A free dimension that, once it is fixed, leaves curved limits with rows; None: none."""
        return None

    @abstractmethod
    def traced_point(self, s: Any, z: Any) -> tuple[Vector2, ...]:
        """The traced point and its θ-derivatives in the machine frame: a roller's centre.

        Args:
            s: the four values s, s', s'', s''', of any arithmetic type (arrays, intervals).
            z: size variables.

        Returns:
            pairs (x, y) of the point and at least its first two derivatives.
        """

    @abstractmethod
    def direction(self, s: Any, z: Any) -> tuple[Vector2, Vector2]:
        """Unit vector along which the follower is driven, and its θ-derivative."""

    @abstractmethod
    def curvature_terms(self, s: Any, z: Any) -> tuple[Any, Any]:
        """Numerator N and squared speed W² of the traced curve: κ = N / W³, convex positive."""

    def curvature_implied(self, side: int, most: float) -> tuple[Implied, ...]:
        """What rows are implied by side · κ ≤ most [1/mm], most > 0; () where none is known."""
        return ()

    def normal(self, tangent: Vector2, s: Any, z: Any) -> Vector2:
        """Outward common normal, of any length: of the traced curve, or of a face that has one.

        Args:
            tangent: of the traced curve, which runs clockwise round the cam.
            s, z: as for ``traced_point``.
        """
        tx, ty = tangent
        return -ty, tx

    def face_turn(self, s: Any, z: Any) -> Vector2:
        """How the face's unit normal n turns as seen from the cam: n' + J n; only with a face."""
        raise NotImplementedError(f"{self.kind} has no face")

    def face_axis(self, s: Any, z: Any) -> tuple[Vector2, Vector2]:
        """Where a face's reach is measured from, and the unit vector along it; only with one."""
        raise NotImplementedError(f"{self.kind} has no face")

    def adjustable(self) -> Mapping[str, float | Range | None]:
        """Its dimensions that may also be left free: field and value."""
        return {}

    @property
    def companions(self) -> tuple[str, ...]:
        """Paths of further rollers that its motion moves along."""
        return ()

    def companion_ranges(self) -> Mapping[str, tuple[str, float | Range | None]]:
        """Dimensions settled after the size: field, its name among the dimensions, value."""
        return {}

    def places(self, z: tuple[float, ...], s_max: float) -> Places:
        """Where such a dimension makes sense, with displacements up to ``s_max``."""
        return Places(-math.inf, math.inf, True)

    def opened(self) -> Follower:
        """The same with everything left free that is settled after the size."""
        return self

    def alone(self) -> Follower:
        """The same without what is settled after the size and is still free."""
        return self

    def companion(self, values: Mapping[str, float]) -> Follower:
        """The same with the flanks of its further rollers alone."""
        return self

    def completed(self, values: Mapping[str, float]) -> Follower:
        """The same with what was settled after the size, by the names of the dimensions."""
        return self

    def unsized(self) -> Follower:
        """The same without a dimension that would fix the base radius in other words."""
        return self

    def check_reach(self, base_radius: tuple[float, float], stretches: Sequence[Stretch]) -> None:
        """Refuse dimensions that no base radius between two ends [mm] can serve.

        ``stretches``: the program on the cam, displacements from the lowest position.
        """
        return None

    def reachable(self, base_radius: tuple[float, float], stroke: float) -> tuple[float, float]:
        """The part of a range of base radii at which it can move through a stroke [mm]."""
        return base_radius

    def displacement_measure(self, z: tuple[float, ...]) -> Measure | None:
        """Between which displacements the follower can stand; None where all of them do."""
        return None

    def profile_radius_rows(self, least: float) -> tuple[Row, ...]:
        """Profile radius ≥ least as rows linear in s to s'' and z; () where it is not linear."""
        return ()

    def profile_radius_measure(self, flank: Flank, least: float) -> Measure | None:
        """Convex radius of a flank ≥ least on the finished cam; None where it cannot fail.

        Of a curve at the distance D: σκ ≤ 1/(D + least), free of division by what may vanish on
        the way from convex to hollow.
        """
        side, distance, smallest = flank.side, flank.distance, flank.distance + least
        if smallest <= 0.0:
            return None

        def to_wire(curvature: float) -> float | None:
            bend = side * curvature
            return 1.0 / bend - distance if bend > 0.0 else None

        sharpest = side / smallest
        low, high = (None, sharpest) if side > 0 else (sharpest, None)
        return Measure("pitch_curvature", low, high, to_wire)

    def radius_rows(self, least: float) -> tuple[Row, ...]:
        """Traced curve at least so far from the axis as rows; () where the size sees to it."""
        return ()

    def contact_rows(self, left: float, right: float) -> tuple[Row, ...]:
        """Contact within left and right [mm] of a face's middle, in this order; () without one."""
        return ()

    def shape(self, motion: Motion, z: tuple[float, ...]) -> Shape:
        """What a drawing shows at cam angle 0."""
        s = motion.derivatives([0.0])
        (x, y), *_ = self.traced_point(s, z)
        return Shape((float(x[0]), float(y[0])), self.roller_radius)

    def radius_of(self, value: float) -> float:
        """Rp at a value of the norm ``prime_radius`` [mm]: a monotone map."""
        return value

    def value_of(self, radius: float) -> float:
        """The norm ``prime_radius`` at a prime radius [mm]: the inverse of ``radius_of``."""
        return radius

    # -- read back from a profile ----------------------------------------------------------------

    def posture(self, point: Any, normal: Any) -> tuple[Any, Any]:
        """The posture in which the follower has its traced point at a point of the cam.

        Args:
            point: of the cam [mm]. normal: outward unit normal there. Both (2, n), in the frame
                of a ccw cam.

        Returns:
            cam angle θ [rad], any turn, and position [mm], (n,) each: the displacement from a
            place that is the family's own. Not a number where the follower does not reach.

        Raises:
            InputError: such a follower is not read back from a profile.
        """
        raise InputError(
            "/follower/kind", self.kind, "Profiles are not read back for this follower.",
            "Take a translating follower, or a roller on an arm.",
        )  # fmt: skip

    def lowest(self, position: float) -> tuple[float, ...]:
        """The size z of a cam whose lowest position is this one [mm]; see ``posture``."""
        raise NotImplementedError(f"{self.kind} has no posture")

    def clearance(self, away: Any, up: Any) -> Any:
        """How far points lie outside the follower's body [mm].

        Args:
            away: (2, n) from the traced point [mm]. up: (2,) the drive's direction, both in the
                cam's frame.
        """
        return np.hypot(away[0], away[1]) - self.roller_radius

    @abstractmethod
    def outermost(self, s_max: float) -> Norm | None:
        """Largest radius of the traced curve, at displacement ``s_max``, as a norm of z.

        Or what grows with that radius, as for ``prime_radius``; None where it is no norm: then
        ``outer_radius_curves`` say it.
        """

    def nearest(self, s_max: float) -> float:
        """Displacement between 0 and ``s_max`` at which the traced curve is nearest to the axis."""
        return 0.0

    def second_arm(self, length: float, angle: float) -> Trace:
        """The roller of a second arm [mm] at its pivot, at an angle [rad]; only with an arm."""
        raise NotImplementedError(f"{self.kind} has no arm")

    def arm_angle(self, s: float, z: tuple[float, ...]) -> float:
        """Angle at its pivot from the line to the axis to the arm [rad]; only with an arm."""
        raise NotImplementedError(f"{self.kind} has no arm")

    @abstractmethod
    def dimensions(self, z: tuple[float, ...]) -> Mapping[str, float]:
        """The cam's dimensions as named on the wire [mm, deg]."""

    def motion_dimensions(self, motion: Motion, z: tuple[float, ...]) -> Mapping[str, float]:
        """Dimensions that follow from the finished motion [mm]."""
        return {}
