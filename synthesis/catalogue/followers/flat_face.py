"""What all followers with a flat face have in common: contact moves along the face."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar

from synthesis.catalogue.constraints import LinearInequality, NonconvexConstraint
from synthesis.catalogue.followers.base import Follower
from synthesis.catalogue.followers.kinematics import TracePoint, Vector2


class FlatFaceFollower(Follower, ABC):
    """A follower with a flat face. Its trace point is the contact point.

    Attributes:
        face_ends: names of the two ends of the face, as in the limit on its width: the first lies
            against the direction of ``face_axis``, the second along it.
    """

    always_convex: ClassVar[bool] = True
    face_ends: ClassVar[tuple[str, str]]

    @property
    def roller_radius(self) -> float:
        return 0.0

    @abstractmethod
    def face_normal_rate(self, s: Any, z: Any) -> Vector2:
        """Rate at which the face's unit normal n turns as seen from the cam: n' + J n."""

    @abstractmethod
    def face_axis(self, s: Any, z: Any) -> tuple[Vector2, Vector2]:
        """The point of the face from which reach is measured, and the unit vector along it."""

    def contact_rows(self, first: float, second: float) -> tuple[LinearInequality, ...]:
        """Contact within ``first`` and ``second`` of the reference point, towards the two ends.

        One inequality for each end; () where contact is not linear in motion and size.
        """
        return ()

    def contact_constraints(self, end: str, reach: float) -> tuple[NonconvexConstraint, ...]:
        """Contact on the inner side of an end at ``reach``, where it is not linear."""
        return ()


def flat_face(follower: TracePoint) -> FlatFaceFollower | None:
    """The follower as one with a flat face; None where it has rollers."""
    return follower if isinstance(follower, FlatFaceFollower) else None
