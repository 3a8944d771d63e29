"""What every segment of a motion program has in common, and the states at its ends."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Self

from pydantic import Field

from synthesis.catalogue.fields import AngleRange, Range, UnitFields, ends
from synthesis.catalogue.laws import AnyLaw
from synthesis.catalogue.limits.motion import SegmentBound
from synthesis.catalogue.motion import ANY_STATE, EndState, PlacedSegment, SegmentKind
from synthesis.units import MotionUnits


def signed(description: str, largest: float) -> Any:
    """An optional number of either sign."""
    return Field(None, ge=-largest, le=largest, description=description)


class State(UnitFields):
    """The motion asked for at one end of a segment; what is left out is the neighbour's.

    Signs are those of the motion: a return runs at negative velocity. VDI 2143 names the states:
    R rests (velocity and acceleration 0), G runs at constant velocity (acceleration 0), U turns
    back (velocity 0), B moves.
    """

    velocity_mm_per_s: float | None = signed("Velocity there, with its sign [mm/s].", 1e12)
    velocity_deg_per_s: float | None = signed("The same of a follower on an arm [deg/s].", 1e12)
    acceleration_mm_per_s2: float | None = signed(
        "Acceleration there, with its sign [mm/s²].", 1e18
    )
    acceleration_deg_per_s2: float | None = signed(
        "The same of a follower on an arm [deg/s²].", 1e18
    )

    def to_core(self, units: MotionUnits) -> EndState:
        """The state as s' and s''."""
        given = self.given("velocity"), self.given("acceleration")
        return EndState(*(v if v is None else units.to_core(v, k) for k, v in enumerate(given, 1)))


def with_states(
    placed: PlacedSegment, start: State | None, end: State | None, units: MotionUnits
) -> PlacedSegment:
    """A placed segment with the states required at its ends."""
    if start is end is None:
        return placed
    first, last = (ANY_STATE if state is None else state.to_core(units) for state in (start, end))
    return replace(placed, start_state=first, end_state=last)


class SegmentSpec(UnitFields):
    """One segment of the program."""

    if TYPE_CHECKING:
        kind: str

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
    def own_law(self) -> AnyLaw | None:
        """The motion law that it names, if it names one."""
        return None

    @property
    def law_name(self) -> str:
        """Name of the law on the wire."""
        return self.kind if self.own_law is None else self.own_law.kind

    def gain(self, units: MotionUnits) -> float:
        """Displacement gained over the segment [mm of the core]."""
        return units.to_core(self.signed_lift)

    def span(self, units: MotionUnits) -> tuple[float, float]:
        """Lowest and highest displacement on the segment, from its start [mm of the core]."""
        gain = self.gain(units)
        return min(gain, 0.0), max(gain, 0.0)

    def place(
        self, index: int, start: float, angle: float, s_start: float, units: MotionUnits
    ) -> PlacedSegment:
        """The segment placed on the cam (rad, mm of the core), without regard to its neighbours."""
        gain = self.gain(units)
        kind: SegmentKind = "rise" if gain > 0.0 else "return" if gain < 0.0 else "dwell"
        bare = PlacedSegment(index, kind, start, angle, s_start, s_start + gain, None)
        return self.with_motion(bare, units)

    def with_motion(self, placed: PlacedSegment, units: MotionUnits) -> PlacedSegment:
        """A placed segment with its law, or with what a law that is chosen must satisfy."""
        raise NotImplementedError

    def with_end_states(
        self, placed: PlacedSegment, start: EndState, end: EndState
    ) -> PlacedSegment:
        """The placed segment with its law run between these states."""
        return placed

    def segment_bounds(self, index: int) -> tuple[SegmentBound, ...]:
        """What its windows and points ask for, as bounds that the segment has to keep."""
        return ()
