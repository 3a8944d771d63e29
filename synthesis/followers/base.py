"""What every follower family promises, by who asks: see the bases of ``Follower``."""

from __future__ import annotations

import math
from abc import ABC
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from pydantic import BaseModel, ConfigDict

from synthesis.errors import InputError
from synthesis.followers.flank import Flank, Places
from synthesis.followers.judged import Judged
from synthesis.followers.sizing import Sized
from synthesis.followers.told import Told
from synthesis.followers.trace import Host, Trace
from synthesis.ranges import Range


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


class Follower(BaseModel, Host, Sized, Judged, Told, ABC):
    """A follower family: given dimensions, free dimensions (the size z), and its geometry.

    ``Trace`` and ``Host``: geometry. ``Sized``: what formulations and limits ask. ``Judged``: the
    certificate. ``Told``: answers and drawings. Here: the curves of the cam, what is settled after
    the size, and what reading a profile back asks. Symbols and frames as in ``trace``.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    kind: str
    title: ClassVar[str]
    size_charts: ClassVar[tuple[tuple[str, ...], ...]]  # names of z, by what is given
    always_convex: ClassVar[bool] = False  # a profile that is not undercut has no hollows
    guided: ClassVar[bool] = False  # a roller whose slide runs in a guide
    face_ends: ClassVar[tuple[str, ...]] = ()  # of a flat face, as in the limit on its width

    @property
    def size_names(self) -> tuple[str, ...]:
        """Names of the size variables for the dimensions that are given here."""
        return self.size_charts[0]

    def pinning(self) -> Pinning | None:
        """A free dimension that, once it is fixed, leaves curved limits with rows; None: none."""
        return None

    # -- the cam's curves ------------------------------------------------------------------------

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

    # -- settled after the size ------------------------------------------------------------------

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
