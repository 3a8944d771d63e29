"""Followers that a measured profile can be read back with: inverse kinematics."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

from synthesis.catalogue.followers.base import Follower
from synthesis.errors import InputError


@runtime_checkable
class InverseKinematics(Protocol):
    """What a follower family offers so that its motion can be found from a profile."""

    def pose(self, point: Any, normal: Any) -> tuple[Any, Any]:
        """Where the follower has its trace point at a point of the cam.

        Args:
            point: of the cam [mm]. normal: outward unit normal there. Both (2, n), in the frame
                of a ccw cam.

        Returns:
            cam angle θ [rad], any turn, and position [mm], (n,) each: the displacement from a
            place that is the family's own. Not a number where the follower does not reach.
        """

    def size_at_lowest(self, position: float) -> tuple[float, ...]:
        """The size z of a cam whose lowest position is this one [mm]; see ``pose``."""

    def clearance(self, away: Any, up: Any) -> Any:
        """How far points lie outside the follower's body [mm].

        Args:
            away: (2, n) from the trace point [mm]. up: (2,) the drive direction, both in the cam's
                frame.
        """


def inverse_kinematics(follower: Follower) -> InverseKinematics:
    """The follower as one whose motion can be read back from a profile.

    Raises:
        InputError: no inverse kinematics are known for this family.
    """
    if isinstance(follower, InverseKinematics):
        return follower
    raise InputError(
        "/follower/kind", follower.kind, "Profiles are not read back for this follower.",
        "Take a translating follower, or a roller on an arm.",
    )  # fmt: skip
