"""What a move has to keep on the way: windows with bounds, and points to pass through."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from math import inf
from typing import Annotated

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.fields import Number, Range, UnitFields, ends
from synthesis.catalogue.limits.motion import FIELDS, TRAVEL, SegmentBound

SHORTEST = 1e-3  # of the segment: knots may not lie closer
MOST = 50  # windows, and points, on a segment
Degrees = Annotated[float, Field(ge=0.0, le=360.0)]
Bounds = Number | Range | None
Bound = tuple[int, str, float, float]  # order of the derivative, field, lower and upper bound


class Window(UnitFields):
    """Bounds that hold on a part of the segment; a number in place of a range holds the value."""

    from_deg: Degrees = Field(description="Where it begins, from the segment's start.")
    to_deg: Degrees = Field(description="Where it ends, from the segment's start.")
    travel_mm: Bounds = Field(
        None, description="Distance moved since the segment's start, positive in its own sense."
    )
    travel_deg: Bounds = Field(None, description="The same of a follower on an arm.")
    velocity_mm_per_s: Bounds = Field(
        None, description="Velocity, negative where the follower returns."
    )
    velocity_deg_per_s: Bounds = Field(None, description="The same of a follower on an arm.")
    acceleration_mm_per_s2: Bounds = Field(None, description="Acceleration, signed.")
    acceleration_deg_per_s2: Bounds = Field(None, description="The same of a follower on an arm.")
    jerk_mm_per_s3: Bounds = Field(None, description="Jerk, signed.")
    jerk_deg_per_s3: Bounds = Field(None, description="The same of a follower on an arm.")

    @model_validator(mode="after")
    def _says_something(self) -> Window:
        if self.from_deg >= self.to_deg:
            raise PydanticCustomError(
                "window_empty",
                "from_deg = {first} is not before to_deg = {last}. "
                "Exchange the two; a single angle is a point.",
                {"first": self.from_deg, "last": self.to_deg},
            )
        if not any(True for _ in self.bounds()):
            raise PydanticCustomError(
                "window_says_nothing",
                "This window bounds nothing. Give min or max of {fields}.",
                {"fields": ", ".join(FIELDS["mm"])},
            )
        return self

    def bounds(self) -> Iterator[Bound]:
        """Everything that is bounded."""
        for fields in FIELDS.values():
            for order, name in enumerate(fields):
                low, high = ends(getattr(self, name))
                if (low, high) != ends(None):
                    yield order, name, low, high

    def ends_of(self, order: int) -> tuple[float, float]:
        """Lower and upper bound of one derivative, −∞ and ∞ where there is none."""
        found = ((low, high) for k, _, low, high in self.bounds() if k == order)
        return next(found, (-inf, inf))

    @property
    def span(self) -> tuple[float, float]:
        """Where it begins and ends [deg]."""
        return self.from_deg, self.to_deg


class Point(UnitFields):
    """A point that the follower passes through."""

    angle_deg: Degrees = Field(description="Where, from the segment's start.")
    travel_mm: float | None = Field(
        None, description="Distance moved since the segment's start, positive in its own sense."
    )
    travel_deg: float | None = Field(None, description="The same of a follower on an arm.")
    tolerance_mm: float = Field(
        0.0, ge=0.0, le=1e6, description="Deviation allowed either way; 0: exactly."
    )
    tolerance_deg: float = Field(
        0.0, ge=0.0, lt=180.0, description="The same of a follower on an arm."
    )
    velocity_mm_per_s: float | None = Field(
        None, description="Velocity there, negative where the follower returns."
    )
    velocity_deg_per_s: float | None = Field(None, description="The same of a follower on an arm.")

    @model_validator(mode="after")
    def _one_travel(self) -> Point:
        if (self.travel_mm is None) == (self.travel_deg is None):
            raise PydanticCustomError(
                "point_unclear",
                "A point has exactly one of travel_mm and travel_deg. Give travel_mm for a "
                "follower that slides, travel_deg for one on an arm.",
            )
        return self

    def bounds(self) -> Iterator[Bound]:
        """Its place, and its velocity if that is asked for."""
        name = self.given_field("tolerance" if self.given("tolerance") else "travel")
        yield TRAVEL, name, *self.ends_of(TRAVEL)
        if self.given("velocity") is not None:
            yield 1, self.given_field("velocity"), *self.ends_of(1)

    def ends_of(self, order: int) -> tuple[float, float]:
        """Least and largest travel that passes; the velocity, −∞ and ∞ where none is required."""
        if order == TRAVEL:
            travel, tolerance = self.given("travel"), self.given("tolerance")
            return travel - tolerance, travel + tolerance
        return ends(self.given("velocity"))

    @property
    def span(self) -> tuple[float, float]:
        """Where it is, twice [deg]."""
        return self.angle_deg, self.angle_deg


@dataclass(frozen=True)
class MotionConstraints:
    """The windows and points of one segment, of a cam angle [deg]."""

    angle: float
    windows: Sequence[Window]
    points: Sequence[Point]

    def _all(self) -> Iterator[tuple[str, Window | Point]]:
        """All of them, each with its place in the segment, as in ``windows/0``."""
        yield from ((f"windows/{j}", window) for j, window in enumerate(self.windows))
        yield from ((f"points/{j}", point) for j, point in enumerate(self.points))

    def segment_bounds(self, segment: int) -> tuple[SegmentBound, ...]:
        """The bounds that they put on the segment with this index in the program."""
        return tuple(
            SegmentBound(
                segment=segment, place=place, field=f"program/{segment}/{place}/{name}{side}",
                order=order, interval=(first, last), min=least, max=most,
            )
            for place, constraint in self._all()
            for first, last in [[min(at / self.angle, 1.0) for at in constraint.span]]
            for order, name, low, high in constraint.bounds()
            for side, least, most in _sides(low, high, both=isinstance(constraint, Point))
        )  # fmt: skip

    def knots(self) -> tuple[float, ...]:
        """x in (0, 1) where windows end and points lie, in order."""
        degrees = {at for _, constraint in self._all() for at in constraint.span}
        return tuple(x for x in sorted(at / self.angle for at in degrees) if 0.0 < x < 1.0)

    def check(self) -> None:
        """Refuse windows and points beyond the segment, and windows that contradict each other."""
        for j, window in enumerate(self.windows):
            if window.to_deg > self.angle * (1.0 + 1e-12):
                raise PydanticCustomError(
                    "window_outside_segment",
                    "windows/{j} ends at {last}°, and the segment at {angle}°. "
                    "Measure both from the segment's start, or split the window.",
                    {"last": window.to_deg, "j": j, "angle": self.angle},
                )
            if window.to_deg - window.from_deg < SHORTEST * self.angle:
                raise PydanticCustomError(
                    "window_too_short",
                    "windows/{j} is {length}° long, less than a thousandth of its segment. "
                    "Make it longer, or give a point.",
                    {"length": window.to_deg - window.from_deg, "j": j},
                )
        for j, point in enumerate(self.points):
            if not 0.0 < point.angle_deg < self.angle:
                raise PydanticCustomError(
                    "point_outside_segment",
                    "points/{j} is at {at}°, not inside the segment of {angle}°. "
                    "Measure it from the segment's start; the ends follow from lift_mm.",
                    {"at": point.angle_deg, "j": j, "angle": self.angle},
                )
        for (j, first), (k, other) in combinations(enumerate(self.windows), 2):
            if max(first.from_deg, other.from_deg) >= min(first.to_deg, other.to_deg):
                continue
            for order, name, low, high in first.bounds():
                least, most = other.ends_of(order)
                if low > most or least > high:
                    raise PydanticCustomError(
                        "windows_contradict",
                        "windows/{j} and windows/{k} overlap, and no {name} satisfies both. "
                        "Widen one of them, or shorten it.",
                        {"j": j, "k": k, "name": name},
                    )

    def check_forward(self, lift: float, sign: float) -> None:
        """Refuse what a law cannot keep that never moves backwards; sign −1 for a return."""
        for place, constraint in self._all():
            low, high = constraint.ends_of(TRAVEL)
            if low > lift or high < 0.0:
                raise PydanticCustomError(
                    "outside_stroke",
                    "{place} asks for a travel from {low} to {high}, and the segment moves from 0 "
                    "to {lift}. Correct it, or allow the law to overshoot.",
                    {"low": low, "place": place, "high": high, "lift": lift},
                )
        for place, constraint in self._all():
            low, high = constraint.ends_of(1)
            if max(sign * low, sign * high) < 0.0:
                raise PydanticCustomError(
                    "against_the_move",
                    "{place} asks for velocities of this sign on a segment that moves the other "
                    "way throughout. Change the sign, or allow the law to overshoot.",
                    {"value": low if abs(low) < abs(high) else high, "place": place},
                )
        order = sorted(enumerate(self.points), key=lambda numbered: numbered[1].angle_deg)
        for (j, one), (k, other) in pairwise(order):
            if one.ends_of(TRAVEL)[0] > other.ends_of(TRAVEL)[1]:
                raise PydanticCustomError(
                    "points_out_of_order",
                    "points/{k} comes after points/{j}, and lies {back} behind it. "
                    "Correct one of them, or allow the law to overshoot.",
                    {"back": one.given("travel") - other.given("travel"), "j": j, "k": k},
                )


def _sides(
    low: float, high: float, *, both: bool
) -> Iterator[tuple[str, float | None, float | None]]:
    """A bound for each finite end of a range; of a single value, or a point, one for both."""
    if both or low == high:
        yield "", low, high
        return
    if low > -inf:
        yield "/min", low, None
    if high < inf:
        yield "/max", None, high
