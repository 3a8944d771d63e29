"""What a move has to keep on the way: windows with bounds, and points to pass through."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.limits.demand import FIELDS, TRAVEL, Demand
from synthesis.ranges import Range, ends

SHORTEST = 1e-3  # of the segment: knots may not lie closer
MOST = 50
Degrees = Annotated[float, Field(ge=0.0, le=360.0)]
Bounds = float | Range | None


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Window(_Part):
    """Bounds that hold on a part of the segment; a number in place of a range holds the value."""

    from_deg: Annotated[Degrees, Field(description="Where it begins, from the segment's start.")]
    to_deg: Annotated[Degrees, Field(description="Where it ends, from the segment's start.")]
    travel_mm: Bounds = Field(
        None, description="Distance moved since the segment's start, positive in its own sense."
    )
    velocity_mm_per_s: Bounds = Field(
        None, description="Velocity, negative where the follower returns."
    )
    acceleration_mm_per_s2: Bounds = Field(None, description="Acceleration, signed.")
    jerk_mm_per_s3: Bounds = Field(None, description="Jerk, signed.")

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
                {"fields": ", ".join(FIELDS)},
            )
        return self

    def bounds(self) -> Iterator[tuple[int, Bounds]]:
        """Order and value of everything that is bounded."""
        for order, name in enumerate(FIELDS):
            value: Bounds = getattr(self, name)
            if value is not None and ends(value) != ends(None):
                yield order, value

    def demands(self, common: dict[str, Any], part: tuple[float, float]) -> Iterator[Demand]:
        """One demand for every end of a range, or for a value."""
        for order, value in self.bounds():
            field = f"{common['field']}/{FIELDS[order]}"
            low, high = ends(value)
            base = {**common, "part": part, "order": order}
            if low == high:
                yield Demand(**{**base, "field": field, "min": low, "max": high})
                continue
            for side, end in (("min", low), ("max", high)):
                if abs(end) < float("inf"):
                    yield Demand(**{**base, "field": f"{field}/{side}", side: end})


class Point(_Part):
    """A point that the follower passes through."""

    angle_deg: Annotated[Degrees, Field(description="Where, from the segment's start.")]
    travel_mm: Annotated[
        float,
        Field(description="Distance moved since the segment's start, positive in its own sense."),
    ]
    tolerance_mm: Annotated[
        float, Field(ge=0.0, le=1e6, description="Deviation allowed either way; 0: exactly.")
    ] = 0.0
    velocity_mm_per_s: Annotated[
        float | None, Field(description="Velocity there, negative where the follower returns.")
    ] = None

    @property
    def nearest(self) -> float:
        """The least travel that passes [mm]."""
        return self.travel_mm - self.tolerance_mm

    @property
    def farthest(self) -> float:
        """The largest travel that passes [mm]."""
        return self.travel_mm + self.tolerance_mm

    def demands(self, common: dict[str, Any], x: float) -> Iterator[Demand]:
        """Its place, and its velocity if that is asked for."""
        name = "tolerance_mm" if self.tolerance_mm else FIELDS[TRAVEL]
        asked = [(TRAVEL, name, self.nearest, self.farthest)]
        if self.velocity_mm_per_s is not None:
            asked.append((1, FIELDS[1], self.velocity_mm_per_s, self.velocity_mm_per_s))
        for order, name, low, high in asked:
            field = f"{common['field']}/{name}"
            base = {**common, "field": field, "order": order, "part": (x, x)}
            yield Demand(**base, min=low, max=high)


def demands(
    segment: int, angle: float, windows: Sequence[Window], points: Sequence[Point]
) -> tuple[Demand, ...]:
    """All that the windows and points of one segment ask for.

    Args:
        segment: its index in the program. angle: its cam angle [deg].
        windows, points: its own.
    """
    found: list[Demand] = []
    for j, window in enumerate(windows):
        common = _common(segment, f"windows/{j}")
        found += window.demands(common, (window.from_deg / angle, min(window.to_deg / angle, 1.0)))
    for j, point in enumerate(points):
        found += point.demands(_common(segment, f"points/{j}"), point.angle_deg / angle)
    return tuple(found)


def _common(segment: int, place: str) -> dict[str, Any]:
    return {"segment": segment, "place": place, "field": f"program/{segment}/{place}"}


def knots(angle: float, windows: Sequence[Window], points: Sequence[Point]) -> tuple[float, ...]:
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
            bounds = dict(other.bounds())
            for order, value in first.bounds():
                (low, high), (least, most) = ends(value), ends(bounds.get(order))
                if low > most or least > high:
                    raise PydanticCustomError(
                        "windows_contradict",
                        "windows/{j} and windows/{k} overlap, and no {name} satisfies both. "
                        "Widen one of them, or shorten it.",
                        {"j": j, "k": k, "name": FIELDS[order]},
                    )


def check_stroke(
    lift: float, sense: float, windows: Sequence[Window], points: Sequence[Point]
) -> None:
    """Refuse what a law cannot keep that never moves backwards.

    Args:
        lift: of the segment [mm]. sense: 1 for a rise, −1 for a return.
        windows, points: its own.
    """
    for place, low, high in _travels(windows, points):
        if low > lift or high < 0.0:
            raise PydanticCustomError(
                "outside_stroke",
                "{place} asks for a travel from {low} to {high} mm, and the segment moves from 0 "
                "to {lift} mm. Correct it, or allow the law to overshoot.",
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
                "points/{k} comes after points/{j}, and lies {back} mm behind it. "
                "Correct one of them, or allow the law to overshoot.",
                {"back": points[j].travel_mm - points[k].travel_mm, "j": j, "k": k},
            )


def _travels(
    windows: Sequence[Window], points: Sequence[Point]
) -> Iterator[tuple[str, float, float]]:
    for j, window in enumerate(windows):
        yield f"windows/{j}", *ends(window.travel_mm)
    for j, point in enumerate(points):
        yield f"points/{j}", point.nearest, point.farthest


def _speeds(
    windows: Sequence[Window], points: Sequence[Point]
) -> Iterator[tuple[str, float, float]]:
    for j, window in enumerate(windows):
        yield f"windows/{j}", *ends(window.velocity_mm_per_s)
    for j, point in enumerate(points):
        yield f"points/{j}", *ends(point.velocity_mm_per_s)
