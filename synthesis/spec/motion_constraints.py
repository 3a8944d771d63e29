"""What a move has to keep on the way: windows with bounds, and points to pass through."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.limits.segment_bound import FIELDS, TRAVEL, SegmentBound
from synthesis.catalogue.ranges import Range, ends
from synthesis.spec.segment import TravelUnit

SHORTEST = 1e-3  # of the segment: knots may not lie closer
MOST = 50
Degrees = Annotated[float, Field(ge=0.0, le=360.0)]
Bounds = float | Range | None
UNITS: tuple[TravelUnit, ...] = ("mm", "deg")


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    @property
    def units(self) -> frozenset[TravelUnit]:
        """Units that it is given in: mm, deg, or both."""
        raise NotImplementedError


class Window(_Part):
    """Bounds that hold on a part of the segment; a number in place of a range holds the value."""

    from_deg: Annotated[Degrees, Field(description="Where it begins, from the segment's start.")]
    to_deg: Annotated[Degrees, Field(description="Where it ends, from the segment's start.")]
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

    def bounds(self) -> Iterator[tuple[int, str, Bounds]]:
        """Order, field and value of everything that is bounded."""
        for fields in FIELDS.values():
            for order, name in enumerate(fields):
                value: Bounds = getattr(self, name)
                if value is not None and ends(value) != ends(None):
                    yield order, name, value

    @property
    def units(self) -> frozenset[TravelUnit]:
        given = {name for _, name, _ in self.bounds()}
        return frozenset(unit for unit in UNITS if not given.isdisjoint(FIELDS[unit]))

    def ends_of(self, order: int) -> tuple[float, float]:
        """Lower and upper bound of one derivative, −∞ and ∞ where there is none."""
        return next((ends(value) for k, _, value in self.bounds() if k == order), ends(None))

    def segment_bounds(
        self, common: dict[str, Any], part: tuple[float, float]
    ) -> Iterator[SegmentBound]:
        """One demand for every end of a range, or for a value."""
        for order, name, value in self.bounds():
            field = f"{common['field']}/{name}"
            low, high = ends(value)
            base = {**common, "interval": part, "order": order}
            if low == high:
                yield SegmentBound(**{**base, "field": field, "min": low, "max": high})
                continue
            for side, end in (("min", low), ("max", high)):
                if abs(end) < float("inf"):
                    yield SegmentBound(**{**base, "field": f"{field}/{side}", side: end})


class Point(_Part):
    """A point that the follower passes through."""

    angle_deg: Annotated[Degrees, Field(description="Where, from the segment's start.")]
    travel_mm: Annotated[
        float | None,
        Field(description="Distance moved since the segment's start, positive in its own sense."),
    ] = None
    travel_deg: Annotated[float | None, Field(description="The same of a follower on an arm.")] = (
        None
    )
    tolerance_mm: Annotated[
        float, Field(ge=0.0, le=1e6, description="Deviation allowed either way; 0: exactly.")
    ] = 0.0
    tolerance_deg: Annotated[
        float, Field(ge=0.0, lt=180.0, description="The same of a follower on an arm.")
    ] = 0.0
    velocity_mm_per_s: Annotated[
        float | None, Field(description="Velocity there, negative where the follower returns.")
    ] = None
    velocity_deg_per_s: Annotated[
        float | None, Field(description="The same of a follower on an arm.")
    ] = None

    @model_validator(mode="after")
    def _one_travel(self) -> Point:
        if (self.travel_mm is None) == (self.travel_deg is None):
            raise PydanticCustomError(
                "point_unclear",
                "A point has exactly one of travel_mm and travel_deg. Give travel_mm for a "
                "follower that slides, travel_deg for one on an arm.",
                {},
            )
        return self

    @property
    def units(self) -> frozenset[TravelUnit]:
        given: dict[TravelUnit, tuple[float | None, ...]] = {
            "mm": (self.travel_mm, self.tolerance_mm or None, self.velocity_mm_per_s),
            "deg": (self.travel_deg, self.tolerance_deg or None, self.velocity_deg_per_s),
        }
        return frozenset(u for u, row in given.items() if any(v is not None for v in row))

    @property
    def _unit(self) -> TravelUnit:
        return "deg" if self.travel_mm is None else "mm"

    @property
    def travel(self) -> float:
        """The travel asked for, in its own unit."""
        return float(getattr(self, FIELDS[self._unit][TRAVEL]))

    @property
    def tolerance(self) -> float:
        """How far off it may be, in its own unit."""
        return float(getattr(self, f"tolerance_{self._unit}"))

    @property
    def velocity(self) -> float | None:
        """The velocity asked for, in its own unit."""
        return self.velocity_deg_per_s if self.travel_mm is None else self.velocity_mm_per_s

    @property
    def nearest(self) -> float:
        """The least travel that passes."""
        return self.travel - self.tolerance

    @property
    def farthest(self) -> float:
        """The largest travel that passes."""
        return self.travel + self.tolerance

    def segment_bounds(self, common: dict[str, Any], x: float) -> Iterator[SegmentBound]:
        """Its place, and its velocity if that is asked for."""
        fields = FIELDS[self._unit]
        name = f"tolerance_{self._unit}" if self.tolerance else fields[TRAVEL]
        asked = [(TRAVEL, name, self.nearest, self.farthest)]
        if self.velocity is not None:
            asked.append((1, fields[1], self.velocity, self.velocity))
        for order, name, low, high in asked:
            field = f"{common['field']}/{name}"
            base = {**common, "field": field, "order": order, "interval": (x, x)}
            yield SegmentBound(**base, min=low, max=high)


def bounds_of_constraints(
    segment: int, angle: float, windows: Sequence[Window], points: Sequence[Point]
) -> tuple[SegmentBound, ...]:
    """All that the windows and points of one segment ask for.

    Args:
        segment: its index in the program. angle: its cam angle [deg].
        windows, points: its own.
    """
    found: list[SegmentBound] = []
    for j, window in enumerate(windows):
        common = _common(segment, f"windows/{j}")
        found += window.segment_bounds(
            common, (window.from_deg / angle, min(window.to_deg / angle, 1.0))
        )
    for j, point in enumerate(points):
        found += point.segment_bounds(_common(segment, f"points/{j}"), point.angle_deg / angle)
    return tuple(found)


def _common(segment: int, place: str) -> dict[str, Any]:
    return {"segment": segment, "place": place, "field": f"program/{segment}/{place}"}


def constraint_knots(
    angle: float, windows: Sequence[Window], points: Sequence[Point]
) -> tuple[float, ...]:
    """x in (0, 1) where windows end and points lie, in order."""
    degrees = {p.angle_deg for p in points}.union(*((w.from_deg, w.to_deg) for w in windows))
    return tuple(x for x in sorted(value / angle for value in degrees) if 0.0 < x < 1.0)


# -- whether they make sense ----------------------------------------------------------------------


def check_places(angle: float, windows: Sequence[Window], points: Sequence[Point]) -> None:
    """Refuse windows and points that are not on a segment of this cam angle [deg]."""
    for j, window in enumerate(windows):
        if window.to_deg > angle * (1.0 + 1e-12):
            raise PydanticCustomError(
                "window_outside_segment",
                "windows/{j} ends at {last}°, and the segment at {angle}°. "
                "Measure both from the segment's start, or split the window.",
                {"last": window.to_deg, "j": j, "angle": angle},
            )
        if window.to_deg - window.from_deg < SHORTEST * angle:
            raise PydanticCustomError(
                "window_too_short",
                "windows/{j} is {length}° long, less than a thousandth of its segment. "
                "Make it longer, or give a point.",
                {"length": window.to_deg - window.from_deg, "j": j},
            )
    for j, point in enumerate(points):
        if not 0.0 < point.angle_deg < angle:
            raise PydanticCustomError(
                "point_outside_segment",
                "points/{j} is at {at}°, not inside the segment of {angle}°. "
                "Measure it from the segment's start; the ends follow from lift_mm.",
                {"at": point.angle_deg, "j": j, "angle": angle},
            )


def check_bounds(windows: Sequence[Window]) -> None:
    """Refuse windows that overlap and leave nothing between their bounds."""
    for j, first in enumerate(windows):
        for k, other in enumerate(windows[j + 1 :], j + 1):
            if max(first.from_deg, other.from_deg) >= min(first.to_deg, other.to_deg):
                continue
            for order, name, value in first.bounds():
                (low, high), (least, most) = ends(value), other.ends_of(order)
                if low > most or least > high:
                    raise PydanticCustomError(
                        "windows_contradict",
                        "windows/{j} and windows/{k} overlap, and no {name} satisfies both. "
                        "Widen one of them, or shorten it.",
                        {"j": j, "k": k, "name": name},
                    )


def check_stroke(
    lift: float, sense: float, windows: Sequence[Window], points: Sequence[Point]
) -> None:
    """Refuse what a law cannot keep that never moves backwards.

    Args:
        lift: of the segment, in its own unit. sense: 1 for a rise, −1 for a return.
        windows, points: its own.
    """
    for place, low, high in _travels(windows, points):
        if low > lift or high < 0.0:
            raise PydanticCustomError(
                "outside_stroke",
                "{place} asks for a travel from {low} to {high}, and the segment moves from 0 to "
                "{lift}. Correct it, or allow the law to overshoot.",
                {"low": low, "place": place, "high": high, "lift": lift},
            )
    for place, low, high in _speeds(windows, points):
        if max(sense * low, sense * high) < 0.0:
            raise PydanticCustomError(
                "against_the_move",
                "{place} asks for velocities of this sign on a segment that moves the other way "
                "throughout. Change the sign, or allow the law to overshoot.",
                {"value": low if abs(low) < abs(high) else high, "place": place},
            )
    order = sorted(range(len(points)), key=lambda j: points[j].angle_deg)
    for j, k in pairwise(order):
        if points[j].nearest > points[k].farthest:
            raise PydanticCustomError(
                "points_out_of_order",
                "points/{k} comes after points/{j}, and lies {back} behind it. "
                "Correct one of them, or allow the law to overshoot.",
                {"back": points[j].travel - points[k].travel, "j": j, "k": k},
            )


def _travels(
    windows: Sequence[Window], points: Sequence[Point]
) -> Iterator[tuple[str, float, float]]:
    for j, window in enumerate(windows):
        yield f"windows/{j}", *window.ends_of(TRAVEL)
    for j, point in enumerate(points):
        yield f"points/{j}", point.nearest, point.farthest


def _speeds(
    windows: Sequence[Window], points: Sequence[Point]
) -> Iterator[tuple[str, float, float]]:
    for j, window in enumerate(windows):
        yield f"windows/{j}", *window.ends_of(1)
    for j, point in enumerate(points):
        yield f"points/{j}", *ends(point.velocity)
