"""The base of every limit: one expression with its bounds, in the forms its readers need.

A limit states what the certificate has to show (``claims``), and whatever of this the optimiser can
use: linear inequalities (``rows``), second-order cones on the size (``norm_bounds``), bounds on a
residual vibration, nonconvex constraints with linear relaxations, and smooth constraint functions.
What a limit does not state in one form is an empty tuple there. Two rules make the forms agree:

* Everything in ``rows``, ``norm_bounds`` and ``vibration_bounds`` is implied by the claims, so that
  a relaxation built from them bounds every cam that keeps the limit.
* ``smooth_constraints`` completes them: a cam that keeps rows, cones and smooth constraints keeps
  the claims. By default it evaluates ``nonconvex``.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

from synthesis.catalogue.box_bounds import BoxBounds, ConstraintBound
from synthesis.catalogue.constraints import (
    LinearInequality,
    NonconvexConstraints,
    NormBounds,
    SlideCoordinates,
    Vector,
    VibrationBound,
)
from synthesis.catalogue.fields import UnitFields
from synthesis.catalogue.followers.base import Follower
from synthesis.catalogue.followers.kinematics import labelled
from synthesis.catalogue.forces import ReducedLoad
from synthesis.catalogue.motion import PlacedSegment, Segments
from synthesis.numerics.piecewise import Array

AtLowerSpeed = Literal["same", "easier", "either"]
"""What becomes of a limit on a motion that is slowed down."""


@dataclass(frozen=True)
class Machine:
    """The machine around the cam: what the motion means in newtons and in the wire's units.

    ``omega``: cam speed ω [rad/s]. ``load``: None where no force is limited or reported.
    """

    follower: Follower
    omega: float
    load: ReducedLoad | None = None

    def wire_factor(self, order: int) -> float:
        """Factor from s^(order) per radian to the time derivative in the wire's unit."""
        return self.follower.travel.wire_factor(order, self.omega)

    def derivative_unit(self, order: int) -> str:
        """That unit, as in ``mm/s²``."""
        return self.follower.travel.derivative_unit(order)


@dataclass(frozen=True)
class Claim:
    """What the finished cam must satisfy: lower ≤ quantity ≤ upper on the named segments.

    Attributes:
        limit: the limit as named in the certificate.
        quantity: a name that ``certify`` knows, measured in core units (rad, mm, per radian).
        segments: indices of the segments where it must hold.
        lower, upper: bounds in core units; None where there is none.
        unit: unit on the wire.
        to_wire: monotone map from the core's unit to the wire's; None where the wire has no value.
        field: the field of the spec that sets it, as in ``limits/pressure_angle/rise_deg``.
        path: name of the traced curve that is measured, among the follower's ``paths``.
        interval: first and last x, in [0, 1], of these segments where it must hold; None: all.
        equality: the quantity has one value there; the bounds leave no more than rounding.
        flank: name of the flank that is measured, where it is not the first.
        vibration: of the runs that end with these segments; the largest amplitude is measured.
    """

    limit: str
    quantity: str
    segments: tuple[int, ...]
    lower: float | None
    upper: float | None
    unit: str
    to_wire: Callable[[float], float | None]
    field: str
    path: str = ""
    interval: tuple[float, float] | None = None
    equality: bool = False
    flank: str = ""
    vibration: tuple[VibrationBound, ...] = ()


class Limit(UnitFields, ABC):
    """One quantity of the cam that has a bound.

    Attributes:
        kind: name on the wire. title: name for people.
        needs_load: it is about a force, so that the spec has to give the load on the follower.
        at_lower_speed: whether the same motion keeps it as well when it is slowed down, more
            easily, or either more or less so.
        same_on_every_segment: whether one evaluation of its smooth form serves several segments.
    """

    kind: str
    title: ClassVar[str]
    needs_load: ClassVar[bool] = False
    at_lower_speed: ClassVar[AtLowerSpeed] = "same"
    same_on_every_segment: ClassVar[bool] = False

    def applies_to(self, follower: Follower) -> bool:
        """Whether it bounds anything on a cam of such a follower."""
        return True

    @property
    def limits_acceleration(self) -> bool:
        """Whether it bounds the acceleration or the jerk, by that name."""
        return False

    @property
    def bounds_size_below(self) -> bool:
        """Whether it excludes arbitrarily small cams."""
        return False

    @property
    def min_circle_radius(self) -> float:
        """Least radius [mm] of a circle about the cam's axis that is a part of the profile."""
        return 0.0

    def check(self, segments: Segments, machine: Machine, position: int) -> None:
        """Refuse a bound that no such cam can keep, that no motion meets, or without its load."""
        return None

    def rows(self, segment: PlacedSegment, machine: Machine) -> tuple[LinearInequality, ...]:
        """Linear inequalities on one segment; where the limit is not linear, those it implies."""
        return ()

    def norm_bounds(self, segments: Segments, machine: Machine) -> tuple[NormBounds, ...]:
        """Bounds of norms of the size variables."""
        return ()

    def vibration_bounds(self, segments: Segments, machine: Machine) -> tuple[VibrationBound, ...]:
        """Bounds of residual amplitudes after runs of segments."""
        return ()

    def nonconvex(self, segment: PlacedSegment, machine: Machine) -> NonconvexConstraints:
        """Constraints on motion and size together that are not linear in both."""
        return ()

    def curvature_bounds(self, segment: PlacedSegment, machine: Machine) -> BoxBounds:
        """Bounds of the traced curves' curvature, relaxed where the trace point lies in a box."""
        return ()

    def box_bounds(self, segment: PlacedSegment, machine: Machine) -> BoxBounds:
        """All that the limit implies where a trace point, or motion and size, lie in a box."""
        motion = SlideCoordinates.of_motion(len(machine.follower.size_names))
        nonconvex = (one for one in self.nonconvex(segment, machine) if one.has_relaxation)
        bounds = self.curvature_bounds(segment, machine)
        return (*bounds, *(ConstraintBound(one.source, motion, one) for one in nonconvex))

    def smooth_constraints(
        self, segment: PlacedSegment, machine: Machine, theta: Array, s: Any, z: Any
    ) -> tuple[Any, ...]:
        """Dimensionless functions that must be ≤ 0, for local solvers and for checks.

        θ are numbers, (n,) [rad]; s to s''' NumPy arrays or CasADi columns of one length.
        """
        constraints = self.nonconvex(segment, machine)
        return tuple(value for constraint in constraints for value in constraint.excess(s, z))

    @abstractmethod
    def claims(self, segments: Segments, machine: Machine) -> tuple[Claim, ...]:
        """The bounds that the certificate has to show on the finished cam."""

    def _claim(
        self,
        segments: Segments,
        bounds: tuple[float | None, float | None],
        field: str,
        unit: str,
        *,
        name: str = "",
        label: str = "",
        quantity: str = "",
        to_wire: Callable[[float], float | None] = float,
        indices: tuple[int, ...] | None = None,
        **more: Any,
    ) -> Claim:
        """A claim of this limit on segments of these indices; None: all that have an extent.

        The field of the limit sets the bounds [core units]. Name and quantity are the limit's kind
        if they are left out; the label is that of a flank or path. More is as of a ``Claim``.
        """
        return Claim(
            labelled(name or self.kind, label), quantity or self.kind,
            segment_indices(segments) if indices is None else indices, *bounds, unit,
            to_wire, f"{self.kind}/{field}", **more,
        )  # fmt: skip


def all_claims(
    limits: Iterable[Limit], segments: Segments, machine: Machine, size: Vector
) -> list[Claim]:
    """The claims of limits in their order, and that the follower can take every displacement."""
    claims = [claim for limit in limits for claim in limit.claims(segments, machine)]
    reach = machine.follower.displacement_range(size)
    if reach is not None:
        low, high, to_wire = reach
        moving, unit = segment_indices(segments), machine.follower.travel.unit
        claims.append(Claim("reach", "displacement", moving, low, high, unit, to_wire, "follower"))
    return claims


def scaling(factor: float, less: float = 0.0) -> Callable[[float], float]:
    """The map that multiplies by ``factor`` and subtracts ``less``."""
    return lambda value: value * factor - less


def segment_indices(segments: Segments, *kinds: str) -> tuple[int, ...]:
    """Indices of the segments that move so and have an extent (of all if nothing is named)."""
    moving = (s for s in segments if s.angle > 0.0)
    return tuple(s.index for s in moving if not kinds or not set(kinds).isdisjoint(s.senses))
