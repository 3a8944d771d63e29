"""The problem as the formulations see it: motion still partly free, size free, one objective."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf, isfinite
from typing import Literal

from synthesis.catalogue.constraints import (
    LinearInequality,
    NonconvexConstraint,
    NormBounds,
    SizeDomain,
    VibrationBound,
    max_enlargement,
)
from synthesis.catalogue.fields import ends
from synthesis.catalogue.followers import Follower
from synthesis.catalogue.followers.base import base_gap
from synthesis.catalogue.limits import Limit, Machine
from synthesis.catalogue.motion import PlacedSegment
from synthesis.catalogue.objectives import Objective
from synthesis.optimise.problem.residual_vibration import amplitude
from synthesis.spec.design_spec import SMALLEST, DesignSpec

Place = tuple[object, ...]
QUIET = 1e-9  # of the stroke: an amplitude that is none
SMALL = 1e-3  # share of a norm: excesses are relative to no smaller a radius, for rounding's sake
RESTS = 1e-9  # of the stroke: what the lifts may miss to the lowest position, as in a spec


class NoObjective(Objective):
    """No objective: only whether the limits can hold."""

    kind: Literal["nothing"] = "nothing"

    def to_wire(self, value: float, machine: Machine) -> float:
        return value

    def from_wire(self, value: float, machine: Machine) -> float:
        return value


@dataclass(frozen=True)
class ObjectiveCap:
    """An earlier objective of an ordered list, and the value it may not exceed [problem units]."""

    objective: Objective
    value: float

    def limits(self, machine: Machine) -> tuple[Limit, ...]:
        """What says so where no row does."""
        return self.objective.equivalent_limits(self.value, machine)

    def excess(self, size: tuple[float, ...], machine: Machine) -> float:
        """By how much a size exceeds the cap, over the capped value [wire]; −inf: no size does.

        A small base radius on a large roller is a small part of the norm that the cap speaks of.
        """
        norm = self.objective.norm(machine)
        if norm is None:
            return -inf
        radius = self.objective.to_wire(self.value, machine)
        return (norm.value(size) - self.value) / max(min(radius, self.value), SMALL * self.value)


@dataclass(frozen=True, eq=False)
class Problem:
    """One objective under all limits.

    Attributes:
        segments: the program on the cam; those without a law are free. Zero angles are left out.
        machine: follower and speed. sizing: where the size variables may lie.
        length: unit of length inside the formulations: the stroke [length].
        objective_caps: earlier objectives.
        base_radius_range: least and largest base radius [length], which the sizing comes from.
        smallest_sought: base radius [length] from which on cams are sought. Larger than the least
            one where that end is open: bounds do not rest on it.
        open_above: whether the largest of these is an end of the search alone, and no limit of its
            own nor an earlier objective bounds the size: the question has larger cams too.
        for_every_size: whether bounds hold for any size at all: it is open above, and the objective
            speaks of the motion alone, so that the largest size searched is no end of the question.
        least_base_circle: least radius of a dwell on the base circle (``_least_base_circle``).
    """

    segments: tuple[PlacedSegment, ...]
    machine: Machine
    limits: tuple[Limit, ...]
    sizing: SizeDomain
    objective: Objective
    length: float
    objective_caps: tuple[ObjectiveCap, ...] = ()
    base_radius_range: tuple[float, float] = (0.0, inf)
    smallest_sought: float = 0.0
    open_above: bool = False
    for_every_size: bool = False
    least_base_circle: float = 0.0
    _rows: dict[PlacedSegment, tuple[LinearInequality, ...]] = field(
        default_factory=dict, init=False, repr=False
    )
    _curved_limits: dict[PlacedSegment, tuple[NonconvexConstraint, ...]] = field(
        default_factory=dict, init=False, repr=False
    )

    @property
    def base_circle_conflict(self) -> str:
        """Why no cam at all can be large enough for its base circle; empty where one may be."""
        largest = self.base_radius_range[1]
        if self.least_base_circle <= largest * (1.0 + 1e-9):
            return ""
        return (
            "proven for every motion law: a dwell below is a part of the base circle, whose "
            f"radius may be {largest:.6g} mm at most; a profile radius of "
            f"{self.least_base_circle:.6g} mm is asked for"
        )

    @property
    def constant_conflict(self) -> str:
        """Which limit no law and no size can keep, its rows being constant; empty where none is."""
        for limit in self.limits:
            for segment in self.segments:
                for row in limit.rows(segment, self.machine):
                    if row.is_constant and row.upper < 0.0:
                        name = row.source.replace("_", " ")
                        return f"proven: {name} is exceeded whatever law and size"
        return ""

    @cached_property
    def free(self) -> tuple[PlacedSegment, ...]:
        """The segments whose law is part of the answer."""
        return tuple(s for s in self.segments if s.law is None)

    def rows_on(self, segment: PlacedSegment, level: float) -> Iterator[LinearInequality]:
        """Every row on one segment: of limits, of objectives held, of the objective at a level."""
        yield from self.limit_rows(segment)
        yield from self.objective.rows(segment, self.machine, level)

    def limit_rows(self, segment: PlacedSegment) -> tuple[LinearInequality, ...]:
        """The rows on one segment that do not speak of the objective at hand.

        Constant ones leave nothing to choose: whether they hold is the certificate's business.
        A limit says them of a place in the program, whatever the law there: they are made once.
        """
        if segment not in self._rows:
            every = (row for limit in self.limits for row in limit.rows(segment, self.machine))
            rows = [row for row in every if not row.is_constant]
            for earlier in self.objective_caps:
                value = 0.0 if earlier.objective.quasiconvex else earlier.value
                rows += [
                    replace(row, upper=row.upper - row.level * value, level=0.0)
                    for row in earlier.objective.rows(segment, self.machine, earlier.value)
                ]
            self._rows[segment] = tuple(rows)
        return self._rows[segment]

    def curved_limits_on(self, segment: PlacedSegment) -> tuple[NonconvexConstraint, ...]:
        """What limits say on one segment that no fixed row does: made once, as their rows."""
        if segment not in self._curved_limits:
            each = (limit.nonconvex(segment, self.machine) for limit in self.limits)
            self._curved_limits[segment] = tuple(curve for curves in each for curve in curves)
        return self._curved_limits[segment]

    @cached_property
    def has_curved_limits(self) -> bool:
        """Whether any limit says such a thing."""
        return any(self.curved_limits_on(segment) for segment in self.segments)

    @cached_property
    def omits_curved_rows(self) -> bool:
        """Whether curved limits on free laws are left out of cone programs: no rows are known."""
        return any(
            not curve.linearises
            for segment in self.free
            for curve in self.curved_limits_on(segment)
        )

    @property
    def holds_size(self) -> bool:
        """Whether an earlier objective leaves the size next to no room, so that no cam may grow."""
        return any(cap.objective.norm(self.machine) is not None for cap in self.objective_caps)

    @cached_property
    def norm_bounds(self) -> tuple[NormBounds, ...]:
        """Every cone on the size: of the sizing and of limits."""
        result = list(self.sizing.norm_bounds)
        for limit in self.limits:
            result += limit.norm_bounds(self.segments, self.machine)
        return tuple(result)

    @cached_property
    def least_norms(self) -> tuple[NormBounds, ...]:
        """The bounds of norms of the size from below, which are not convex, each once."""
        curved = (curve for s in self.segments for curve in self.curved_limits_on(s))
        every = (*self.norm_bounds, *(norm for curve in curved for norm in curve.norm_bounds))
        return tuple(dict.fromkeys(norm for norm in every if norm.lower > 0.0))

    @cached_property
    def vibration_limits(self) -> tuple[VibrationBound, ...]:
        """The limits on residual vibration."""
        vibrations = (limit.vibration_bounds(self.segments, self.machine) for limit in self.limits)
        return tuple(vibration for each in vibrations for vibration in each)

    @property
    def without_vibration(self) -> Problem:
        """The problem without limits on residual vibration: a relaxation of this one."""
        kept = (one for one in self.limits if not one.vibration_bounds(self.segments, self.machine))
        return replace(self, limits=tuple(kept))

    @cached_property
    def vibration_excess(self) -> float:
        """By how much runs whose laws are all given ring too much, over the stroke; 0: nowhere."""
        given = {s.index for s in self.segments if s.law is not None}
        beyond = (
            amplitude(vibration, self.segments) - vibration.max_amplitude
            for vibration in self.vibration_limits
            if given.issuperset(vibration.run)
        )
        worst = max(beyond, default=0.0) / self.length
        return worst if worst > QUIET else 0.0

    @cached_property
    def least_norm(self) -> float:
        """A norm of the size (``radius_norm``) that no cam of the question lies below."""
        norm = self.machine.follower.radius_norm()
        return max(norm.lower_bound(self.sizing.bounds), self.sizing.min_norm)

    @cached_property
    def searched_norm(self) -> float:
        """The norm of the size from which on cams are sought."""
        if self.smallest_sought == 0.0:
            return self.sizing.min_norm
        sought = max(self.smallest_sought, self.base_radius_range[0]), self.base_radius_range[1]
        return max(self.machine.follower.searched_norm(sought), self.sizing.min_norm)

    @property
    def is_open_below(self) -> bool:
        """Whether sizes below those sought are allowed."""
        return self.searched_norm > self.least_norm

    def is_smallest_sought(self, size: tuple[float, ...], near: float) -> bool:
        """Whether a size is the least that is sought.

        ``near``: relative distance of its norm that counts as none.
        """
        norm = self.machine.follower.radius_norm()
        return norm.value(size) <= self.searched_norm * (1.0 + near)

    def max_enlargement(self, size: tuple[float, ...]) -> float:
        """How far a size can be raised within bounds and cones [length]."""
        return max_enlargement(size, self.sizing.bounds, self.norm_bounds)

    def with_follower(self, follower: Follower) -> Problem:
        """The same problem put to a follower with more dimensions given."""
        machine = replace(self.machine, follower=follower)
        return replace(self, machine=machine, sizing=follower.size_domain(self.base_radius_range))

    def with_laws(self, segments: Sequence[PlacedSegment]) -> Problem:
        """The same problem with these segments in place of the free ones."""
        by_index = {s.index: s for s in segments}
        result = replace(self, segments=tuple(by_index.get(s.index, s) for s in self.segments))
        result._rows.update(self._rows)
        result._curved_limits.update(self._curved_limits)
        for free in self.free:
            law = by_index.get(free.index, free)
            if _place(law) == _place(free):  # limits say the same there, whatever the law
                result._rows[law], result._curved_limits[law] = (
                    self.limit_rows(free),
                    self.curved_limits_on(free),
                )
        return result


def _place(segment: PlacedSegment) -> Place:
    """What of a segment limits may speak of: all but its law."""
    s = segment
    return s.index, s.kind, s.start, s.angle, s.s_start, s.s_end, s.free


def formulate_problem(
    spec: DesignSpec,
    objective: Objective,
    held: tuple[ObjectiveCap, ...] = (),
    segments: Sequence[PlacedSegment] | None = None,
    smallest: float = SMALLEST,
) -> Problem:
    """The spec as a problem with one objective.

    Args:
        spec: what is asked. objective: which of its objectives. held: those before it.
        segments: its own with tables smoothed; None: as they are.
        smallest: base radius from which on cams are sought where it is open below [strokes].
    """
    placed, machine = spec.placed_segments() if segments is None else segments, spec.machine()
    radii = spec.base_radius_range()
    unheld = all(earlier.objective.norm(machine) is None for earlier in held)
    open_above = unheld and _is_open_above(spec, placed)
    return Problem(
        tuple(s for s in placed if s.angle > 0.0),
        machine,
        (*spec.all_limits(), *(limit for earlier in held for limit in earlier.limits(machine))),
        spec.follower.size_domain(radii),
        objective,
        spec.stroke(),
        held,
        radii,
        spec.searched_radii(smallest)[0],
        open_above,
        open_above and objective.norm(machine) is None,
        _least_base_circle(spec, placed),
    )


def _is_open_above(spec: DesignSpec, segments: Sequence[PlacedSegment]) -> bool:
    """Whether the cam may be larger than any that is searched, by the spec and its follower."""
    if isfinite(ends(spec.base_radius_mm)[1]):
        return False
    if spec.base_radius_range()[1] < spec.searched_radii()[1]:
        return False  # the follower reaches no farther
    return not any(
        limit.norm_bounds(tuple(segments), spec.machine()) for limit in spec.all_limits()
    )


def _least_base_circle(spec: DesignSpec, segments: Sequence[PlacedSegment]) -> float:
    """Least base radius that a dwell at the lowest position needs, a part of the base circle."""
    circle = max((limit.min_circle_radius for limit in spec.limits), default=0.0)
    if circle == 0.0 or base_gap(spec.follower) < 0.0:
        return 0.0
    lowest = RESTS * spec.stroke()
    resting = any(s.kind == "dwell" and s.angle > 0.0 and s.s_start <= lowest for s in segments)
    return circle if resting else 0.0


def with_smoother_laws(problem: Problem) -> Problem:
    """The same, free laws as smooth inside as the best ones, where a mean square is made small.

    Where nothing caps the derivative whose mean square is the first objective, and no window or
    point bends the law, that derivative is continuous on the best law. Splines of that class come
    near it with the fourth power of the knots' distance, those of one class less with the square.
    They join their neighbours as they were asked to.
    """
    first = problem.objective_caps[0].objective if problem.objective_caps else problem.objective
    order = first.energy_order()
    bent = any(segment.free is not None and segment.free.knots for segment in problem.free)
    if order is None or bent:
        return problem
    for segment in problem.free:
        rows = (row for limit in problem.limits for row in limit.rows(segment, problem.machine))
        if any(row.coefficients[order] != 0.0 for row in rows):
            return problem
    return replace(problem, segments=tuple(with_smoothness(s, order) for s in problem.segments))


def with_smoothness(segment: PlacedSegment, order: int) -> PlacedSegment:
    """A free law of class C^order at least inside, as smooth as asked at its ends."""
    law = segment.free
    if law is None or segment.law is not None or law.smoothness >= order:
        return segment
    joins = law.continuity_at(at_start=True), law.continuity_at(at_start=False)
    return replace(segment, free=replace(law, smoothness=order, end_continuity=joins))
