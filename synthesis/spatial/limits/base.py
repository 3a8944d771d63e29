"""What every limit on a spatial cam's walls and rollers promises."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import ClassVar

from synthesis.limits.base import Claim, Limit, Machine
from synthesis.motion import Stretch


class SpatialLimit(Limit, ABC):
    """A bound on something that is measured on the finished cam.

    Attributes:
        quantity: its name among the extremes. field: the field that sets the bound.
        upper: whether the bound is the largest value allowed, not the least.
    """

    quantity: ClassVar[str]
    field: ClassVar[str]
    upper: ClassVar[bool]

    @property
    @abstractmethod
    def bound(self) -> float:
        """The bound in the wire's unit."""

    def claims(self, stretches: Sequence[Stretch], machine: Machine) -> tuple[Claim, ...]:
        return ()  # walls are measured as such, not stretch by stretch
