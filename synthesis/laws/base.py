"""What every named motion law promises, and how a law is made from its row in a table."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, ClassVar, Literal

from pydantic import BaseModel, ConfigDict, Field

from synthesis.motion import FreeLaw, StretchKind
from synthesis.numerics.piecewise import Piecewise, join

# VDI 2143: R rests (v = a = 0), U turns back (v = 0, the acceleration is the neighbour's too).
Ends = Literal["R-R", "R-U", "U-R"]

Inflection = Annotated[
    float,
    Field(
        ge=0.05,
        le=0.95,
        description="Where the acceleration ends and the deceleration begins, as a fraction of "
        "the segment from its start, on a rise as on a return; 0.5 is the law as published.",
    ),
]
Turn = Annotated[
    Literal["top", "bottom"],
    Field(
        description="Which end of the stroke the follower turns back at; it dwells at the other."
    ),
]


@dataclass(frozen=True, eq=False)
class Row:
    """One law of a family.

    Attributes:
        title: what engineers call it.
        source: where it was published.
        shape: its normalised displacement; for a law between rests, which is symmetric, only
            the first half, on [0, 1/2].
    """

    title: str
    source: str
    shape: Piecewise


class MotionLaw(BaseModel, ABC):
    """A named law: its name on the wire, its title, and its normalised curve."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    kind: str
    rows: ClassVar[Mapping[str, Row]]

    @property
    def title(self) -> str:
        """What engineers call the law."""
        return self.rows[self.kind].title

    @property
    def source(self) -> str:
        """Where the law was published."""
        return self.rows[self.kind].source

    @property
    @abstractmethod
    def ends(self) -> Ends:
        """How a rise by this law begins and ends."""

    @abstractmethod
    def curve(self, stretch: StretchKind) -> Piecewise:
        """g(x) on [0, 1] with g(0) = 0 and g(1) = 1, as run from start to end of the segment.

        Args:
            stretch: "rise" or "return"; a law with a turn at its end puts it at the top.
        """

    def free(self) -> FreeLaw | None:
        """None: a named law leaves nothing free."""
        return None


class RestToRest(MotionLaw):
    """A law between two rests, point-symmetric before its inflection is moved."""

    inflection: Inflection = 0.5

    @property
    def ends(self) -> Ends:
        return "R-R"

    def curve(self, stretch: StretchKind) -> Piecewise:
        return with_inflection(self.rows[self.kind].shape, self.inflection)


@lru_cache(maxsize=1024)
def with_inflection(half: Piecewise, inflection: float) -> Piecewise:
    """The whole law, from its first half f on [0, 1/2], with its inflection λ where asked.

    g(x) = 2λ f(x/2λ) up to λ, then 1 − 2(1−λ) f((1−x)/2(1−λ)): the velocity is continuous at λ,
    and so is the acceleration where it is zero. The second half is written about x = 1, so
    nothing cancels there.
    """
    before, after = 2.0 * inflection, 2.0 * (1.0 - inflection)
    first = half.placed(0.0, before, 0.0, before)
    last = half.placed(0.0, after, 0.0, after).reversed().placed(inflection, 1.0, 1.0, -1.0)
    return join([first, last])


@lru_cache(maxsize=64)
def mirrored(shape: Piecewise) -> Piecewise:
    """x ↦ 1 − f(1 − x): the same law run backwards."""
    return shape.reversed().placed(0.0, 1.0, 1.0, -1.0)
