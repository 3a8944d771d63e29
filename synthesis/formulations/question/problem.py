"""The question as the formulations see it: motion still partly free, size free, one objective."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf
from typing import Literal

from synthesis.followers import Follower
from synthesis.followers.sizing import Sizing
from synthesis.formulations.question.ringing import amplitude, settles
from synthesis.limits import Limit, Machine
from synthesis.motion import Stretch
from synthesis.objectives import Objective
from synthesis.spec import DesignSpec
from synthesis.terms import Cone, Curved, Ringing, Row

Place = tuple[object, ...]
QUIET = 1e-9  # of the stroke: an amplitude that is none
RESTS = 1e-9  # of the stroke: what the lifts may miss to the lowest position, as in a spec


class Nothing(Objective):
    """No objective: only whether the limits can hold."""

    kind: Literal["nothing"] = "nothing"

    def to_wire(self, value: float, machine: Machine) -> float:
        return value

    def from_wire(self, value: float, machine: Machine) -> float:
        return value


@dataclass(frozen=True)
class Held:
    """An earlier objective of an ordered list, and the value it may not exceed [core units]."""

    objective: Objective
    value: float

    def limits(self, machine: Machine) -> tuple[Limit, ...]:
        """What says so where no row does."""
        return self.objective.limits(self.value, machine)


@dataclass(frozen=True, eq=False)
class Problem:
    """One objective under all limits.

    Attributes:
        stretches: the program on the cam; those without a law are free. Zero angles are left out.
        machine: follower and speed.
        limits: what may not be exceeded.
        sizing: where the size variables may lie.
        objective: what to make small.
        length: unit of length inside the formulations: the stroke [mm].
        held: earlier objectives.
        radii: smallest and largest base radius [mm], which the sizing comes from.
        circle: least base radius for a reason of its own [mm]: it bounds, and nothing more.
    """

    stretches: tuple[Stretch, ...]
    machine: Machine
    limits: tuple[Limit, ...]
    sizing: Sizing
    objective: Objective
    length: float
    held: tuple[Held, ...] = ()
    radii: tuple[float, float] = (0.0, inf)
    circle: float = 0.0
    _rows: dict[Stretch, tuple[Row, ...]] = field(default_factory=dict, init=False, repr=False)
    _curves: dict[Stretch, tuple[Curved, ...]] = field(default_factory=dict, init=False, repr=False)

    @property
    def cramped(self) -> str:
        """Why no cam at all can be large enough for its base circle; empty where one may be."""
        largest = self.radii[1]
        if self.circle <= largest * (1.0 + 1e-9):
            return ""
        return (
            "proven for every motion law: a dwell below is a part of the base circle, whose "
            f"radius may be {largest:.6g} mm at most; a profile radius of {self.circle:.6g} mm is "
            "asked for"
        )

    @cached_property
    def free(self) -> tuple[Stretch, ...]:
        """The stretches whose law is part of the answer."""
        return tuple(s for s in self.stretches if s.law is None)

    def rows_on(self, stretch: Stretch, level: float) -> Iterator[Row]:
        """Every row on one stretch: of limits, of objectives held, of the objective.

        Args:
            stretch: where.
            level: trial level of a fractional objective [core units].
        """
        yield from self.limit_rows(stretch)
        yield from self.objective.rows(stretch, self.machine, level)

    def limit_rows(self, stretch: Stretch) -> tuple[Row, ...]:
        """The rows on one stretch that do not speak of the objective at hand.

        Constant ones leave nothing to choose: whether they hold is the certificate's business.
        A limit says them of a place in the program, whatever the law there: they are made once.
        """
        if stretch not in self._rows:
            self._rows[stretch] = tuple(self._limit_rows(stretch))
        return self._rows[stretch]

    def _limit_rows(self, stretch: Stretch) -> Iterator[Row]:
        for limit in self.limits:
            yield from (row for row in limit.rows(stretch, self.machine) if not row.constant)
        for earlier in self.held:
            for row in earlier.objective.rows(stretch, self.machine, earlier.value):
                value = 0.0 if earlier.objective.fractional else earlier.value
                yield replace(row, upper=row.upper - row.level * value, level=0.0)

    def curves_on(self, stretch: Stretch) -> tuple[Curved, ...]:
        """What limits say on one stretch that no fixed row does: made once, as their rows."""
        if stretch not in self._curves:
            each = (limit.curved(stretch, self.machine) for limit in self.limits)
            self._curves[stretch] = tuple(curve for curves in each for curve in curves)
        return self._curves[stretch]

    @cached_property
    def curved(self) -> bool:
        """Whether any limit says such a thing."""
        return any(self.curves_on(stretch) for stretch in self.stretches)

    @cached_property
    def rigid(self) -> bool:
        """Whether curved limits on free laws are left out of cone programs: no rows are known."""
        return any(not curve.turns for stretch in self.free for curve in self.curves_on(stretch))

    @cached_property
    def cones(self) -> tuple[Cone, ...]:
        """Every cone on the size: of the sizing and of limits."""
        found = list(self.sizing.cones)
        for limit in self.limits:
            found += limit.cones(self.stretches, self.machine)
        return tuple(found)

    @cached_property
    def ringing(self) -> tuple[Ringing, ...]:
        """What the motion may leave oscillators ringing with."""
        rings = (limit.ringing(self.stretches, self.machine) for limit in self.limits)
        return tuple(ring for each in rings for ring in each)

    @property
    def unrung(self) -> Problem:
        """The same without limits on what rings: a bound of its cams is one of these."""
        kept = (one for one in self.limits if not one.ringing(self.stretches, self.machine))
        return replace(self, limits=tuple(kept))

    @cached_property
    def loud(self) -> float:
        """By how much runs whose laws are all given ring too much, over the stroke; 0: nowhere."""
        given = [ring for ring in self.ringing if settles(ring, self.stretches)]
        beyond = (amplitude(ring, self.stretches) - ring.largest for ring in given)
        worst = max(beyond, default=0.0) / self.length
        return worst if worst > QUIET else 0.0

    def room(self, size: tuple[float, ...]) -> float:
        """How far a size can be raised within bounds and cones [mm]."""
        return self.machine.follower.room(size, self.sizing.bounds, self.cones)

    def with_objective(self, objective: Objective) -> Problem:
        """The same limits with something else to make small."""
        return replace(self, objective=objective)

    def with_follower(self, follower: Follower) -> Problem:
        """The same question put to a follower with more dimensions given."""
        machine = replace(self.machine, follower=follower)
        return replace(self, machine=machine, sizing=follower.sizing(self.radii))

    def settled(self, stretches: Sequence[Stretch]) -> Problem:
        """The same question with these stretches in place of the free ones."""
        by_index = {s.index: s for s in stretches}
        found = replace(self, stretches=tuple(by_index.get(s.index, s) for s in self.stretches))
        found._rows.update(self._rows)
        found._curves.update(self._curves)
        for free in self.free:
            law = by_index.get(free.index, free)
            if _place(law) == _place(free):  # limits say the same there, whatever the law
                found._rows[law], found._curves[law] = self.limit_rows(free), self.curves_on(free)
        return found


def _place(stretch: Stretch) -> Place:
    """What of a stretch limits may speak of: all but its law."""
    s = stretch
    return s.index, s.kind, s.start, s.angle, s.s_start, s.s_end, s.free


def pose(
    spec: DesignSpec,
    objective: Objective,
    held: tuple[Held, ...] = (),
    stretches: Sequence[Stretch] | None = None,
) -> Problem:
    """The spec as a problem with one objective; ``stretches``: its own with tables smoothed."""
    placed, machine = spec.stretches() if stretches is None else stretches, spec.machine()
    radii = spec.base_radius_range()
    return Problem(
        tuple(s for s in placed if s.angle > 0.0),
        machine,
        (*spec.all_limits(), *(limit for earlier in held for limit in earlier.limits(machine))),
        spec.follower.sizing(radii),
        objective,
        spec.stroke(),
        held,
        radii,
        _circle(spec, placed),
    )


def _circle(spec: DesignSpec, stretches: Sequence[Stretch]) -> float:
    """Least base radius that a dwell at the lowest position needs, a part of the base circle."""
    circle = max((limit.least_circle for limit in spec.limits), default=0.0)
    if circle == 0.0 or spec.follower.base_gap < 0.0:
        return 0.0
    lowest = RESTS * spec.stroke()
    resting = any(s.kind == "dwell" and s.angle > 0.0 and s.s_start <= lowest for s in stretches)
    return circle if resting else 0.0


def calmer(problem: Problem) -> Problem:
    """The same, free laws as smooth inside as the best ones, where a mean square is made small.

    Where nothing caps the derivative whose mean square is the first objective, and no window or
    point bends the law, that derivative is continuous on the best law. Splines of that class come
    near it with the fourth power of the knots' distance, those of one class less with the square.
    They join their neighbours as they were asked to.
    """
    first = problem.held[0].objective if problem.held else problem.objective
    order = first.energy_order()
    if order is None or any(_bends(problem, stretch, order) for stretch in problem.free):
        return problem
    return replace(problem, stretches=tuple(_smoother(s, order) for s in problem.stretches))


def _bends(problem: Problem, stretch: Stretch, order: int) -> bool:
    """Whether something makes a free law's derivative of this order jump."""
    assert stretch.free is not None
    capped = any(
        row.coefficients[order] != 0.0
        for limit in problem.limits
        for row in limit.rows(stretch, problem.machine)
    )
    return capped or bool(stretch.free.knots)


def _smoother(stretch: Stretch, order: int) -> Stretch:
    """A free law of class C^order at least inside, as smooth as asked at its ends."""
    law = stretch.free
    if law is None or stretch.law is not None or law.smoothness >= order:
        return stretch
    joins = law.promised(at_start=True), law.promised(at_start=False)
    return replace(stretch, free=replace(law, smoothness=order, joins=joins))
