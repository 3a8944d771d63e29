"""What every named motion law promises."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

from pydantic import BaseModel, ConfigDict

from synthesis.motion import FreeLaw, StretchKind
from synthesis.numerics.piecewise import Piecewise


class MotionLaw(BaseModel, ABC):
    """A named law: its name on the wire, its title, and its normalised curve."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    kind: str
    title: ClassVar[str]
    source: ClassVar[str]

    @abstractmethod
    def curve(self, stretch: StretchKind) -> Piecewise:
        """g(x) on [0, 1] with g(0) = 0 and g(1) = 1, as run from start to end of the segment.

        Args:
            stretch: "rise" or "return"; a law with a turn at its end puts it at the top.
        """

    def free(self) -> FreeLaw | None:
        """None: a named law leaves nothing free."""
        return None
