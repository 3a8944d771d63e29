"""What may give way where nothing fits: every number of the spec that limits the cam, as a part.

A part is one-sided or a range; its values are the wire's, so nothing has to be converted back.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import hypot, inf

import numpy as np
from scipy.optimize import brentq

from synthesis.catalogue.constraints import (
    LinearInequality,
    NonconvexConstraint,
    NormBounds,
    VibrationBound,
)
from synthesis.catalogue.limits import Claim, Limit
from synthesis.catalogue.motion import PlacedSegment
from synthesis.optimise.conic.linear_rows import row_excess
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.problem.residual_vibration import amplitude, has_given_laws

Vector = tuple[float, ...]
CEILING = {"deg": 89.9}  # the largest value that makes sense, where there is one
SAMPLES = 360  # of a given law, about, where a curved limit is measured
SMALLEST = 1e-9  # where nothing is allowed: what is tried first [wire]
ROUNDING = 1e-9  # of the natural size: what a value held may differ by


@dataclass(frozen=True)
class RelaxableValue:
    """One field of the spec that belongs to a part: its path and the value asked."""

    field: str
    requested: float


@dataclass(frozen=True)
class Relaxable(ABC):
    """A limit, or a range of the size, that may give way.

    Attributes:
        name: as in the certificate. words: as a person would say it. unit: of its values.
        members: the fields that set it.
    """

    name: str
    words: str
    unit: str
    members: tuple[RelaxableValue, ...]

    @property
    def requested(self) -> float:
        """The tightest value asked."""
        return min(member.requested for member in self.members)

    @property
    def hint(self) -> str:
        """What is worth knowing of its values."""
        return ""

    @abstractmethod
    def loosened(self, problem: Problem, value: float) -> Problem:
        """The problem with this part at ``value``; unchanged where the size alone is meant."""

    @abstractmethod
    def least(self, settled: Problem, size: Vector | None) -> float | None:
        """The value nearest to what was asked that a finished cam satisfies, None if none does.

        Args:
            settled: the problem; segments that are still free are passed over.
            size: size variables [mm]; None: only what concerns the motion alone.
        """

    def order(self, problem: Problem) -> int:
        """Highest derivative in the part's rows: given laws whose lower ones jump break it."""
        return 0

    def fixed(self, problem: Problem) -> bool:
        """Whether neither law nor size has a say in the part."""
        return False

    @abstractmethod
    def eased(self, value: float, share: float) -> float:
        """A value looser by a share of itself."""

    def tighter(self, asked: float, needed: float) -> bool:
        """Whether what is asked does not allow yet what is needed."""
        return asked < needed


@dataclass(frozen=True)
class RelaxableLimit(Relaxable):
    """One claim of a limit that speaks in rows or cones.

    ``where`` holds position in the problem's limits and field name of every member.
    """

    where: tuple[tuple[int, str], ...]

    def loosened(self, problem: Problem, value: float) -> Problem:
        limits = list(problem.limits)
        for (position, name), member in zip(self.where, self.members, strict=True):
            update = {name: self.looser(member.requested, value)}
            limits[position] = limits[position].model_copy(update=update)
        return replace(problem, limits=tuple(limits))

    def looser(self, asked: float, value: float) -> float:
        """The looser of what a member asks and a value."""
        return max(asked, value)

    def least(self, settled: Problem, size: Vector | None) -> float | None:
        def excess(value: float) -> float:
            return max(self._excesses(self.loosened(settled, value), size), default=-inf)

        if excess(self.requested) <= 0.0:
            return self.requested
        least = self.requested or SMALLEST
        high, ceiling = 2.0 * least, CEILING.get(self.unit, inf)
        while excess(min(high, ceiling)) > 0.0:
            high *= 4.0
            if high > min(4.0 * ceiling, 1e30 * least):
                return None
        root = float(brentq(excess, self.requested, min(high, ceiling), xtol=1e-300, rtol=1e-13))
        return root if excess(root) <= 0.0 else root * (1.0 + 1e-12)

    def eased(self, value: float, share: float) -> float:
        return value * (1.0 + share)

    def _excesses(self, settled: Problem, size: Vector | None) -> Iterator[float]:
        for position, _ in self.where:
            limit = settled.limits[position]
            for segment in settled.segments:
                for row in self.own(limit.rows(segment, settled.machine)):
                    if row.is_constant:
                        yield -row.upper
                    elif segment.law is not None and (size is not None or not row.size):
                        yield row_excess(row, segment, size or ())
                if segment.law is not None and size is not None:
                    yield from self._curved(limit, segment, settled, size)
            for ring in limit.vibration_bounds(settled.segments, settled.machine):
                if has_given_laws(ring, settled.segments):
                    yield amplitude(ring, settled.segments) - ring.max_amplitude
            if size is not None:
                for cone in limit.norm_bounds(settled.segments, settled.machine):
                    yield cone.norm.value(size) - cone.upper

    def _curved(
        self, limit: Limit, segment: PlacedSegment, settled: Problem, size: Vector
    ) -> Iterator[float]:
        """Excess of curved limits at sampled angles of a settled segment."""
        placed = segment.placed()
        step = np.linspace(0.0, 1.0, max(SAMPLES // placed.count, 3))
        theta = (placed.breaks[:-1, None] + np.diff(placed.breaks)[:, None] * step).ravel()
        piece = np.repeat(np.arange(placed.count), len(step))
        s = placed.jet(theta, piece, 3)
        for curve in limit.nonconvex(segment, settled.machine):
            if curve.source == self.name:
                yield from (float(np.max(value)) for value in curve.excess(s, size))

    def order(self, problem: Problem) -> int:
        orders = (k for row in self._rows(problem) for k, a in enumerate(row.coefficients) if a)
        return max(orders, default=0)

    def fixed(self, problem: Problem) -> bool:
        rows = list(self._rows(problem))
        return bool(rows) and all(row.is_constant for row in rows)

    def _rows(self, problem: Problem) -> Iterator[LinearInequality]:
        """Its rows wherever it has any."""
        for segment in problem.segments:
            for position, _ in self.where:
                yield from self.own(problem.limits[position].rows(segment, problem.machine))

    def own(self, rows: Sequence[LinearInequality]) -> list[LinearInequality]:
        """Those of a limit's rows that this part asks for."""
        return [row for row in rows if row.source == self.name]


@dataclass(frozen=True)
class RelaxableLeast(RelaxableLimit):
    """A claim of such a limit that bounds from below; it eases down to 0, not farther."""

    @property
    def requested(self) -> float:
        return max(member.requested for member in self.members)

    def looser(self, asked: float, value: float) -> float:
        return min(asked, value)

    def least(self, settled: Problem, size: Vector | None) -> float | None:
        def excess(value: float) -> float:
            return max(self._excesses(self.loosened(settled, value), size), default=-inf)

        if excess(self.requested) <= 0.0:
            return self.requested
        if excess(0.0) > 0.0:
            return None
        root = float(brentq(excess, 0.0, self.requested, xtol=1e-300, rtol=1e-13))
        return root if excess(root) <= 0.0 else root * (1.0 - 1e-12)

    def eased(self, value: float, share: float) -> float:
        return value * (1.0 - share)

    def tighter(self, asked: float, needed: float) -> bool:
        return asked > needed


@dataclass(frozen=True)
class RelaxableWindow(Relaxable):
    """A bound on a part of one segment, or a value held there: it gives way by widening.

    Attributes:
        position: among the problem's limits. limit: as asked.
        sense: 1 where its value grows as it gives way, −1 where it falls.
        held: bounded on both sides, and the value says how far off it may be.
        rate: the wire's unit per core unit. natural: size of its values in a good law [wire].
    """

    position: int
    limit: Limit
    sense: float
    rate: float
    natural: float
    held: bool

    @property
    def hint(self) -> str:
        return "deviation allowed either way" if self.held else ""

    def loosened(self, problem: Problem, value: float) -> Problem:
        limits = list(problem.limits)
        limits[self.position] = self.limit.relaxed_by(abs(value - self.requested))
        return replace(problem, limits=tuple(limits))

    def least(self, settled: Problem, size: Vector | None) -> float | None:
        excess = [
            self.rate * row_excess(row, segment, ())
            for segment in settled.segments
            if segment.law is not None
            for row in self.limit.rows(segment, settled.machine)
        ]
        worst = max(excess, default=0.0)
        return self.requested + self.sense * (worst if worst > ROUNDING * self.natural else 0.0)

    def eased(self, value: float, share: float) -> float:
        return value + self.sense * share * max(self.natural, abs(value))

    def tighter(self, asked: float, needed: float) -> bool:
        return self.sense * (needed - asked) > 0.0


@dataclass(frozen=True)
class RelaxableRange(Relaxable):
    """One end of the range of a size variable, or of the prime radius; both where it is fixed.

    Attributes:
        axis: which size variable, None for the prime radius.
        low, high: what may not be left [mm], of the size variable or the prime radius.
        shift: what the wire's value lacks to it: Rr for the base radius.
    """

    axis: int | None
    low: float
    high: float
    shift: float = 0.0

    def loosened(self, problem: Problem, value: float) -> Problem:
        return problem

    def least(self, settled: Problem, size: Vector | None) -> float | None:
        if size is None:
            return self.requested
        found = hypot(*size) if self.axis is None else size[self.axis]
        if self.axis is None and found <= self.shift:
            return None
        return self.requested if self.low <= found <= self.high else found - self.shift

    def eased(self, value: float, share: float) -> float:
        return value + share * abs(value) * ((self.high < inf) - (self.low > -inf))


def relaxable_limits(problem: Problem, asked_for: int) -> list[Relaxable]:
    """Claims of limits that speak in rows or cones, those of one name together.

    Args:
        problem: the question.
        asked_for: how many of its limits the spec names; the others hold for every cam.
    """
    found: dict[str, RelaxableLimit] = {}
    windows: list[Relaxable] = []
    for position, limit in enumerate(problem.limits):
        for claim in limit.claims(problem.segments, problem.machine):
            if claim.limit not in _sources(limit, problem):
                continue
            if claim.interval is not None:
                windows.append(_window_part(problem, position, claim))
                continue
            name = claim.field.rpartition("/")[2]
            asked = float(getattr(limit, name))
            kind, sign = (RelaxableLeast, "≥") if claim.upper is None else (RelaxableLimit, "≤")
            words = f"{claim.limit.replace('_', ' ')} {sign} {asked:.6g} {claim.unit}"
            part = found.get(claim.limit, kind(claim.limit, words, claim.unit, (), ()))
            field = f"limits/{position}/{name}" if position < asked_for else "limits"
            found[claim.limit] = replace(
                part,
                words=words
                if not part.members or part.tighter(asked, part.requested)
                else part.words,
                members=(*part.members, RelaxableValue(field, asked)),
                where=(*part.where, (position, name)),
            )
    return [*found.values(), *windows]


def _window_part(problem: Problem, position: int, claim: Claim) -> RelaxableWindow:
    """A claim about a part of one segment."""
    limit = problem.limits[position]
    (segment,) = (s for s in problem.segments if s.index in claim.segments)
    row = limit.rows(segment, problem.machine)[0]
    order = next(k for k, a in enumerate(row.coefficients) if a != 0.0)
    one, zero = claim.to_wire(1.0), claim.to_wire(0.0)
    assert one is not None
    assert zero is not None
    given = (end for end in (claim.lower, claim.upper) if end is not None)
    low, *more = sorted(end for end in map(claim.to_wire, given) if end is not None)
    from_below = (claim.upper is None) == (one > zero)
    sense = 1.0 if more or not from_below else -1.0
    half = 0.0 if claim.equality or not more else float(f"{0.5 * (more[0] - low):.12g}")
    middle = 0.5 * (low + more[0]) if more else low
    sign = "=" if more else "≤" if sense > 0.0 else "≥"
    words = f"{claim.limit.replace('_', ' ')} {sign} {middle:.6g} {claim.unit}"
    if half > 0.0:
        words += f" ± {half:.6g} {claim.unit}"
    return RelaxableWindow(
        name=claim.limit, words=words, unit=claim.unit,
        members=(RelaxableValue(claim.field, half if more else float(f"{low:.15g}")),),
        position=position, limit=limit, held=bool(more), sense=sense, rate=abs(one - zero),
        natural=abs(one - zero) * abs(segment.lift) / segment.angle**order,
    )  # fmt: skip


def _sources(limit: Limit, problem: Problem) -> set[str]:
    machine, terms = (
        problem.machine,
        list[LinearInequality | NormBounds | NonconvexConstraint | VibrationBound](),
    )
    terms += limit.vibration_bounds(problem.segments, machine)
    for segment in problem.segments:
        terms += limit.rows(segment, machine)
        if segment.law is not None:
            terms += limit.nonconvex(segment, machine)
    return {term.source for term in (*terms, *limit.norm_bounds(problem.segments, machine))}
