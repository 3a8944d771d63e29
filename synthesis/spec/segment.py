"""What every segment of a motion program promises, and the states at its ends."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field
from pydantic_core import PydanticCustomError

from synthesis.catalogue.limits.segment_bound import SegmentBound
from synthesis.catalogue.motion import ANY_STATE, EndState, PlacedSegment
from synthesis.catalogue.ranges import AngleRange, Range, ends
from synthesis.units import CORE_UNITS, MotionUnits

TravelUnit = Literal["mm", "deg"]


def signed(description: str, largest: float) -> object:
    """An optional number of either sign."""
    return Field(ge=-largest, le=largest, description=description)


class State(BaseModel):
    """The motion asked for at one end of a segment; what is left out is the neighbour's.

    Signs are those of the motion: a return runs at negative velocity. VDI 2143 names the states:
    R rests (velocity and acceleration 0), G runs at constant velocity (acceleration 0), U turns
    back (velocity 0), B moves.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    velocity_mm_per_s: Annotated[
        float | None, signed("Velocity there, with its sign [mm/s].", 1e12)
    ] = None
    velocity_deg_per_s: Annotated[
        float | None, signed("The same of a follower on an arm [deg/s].", 1e12)
    ] = None
    acceleration_mm_per_s2: Annotated[
        float | None, signed("Acceleration there, with its sign [mm/s²].", 1e18)
    ] = None
    acceleration_deg_per_s2: Annotated[
        float | None, signed("The same of a follower on an arm [deg/s²].", 1e18)
    ] = None

    def _given(self) -> tuple[dict[TravelUnit, float | None], dict[TravelUnit, float | None]]:
        """Velocity and acceleration by unit."""
        return (
            {"mm": self.velocity_mm_per_s, "deg": self.velocity_deg_per_s},
            {"mm": self.acceleration_mm_per_s2, "deg": self.acceleration_deg_per_s2},
        )

    @property
    def units(self) -> frozenset[TravelUnit]:
        """Units that it is given in."""
        return frozenset(
            unit for row in self._given() for unit, value in row.items() if value is not None
        )

    def to_core(self, units: MotionUnits) -> EndState:
        """The state as s' and s''."""
        v, a = (row[units.travel.unit] for row in self._given())
        return EndState(
            None if v is None else units.to_core(v, 1), None if a is None else units.to_core(a, 2)
        )


def end_states(
    start: State | None, end: State | None, units: MotionUnits
) -> tuple[EndState, EndState]:
    """Both end states of a segment in the core's units; nothing asked where nothing is given."""
    first, last = (ANY_STATE if state is None else state.to_core(units) for state in (start, end))
    return first, last


def units_of(*states: State | None) -> frozenset[TravelUnit]:
    """Units of several states."""
    return frozenset(unit for state in states if state is not None for unit in state.units)


def one_unit(units: frozenset[TravelUnit], what: str) -> None:
    """Refuse a segment that mixes lengths and angles of the follower.

    Raises:
        PydanticCustomError: both are used.
    """
    if len(units) > 1:
        raise PydanticCustomError(
            "units_mixed",
            "the {what} gives displacements both in mm and in deg. "
            "Give all in mm for a follower that slides, or all in deg for one on an arm.",
            {"what": what},
        )


class Part(BaseModel):
    """One segment of the program."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    angle_deg: float | AngleRange

    @property
    def degrees(self) -> float:
        """Its cam angle [deg]; the smallest one while it is left free."""
        return ends(self.angle_deg)[0]

    def with_c2_splines(self) -> Self:
        """The same with a law that is part of the answer no smoother than C2."""
        return self

    def with_unit_fields(self) -> Self:
        """The same with every number in a field whose name tells its unit."""
        return self

    def free_fields(self) -> dict[str, float | Range]:
        """Fields that may be left free, with what is asked of them."""
        return {"angle_deg": self.angle_deg}

    @property
    def open(self) -> bool:
        """Whether a field is left free."""
        return any(low != high for low, high in map(ends, self.free_fields().values()))

    @property
    def signed_lift(self) -> float:
        """Displacement gained over the segment, in its own unit; the smallest while it is free."""
        return 0.0

    @property
    def units(self) -> frozenset[TravelUnit]:
        """Units of the follower's displacement that it uses: mm, deg, or none."""
        return frozenset()

    @property
    def law_name(self) -> str:
        """Name of the law on the wire."""
        raise NotImplementedError

    @property
    def matched_derivatives(self) -> int:
        """How many derivatives its law takes over from its neighbours at each end."""
        return 0

    @property
    def may_reverse(self) -> bool:
        """Whether it may move backwards."""
        return False

    def gain(self, units: MotionUnits) -> float:
        """Displacement gained over the segment [mm of the core]."""
        return units.to_core(self.signed_lift)

    def span(self, units: MotionUnits) -> tuple[float, float]:
        """Lowest and highest displacement on the segment, from its start [mm of the core]."""
        gain = self.gain(units)
        return min(gain, 0.0), max(gain, 0.0)

    def place(
        self,
        index: int,
        start: float,
        angle: float,
        s_start: float,
        units: MotionUnits = CORE_UNITS,
    ) -> PlacedSegment:
        """The segment placed on the cam (rad, mm of the core), neighbours unheard."""
        raise NotImplementedError

    def with_end_states(
        self, placed: PlacedSegment, start: EndState, end: EndState
    ) -> PlacedSegment:
        """The placed segment with its law run between these states."""
        return placed

    def segment_bounds(self, index: int) -> tuple[SegmentBound, ...]:
        """What its windows and points ask for, as bounds that the segment has to keep."""
        return ()
