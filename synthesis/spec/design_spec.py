"""DesignSpec: what is asked. It is the request body, and nothing maps it to something else."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from itertools import accumulate
from types import MappingProxyType
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.fields import (
    CamRotation,
    CamSpeed,
    Dimension,
    FiniteModel,
    HubDiameter,
    Keyway,
    Name,
    Range,
    ShaftDiameter,
    ends,
    named_lengths,
)
from synthesis.catalogue.followers import AnyFollower
from synthesis.catalogue.followers.closures import Closure
from synthesis.catalogue.forces import AnyLoad
from synthesis.catalogue.hub import hub_diameter
from synthesis.catalogue.limits import AnyLimit, Limit, Machine
from synthesis.catalogue.limits.radii import CounterBaseRadius, ProfileRadius
from synthesis.catalogue.motion import PlacedSegment, Segments
from synthesis.catalogue.objectives import AnyObjective
from synthesis.spec.assumed_objective import assumed_objectives
from synthesis.spec.body import CamBody
from synthesis.spec.free_parameters import FreeParameters, ProgramAndFollower
from synthesis.spec.program import Segment
from synthesis.spec.schedule import angles_of, check_closed, check_turn, check_units, placed
from synthesis.spec.shaft import check_shaft
from synthesis.spec.well_posedness import (
    check_growth_ends,
    check_jerk_finite,
    check_shrinking_ends,
    check_size_ratio,
)
from synthesis.units import MotionUnits, rad_per_s

MAX_SEGMENTS = 100  # of a program
SMALLEST = 1e-3  # strokes: where the search begins if a base radius is open below
FARTHEST = 1e4  # lengths of the spec: where the search ends if a base radius is open above
ROUGHEST = 2  # smoothness of the splines that smoother ones are compared with
RADII = ("base_radius_mm", "shaft_diameter_mm", "hub_diameter_mm")  # what bounds the base radius
DERIVED: Mapping[str, frozenset[str]] = MappingProxyType({
    "free_parameters": frozenset({"program", "follower", "speed_rpm", *RADII}),
    "_numbered": frozenset({"program"}),
    "_machine": frozenset({"follower", "speed_rpm", "load"}),
    "_reach": frozenset({"program", "follower", "speed_rpm"}),
    "_placed": frozenset({"program", "follower", "speed_rpm", "continuity"}),
    "_limits": frozenset({"program", "follower", "limits", *RADII}),
    "_assumed": frozenset({"program", "follower", "limits", "speed_rpm", "continuity"}),
    "_radii": frozenset({"program", "follower", "limits", "speed_rpm", *RADII}),
})  # fmt: skip
"""What a spec computes once, and the fields that this follows from, if no segment is open."""


class DesignSpec(FiniteModel):
    """What the follower must do, which follower it is, and what may not be exceeded."""

    name: Name = Field("", description="Shown in reports and files.")
    speed_rpm: CamSpeed = 60.0
    rotation: CamRotation = "ccw"
    program: list[Segment] = Field(
        min_length=1,
        max_length=MAX_SEGMENTS,
        description="Segments in order; their angles sum to 360° and the lifts cancel.",
    )
    follower: AnyFollower = Field(description="The follower that the machine has.")
    base_radius_mm: Dimension = None
    shaft_diameter_mm: ShaftDiameter = None
    hub_diameter_mm: HubDiameter = None
    keyway: Keyway = False
    load: AnyLoad | None = Field(
        None,
        description="What loads the follower, rigid: mass, damping, spring, process force. "
        "Left out, forces are not looked at.",
    )
    body: CamBody | None = Field(
        None, description="The cam as a plate, for its mass; nothing is designed by it."
    )
    limits: list[AnyLimit] = Field([], max_length=50, description="What may not be exceeded.")
    continuity: Literal[0, 1, 2, 3, 4] | None = Field(
        None,
        description="How many derivatives of the displacement may jump nowhere on the turn. "
        "Splines are made that smooth; where named laws jump the design is infeasible and "
        "the extreme says by how much and where. Left out: jumps of named laws are reported.",
    )
    objective: (
        AnyObjective | Annotated[list[AnyObjective], Field(min_length=1, max_length=10)] | None
    ) = Field(
        None,
        description="What to make small; a list is worked through in order: each is made as "
        "small as the ones before allow when they may lose half of the tolerance, or their "
        "`allowance`. Left out: where a law is free and no limit speaks of acceleration or jerk, "
        "[rms_jerk with an allowance of 0.25, base_radius], since the smallest cam alone is rough "
        "without end; else base_radius. `assumptions` of the answer says so.",
    )
    tolerance: float = Field(
        1e-3,
        ge=1e-6,
        le=1.0,
        description="Relative gap to the best possible that is good enough: it buys time.",
    )
    proof: Literal["auto", "quick", "thorough"] = Field(
        "auto",
        description="quick: where curvature binds, the bound is that of the question without it. "
        "thorough: a far smaller gap, for half a second to some ten seconds more; where nothing "
        "fits, values that suffice and values that are impossible come nearer to each other. "
        "auto: quick and, while the gap is above the tolerance, thorough for three to six seconds, "
        "counted in programs solved so that machines agree; with `time_budget_s`, for half of "
        "that time. Default in the base of a sweep: quick.",
    )
    report_smoothness_cost: bool = Field(
        False,
        description="Also design the cam with splines of class C2 and say what smoother ones "
        "cost. Takes about as long again.",
    )
    time_budget_s: float | None = Field(
        None, gt=0.0, le=3600.0, description="Stop after this long with the best so far."
    )

    @model_validator(mode="after")
    def _make_sense(self) -> DesignSpec:
        # Each check may rely on those before it.
        unit, kind = self.follower.travel.unit, self.follower.kind
        moves = {"mm": "slides", "deg": "swings"}[unit]
        check_units(self.program, self.limits, unit, f"the {kind} follower {moves}")
        self._check_parameters()
        self._check_closure()
        segments = self.placed_segments()
        check_size_ratio(self.follower, self.requested_radii(), self.stroke())
        self._check_base_radius()
        self.free_parameters.check_reach(lambda values: self._with(values).check_reach())
        self._check_limits(segments)
        named = [(getattr(limit, "place", limit.kind), limit) for limit in self.all_limits()]
        check_jerk_finite(segments, named, self.objectives(), self.machine())
        requested, searched = self.requested_radii(), self.searched_radii()
        reached, aims = self.base_radius_range(), self.objectives()
        check_growth_ends(self.follower, self.limits, aims, requested, searched, reached)
        if self.objective is None or aims[0].kind == "base_radius":
            free = any(segment.law_is_free for segment in segments)
            check_shrinking_ends(self.follower, self.limits, requested, law_is_free=free)
        return self

    def _check_parameters(self) -> None:
        """Refuse numbers that are free in name only, or that cannot fit together."""
        searched = self.free_parameters
        free = searched.parameters
        for name, what in (("angle_deg", "angles"), ("lift_mm", "lifts"), ("lift_deg", "lifts")):
            alone = [parameter for parameter in free if parameter.name == name]
            if len(alone) == 1 and not searched.tied_otherwise(name):
                raise PydanticCustomError(
                    "one_number_free",
                    "{field} is the only one of the {what} that is free: it follows from the "
                    "others. Give the number, or leave another one free too.",
                    {"field": alone[0].field, "what": what,
                     "segment": alone[0].segment, "name": name},
                )  # fmt: skip
        if len(free) > len(searched.machine_indices) and searched.polytope.centre() is None:
            raise PydanticCustomError(
                "numbers_do_not_fit",
                "However the free angles and lifts of program are chosen within their ranges, "
                "the angles do not sum to 360° or the lifts not to zero. Widen a range.",
            )

    def _check_closure(self) -> None:
        """Refuse a program that does not go round once, or does not end where it began."""
        check_turn(self._numbered, self.limits)
        check_closed(math.fsum(self.lifts()), self.stroke(), self._motion_units(), self._numbered)

    def _check_base_radius(self) -> None:
        least, largest = ends(self.base_radius_mm)
        if largest <= 0.0 or (least == largest and least <= 0.0):
            raise PydanticCustomError(
                "base_radius_positive",
                "base_radius_mm = {value} leaves no positive base radius. Give a positive one.",
                {"value": largest},
            )
        follower = self.follower.without_free_counter()
        check_shaft(follower, self.shaft_diameter_mm, self.hub, largest, keyway=self.keyway)

    def _check_limits(self, segments: Segments) -> None:
        """Refuse limits and a load that do not suit the follower, its motion, or each other."""
        for position, limit in enumerate(self.limits):
            if not limit.applies_to(self.follower):
                raise PydanticCustomError(
                    "limit_does_not_suit",
                    "limits/{position} is {limit}, which says nothing about a {kind} follower. "
                    "Remove it, or choose another follower.",
                    {"position": position, "limit": limit.kind, "kind": self.follower.kind},
                )
        if self.load is not None:
            self.load.check_against(self.follower, segments)
        for position, one in enumerate([*self.limits, *self.objectives()]):
            one.check(segments, self.machine(), position)

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """A copy, changed; it computes anew what follows from the changed fields."""
        changed = super().model_copy(update=update, deep=deep)
        everything = deep or any(segment.open for segment in self.program)
        for name, fields in DERIVED.items():
            if everything or not fields.isdisjoint(update or ()):
                vars(changed).pop(name, None)
        return changed

    @cached_property
    def free_parameters(self) -> FreeParameters:
        """The numbers that are left free and searched: angles, lifts, an arm's length."""
        omega, radii = rad_per_s(self.speed_rpm), self.requested_radii()
        return FreeParameters.of(self.program, self.follower, omega, radii)

    def with_values(self, values: Sequence[float]) -> DesignSpec:
        """The same spec with numbers in place of everything in ``free_parameters``."""
        return self._with(self.free_parameters.substitute(values))

    def _with(self, values: ProgramAndFollower) -> DesignSpec:
        program, follower = values
        pairs = zip(program, self.program, strict=True)
        if follower is self.follower and all(new is old for new, old in pairs):
            return self
        return self.model_copy(update={"program": program, "follower": follower})

    @cached_property
    def _numbered(self) -> list[Segment]:
        """The program; while numbers are left free, with some that fit together."""
        if not any(segment.open for segment in self.program):
            return self.program
        free = self.free_parameters
        middle = free.polytope.centre() if free.parameters else None
        return self.program if middle is None else free.at_point(middle)[0]

    def check_reach(self) -> None:
        """Refuse dimensions of the follower that no size can serve."""
        self.follower.check_dimensions(self.searched_radii(), self.placed_segments())

    def with_c2_splines(self) -> DesignSpec:
        """The same question for splines of class C2; its own self where none is smoother."""
        program = [segment.with_c2_splines() for segment in self.program]
        continuity = None if self.continuity is None else min(self.continuity, ROUGHEST)
        if program == self.program and continuity == self.continuity:
            return self
        changes = {"program": program, "continuity": continuity, "report_smoothness_cost": False}
        return self.model_copy(update=changes)

    def machine(self) -> Machine:
        """The follower, the cam's speed, and what loads the follower."""
        return self._machine

    @cached_property
    def _machine(self) -> Machine:
        omega, load = rad_per_s(self.speed_rpm), self.load
        reduced = None if load is None else load.reduced(self.follower, omega)
        return Machine(self.follower, omega, reduced)

    def _motion_units(self) -> MotionUnits:
        """What turns the program's displacements and rates into the core's."""
        return MotionUnits(self.follower.travel, rad_per_s(self.speed_rpm))

    def lifts(self) -> list[float]:
        """Displacement gained over every segment [mm]."""
        units = self._motion_units()
        return [segment.gain(units) for segment in self._numbered]

    @cached_property
    def _reach(self) -> tuple[float, float, list[float]]:
        """Lowest and highest displacement, and those at the segments' starts, the first 0 [mm]."""
        units, program = self._motion_units(), self._numbered
        levels = list(accumulate((segment.gain(units) for segment in program[:-1]), initial=0.0))
        spans = [segment.span(units) for segment in program]
        both = [(at + low, at + high) for at, (low, high) in zip(levels, spans, strict=True)]
        return min(low for low, _ in both), max(high for _, high in both), levels

    def placed_segments(self) -> tuple[PlacedSegment, ...]:
        """The program placed on the cam, displacements measured from the lowest position."""
        return self._placed

    @cached_property
    def _placed(self) -> tuple[PlacedSegment, ...]:
        program, (lowest, _, levels) = self._numbered, self._reach
        starts, units = [level - lowest for level in levels], self._motion_units()
        return placed(program, angles_of(program), starts, units, self.continuity or 0)

    def stroke(self) -> float:
        """Highest less lowest displacement [mm]: the unit of length inside the formulations."""
        return self._reach[1] - self._reach[0]

    @property
    def hub(self) -> float | None:
        """Diameter of the hub that the base circle leaves room for [mm]: given, or by the rule."""
        if self.hub_diameter_mm is not None or self.shaft_diameter_mm is None:
            return self.hub_diameter_mm
        return hub_diameter(self.shaft_diameter_mm)

    def requested_radii(self) -> tuple[float, float]:
        """Least and largest base radius that are asked for [mm]; open ends are infinite."""
        (low, high), hub = ends(self.base_radius_mm), self.hub
        return low if hub is None else max(low, 0.5 * hub), high

    def base_radius_range(self) -> tuple[float, float]:
        """Least and largest base radius that the question and its follower allow [mm].

        An open lower end is at 0, which no cam reaches: bounds hold over all that lies above. An
        open upper end is at ``FARTHEST`` times the longest length that the spec names. What is
        claimed of all cams does not rest on it: ``Problem.open_above`` says where it might.
        """
        return self.follower.feasible_base_radii(self._radii, self.stroke())

    def searched_radii(self, smallest: float = SMALLEST) -> tuple[float, float]:
        """Smallest and largest base radius at which cams are sought [mm].

        An open lower end is at ``smallest`` strokes: an end of our own, on which no bound rests.
        """
        least, largest = self._radii
        return least or min(smallest * self.stroke(), 0.5 * largest), largest

    @cached_property
    def _radii(self) -> tuple[float, float]:
        least, largest = self.requested_radii()
        least = max(least, 0.0)
        if math.isfinite(largest):
            return least, largest
        named = named_lengths(self.follower, *self.limits)
        lengths = (abs(end) for _, *both in named for end in both if math.isfinite(end))
        return least, FARTHEST * max(self.stroke(), least, *lengths)

    def all_limits(self) -> tuple[Limit, ...]:
        """The limits asked for, and what every cam must keep: no undercut, a counter cam's hub.

        Windows and points of the program come last.
        """
        return self._limits

    @cached_property
    def _limits(self) -> tuple[Limit, ...]:
        bounds = [b for i, segment in enumerate(self._numbered) for b in segment.segment_bounds(i)]
        named = {limit.kind for limit in self.limits}
        always = (ProfileRadius(), CounterBaseRadius(min_mm=0.5 * (self.hub or 0.0)))
        rest = (a for a in always if a.kind not in named and a.applies_to(self.follower))
        return (*self.limits, *rest, *bounds)

    def without_deferred(self) -> DesignSpec:
        """The same without what is chosen after the size and is still free."""
        return self._with_closure(self.follower.closure.without_free_counter())

    def with_deferred(self, dimensions: Mapping[str, float]) -> DesignSpec:
        """The same with what was chosen after the size, by the names of the dimensions."""
        return self._with_closure(self.follower.closure.with_counter(dimensions))

    def _with_closure(self, closure: Closure) -> DesignSpec:
        follower = self.follower.with_closure(closure)
        return self if follower == self.follower else self.model_copy(update={"follower": follower})

    def left_free(self) -> Iterator[tuple[str, Any]]:
        """JSON pointer and value of everything that the answer would have to choose."""
        for parameter in self.free_parameters.parameters:
            low, high = ends(parameter.requested)
            yield f"/{parameter.field}", {"min": low, "max": high}
        for segment in self.placed_segments():
            if segment.law_is_free:
                yield f"/program/{segment.index}/law", self.program[segment.index].law_name
        if self.load is not None:
            for name, (low, high) in self.load.free_spring.items():
                yield f"/load/spring/{name}", {"min": low, "max": high}
        # What the size variables determine, if they have a choice, and what is chosen after them.
        deferred = self.follower.closure.counter_dimensions().items()
        sized = {f"/follower/{field}": value for field, (_, value) in deferred}
        bounds = self.follower.size_domain(self.base_radius_range()).bounds
        if any(low != high for low, high in bounds):
            dimensions = self.follower.adjustable_dimensions().items()
            own = {f"/follower/{field}": value for field, value in dimensions}
            sized = {"/base_radius_mm": self.base_radius_mm, **own, **sized}
        for field, value in sized.items():
            low, high = ends(value)
            if low != high:
                yield field, value.model_dump() if isinstance(value, Range) else value

    def objectives(self) -> tuple[AnyObjective, ...]:
        """The objectives in order; where none is named, those assumed."""
        if self.objective is None:
            return self._assumed
        return tuple(self.objective) if isinstance(self.objective, list) else (self.objective,)

    def main_objective(self) -> AnyObjective:
        """What answers speak of first: the first one; where none is named, the base radius."""
        return self.objectives()[-1 if self.objective is None else 0]

    @cached_property
    def _assumed(self) -> tuple[AnyObjective, ...]:
        return assumed_objectives(self.placed_segments(), self.all_limits())
