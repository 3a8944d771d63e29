"""Limits that imply linear inequalities where a trace point, or motion and size, lie in boxes.

Symbols as in ``constraints``. A row of such a limit holds for every motion and size of a box, so
that bounds over all laws may rest on it wherever a better cam is known to be in the box.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

from synthesis.catalogue.constraints import (
    MotionBox,
    MotionSizeBox,
    NonconvexConstraint,
    PointInequalities,
    SlideCoordinates,
)
from synthesis.numerics.piecewise import Array


@dataclass(frozen=True)
class BoxBound(ABC):
    """A limit that implies linear inequalities where a trace point lies in a box.

    Attributes:
        source: as of a ``LinearInequality``.
        coordinates: the trace point's, in motion and size.
        order: highest derivative of s in the inequalities.
        needs_motion_bounds: whether ``linear_relaxation`` needs bounds of motion and size besides
            those of the point. known_orders: 2, or 3 where bounds of s'' serve it as well.
        varies_with_angle: whether motions that it allows at one cam angle may break it at another.
    """

    source: str
    coordinates: SlideCoordinates

    @property
    def order(self) -> int:
        return 2

    @property
    @abstractmethod
    def needs_motion_bounds(self) -> bool: ...

    @property
    def varies_with_angle(self) -> bool:
        return False

    @property
    def known_orders(self) -> int:
        return 2

    @abstractmethod
    def linear_relaxation(
        self, low: Array, high: Array, about: Array | None, moving: MotionBox | None = None
    ) -> tuple[PointInequalities, ...]:
        """Linear inequalities implied wherever (X, u, e) lies in boxes (3, n); () if none is known.

        ``about``: (3, n) where they shall be tight; None: in the middle of each box. ``moving``:
        bounds of motion and size there; None: none are known.
        """


BoxBounds = tuple[BoxBound, ...]


@dataclass(frozen=True)
class ConstraintBound(BoxBound):
    """A nonconvex constraint with its relaxation, the point being the motion itself."""

    constraint: NonconvexConstraint
    needs_motion_bounds: ClassVar[bool] = True

    @property
    def order(self) -> int:
        return self.constraint.order

    def linear_relaxation(
        self, low: Array, high: Array, about: Array | None, moving: MotionBox | None = None
    ) -> tuple[PointInequalities, ...]:
        if moving is None:
            return ()
        box = MotionSizeBox(
            moving.low[0], moving.high[0], moving.low[1], moving.high[1], moving.sizes
        )
        return self.constraint.linear_relaxation(box, moving.about)
