"""The base of every named motion law: how one is made from its table entry, and its peak values."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field

from synthesis.catalogue.fields import AnswerModel, FiniteModel
from synthesis.catalogue.motion import FreeLaw, SegmentKind
from synthesis.numerics.maxima import maximise
from synthesis.numerics.piecewise import Array, Piecewise, concatenate

# VDI 2143: R rests (v = a = 0), G has a constant velocity (a = 0), U turns back (v = 0, the
# acceleration is the neighbour's too), B moves.
EndKinds = Literal["R-R", "R-U", "U-R"]
EndDerivatives = tuple[float | None, float | None]
"""g' and g'' at an end, None where nothing is required."""
REST: EndDerivatives = (0.0, 0.0)
ANY: EndDerivatives = (None, None)
TASKS = tuple(f"{start}-{end}" for start in "RGUB" for end in "RGUB")

AT_REST = 1e-12  # |g'| + |g''| below which a law begins at rest, but for rounding

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
class LawEntry:
    """One law of a family, as published.

    Attributes:
        title: what engineers call it. source: where it was published.
        shape: its normalised displacement; for a law between rests, which is symmetric, only
            the first half, on [0, 1/2].
    """

    title: str
    source: str
    shape: Piecewise


class MotionLaw(FiniteModel, ABC):
    """A named law: its name on the wire, its title, and its normalised curve."""

    kind: str
    entries: ClassVar[Mapping[str, LawEntry]]
    inherited_derivatives: ClassVar[int] = 0
    """How many derivatives it takes over from its neighbours at each end; 0: it has its own."""

    @property
    def entry(self) -> LawEntry:
        """The law as published."""
        return self.entries[self.kind]

    @property
    @abstractmethod
    def ends(self) -> EndKinds:
        """How a rise by this law begins and ends."""

    @abstractmethod
    def curve(self, segment: SegmentKind) -> Piecewise:
        """g(x) on [0, 1] from 0 to 1, as run from start to end of a rise or a return.

        A law with a turn at its end puts it at the top.
        """

    @abstractmethod
    def with_end_derivatives(
        self, segment: SegmentKind, start: EndDerivatives, end: EndDerivatives
    ) -> Piecewise:
        """The law with these g' and g'' at its ends, as nearly as it can: the caller checks."""

    @property
    @abstractmethod
    def tasks(self) -> tuple[str, ...]:
        """The tasks of VDI 2143 that the law can serve on a rise, as "R-G"."""

    @property
    def may_reverse(self) -> bool:
        """Whether it may move backwards for the sake of its end states."""
        return False

    def with_smoothness_2(self) -> Self:
        """Itself: only a spline has a choice."""
        return self

    def free_law(self, knots: tuple[float, ...] = ()) -> FreeLaw | None:
        """None: a named law leaves nothing free."""
        return None


class SymmetricLaw(MotionLaw, ABC):
    """A law between two rests, point-symmetric before its inflection is moved."""

    ends: ClassVar[EndKinds] = "R-R"

    if TYPE_CHECKING:  # declared by the families, at its place among the fields of the wire
        inflection: float

    @property
    def half(self) -> Piecewise:
        """Its first half, on [0, 1/2], as published."""
        return self.entry.shape

    @property
    def tasks(self) -> tuple[str, ...]:
        """R-R and, with a straight line on top, G-G; none where it does not begin at rest."""
        soft = abs(float(self.half(0.0, 1))) + abs(float(self.half(0.0, 2))) <= AT_REST
        return ("R-R", "G-G") if soft else ()

    def curve(self, segment: SegmentKind) -> Piecewise:
        return with_inflection(self.half, self.inflection)

    def with_end_derivatives(
        self, segment: SegmentKind, start: EndDerivatives, end: EndDerivatives
    ) -> Piecewise:
        """Between equal velocities it is the law between rests and a straight line on top."""
        velocity = (end[0] if start[0] is None else start[0]) or 0.0  # 0: required at neither end
        return with_line(self.half, self.inflection, velocity)


class RestToRest(SymmetricLaw):
    """A family of symmetric laws without parameters but the inflection."""

    inflection: Inflection = 0.5


@lru_cache(maxsize=1024)
def with_inflection(half: Piecewise, inflection: float) -> Piecewise:
    """The whole law, from its first half f on [0, 1/2], with its inflection moved to x = λ.

    g(x) = 2λ f(x/2λ) up to λ, then 1 − 2(1−λ) f((1−x)/2(1−λ)): the velocity is continuous at λ,
    and so is the acceleration where it is zero. The second half is written about x = 1, so
    nothing cancels there.
    """
    before, after = 2.0 * inflection, 2.0 * (1.0 - inflection)
    first = half.rescale(0.0, before, 0.0, before)
    last = half.rescale(0.0, after, 0.0, after).mirror().rescale(inflection, 1.0, 1.0, -1.0)
    return concatenate([first, last])


@lru_cache(maxsize=256)
def with_line(half: Piecewise, inflection: float, velocity: float) -> Piecewise:
    """g = (1 − c) f + c x, f the law between rests and c = g'(0) = g'(1) (VDI 2143, task G-G).

    Every piece stays written about its own origin, so nothing cancels that did not before.
    """
    if velocity == 0.0:
        return with_inflection(half, inflection)
    scaled = with_inflection(half, inflection).rescale(0.0, 1.0, 0.0, 1.0 - velocity)
    poly = np.pad(scaled.poly, ((0, 0), (0, max(0, 2 - scaled.poly.shape[1]))))
    poly[:, 0] += velocity * scaled.origins
    poly[:, 1] += velocity
    return replace(scaled, poly=poly)


@lru_cache(maxsize=64)
def mirrored(shape: Piecewise) -> Piecewise:
    """x ↦ 1 − f(1 − x): the same law run backwards."""
    return shape.mirror().rescale(0.0, 1.0, 1.0, -1.0)


JUMP_TOLERANCE = 1e-9  # of the peak: rounding leaves 1e-14, the smallest real jump is above 1


class Characteristics(AnswerModel):
    """Peak values for unit lift and unit angle; null where infinite.

    On a segment of lift h and angle β at cam speed ω, the peaks are Cv·hω/β, Ca·hω²/β² and
    Cj·hω³/β³. At the ends the law meets a dwell, or its own mirror image where it turns.
    """

    Cv: float = Field(description="Largest velocity.")
    Ca_max: float | None = Field(description="Largest acceleration.")
    Ca_min: float | None = Field(description="Largest deceleration, negative.")
    Cj_max: float | None = Field(description="Largest jerk.")
    Cj_min: float | None = Field(description="Most negative jerk.")


@lru_cache(maxsize=256)
def characteristics(law: MotionLaw) -> Characteristics:
    """Peak values of a rise by ``law``."""
    curve = law.curve("rise")
    peak_v, peak_a, peak_j = (extremes(curve, order) for order in (1, 2, 3))
    start, end = law.ends.split("-")
    v_jumps = jumps(curve, 1, True, True)
    a_jumps = jumps(curve, 2, start == "R", end == "R")
    jerks = peak_j if len(v_jumps) == 0 else (None, None)
    return Characteristics(
        Cv=max(abs(value) for value in peak_v),
        Ca_max=None if np.any(v_jumps > 0.0) else peak_a[0],
        Ca_min=None if np.any(v_jumps < 0.0) else peak_a[1],
        Cj_max=None if np.any(a_jumps > 0.0) else jerks[0],
        Cj_min=None if np.any(a_jumps < 0.0) else jerks[1],
    )


def extremes(curve: Piecewise, order: int) -> tuple[float, float]:
    """Largest and smallest value of the ``order``-th derivative, one-sided at breaks."""
    up, down = ([*[0.0] * order, sign] for sign in (1.0, -1.0))
    return maximise(curve, up)[0], -maximise(curve, down)[0]


def jumps(curve: Piecewise, order: int, from_rest: bool, to_rest: bool) -> Array:
    """Jumps of the ``order``-th derivative: at breaks, and against rest at the ends."""
    before = curve(curve.breaks, order, "left")
    after = curve(curve.breaks, order, "right")
    before[0] = 0.0 if from_rest else after[0]
    after[-1] = 0.0 if to_rest else before[-1]
    step = after - before
    scale = max(np.abs(before).max(), np.abs(after).max(), 1.0)
    return np.asarray(step[np.abs(step) > JUMP_TOLERANCE * scale])
