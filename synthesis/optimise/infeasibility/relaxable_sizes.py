"""What may give way of the size: ranges of the base radius and of the follower's dimensions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import inf

from synthesis.catalogue.constraints import enlarged
from synthesis.catalogue.followers.base import base_gap
from synthesis.catalogue.ranges import ends
from synthesis.optimise.infeasibility.relaxable import Relaxable, RelaxableRange, RelaxableValue
from synthesis.optimise.problem.problem import Problem
from synthesis.spec.design_spec import DesignSpec

OPEN = 1e4  # strokes: what the base radius may grow to while it is not limited
BEYOND = 10.0  # and how far beyond a limit asked for it, at least


def open_size(spec: DesignSpec, problem: Problem) -> Problem:
    """The problem with every range of its size left open (but for the unit of size)."""
    follower = problem.machine.follower
    names = [f"{name}_mm" for name in follower.size_names]
    free = {name: None for name in names if name in type(follower).model_fields}
    asked = [end for end in ends(spec.base_radius_mm) if end < inf]
    largest = max(
        OPEN * max(problem.length, problem.sizing.min_norm), BEYOND * max(asked, default=0.0)
    )
    sizing = follower.model_copy(update=free).size_domain((1e-3 * problem.length, largest))
    return replace(problem, sizing=replace(sizing, min_norm=problem.sizing.min_norm))


def relaxable_ranges(spec: DesignSpec, problem: Problem) -> list[Relaxable]:
    """Ranges of the follower's own dimensions and of the base radius, as far as they are asked."""
    found: list[Relaxable] = []
    follower, roller = spec.follower, base_gap(problem.machine.follower)
    for axis, size_name in enumerate(follower.size_names):
        name = f"{size_name}_mm"
        if name in type(follower).model_fields:
            found += _sides(size_name, f"follower/{name}", ends(getattr(follower, name)), axis, 0.0)
    low, high = ends(spec.base_radius_mm)
    radii = list(_sides("base_radius", "base_radius_mm", (low, high), None, roller))
    if harmed_by_size(problem):
        return found + radii
    # a larger size eases everything, so that only the largest can be in the way
    return found + [replace(part, low=-inf) for part in radii if part.high < inf]


def harmed_by_size(problem: Problem) -> bool:
    """Whether a larger size may break a limit: its outer radius, or contact on a tilted face."""
    low = tuple(low for low, _ in problem.sizing.bounds)
    raised = enlarged(low, 1.0)
    rows = (row for s in problem.segments for limit in problem.limits
            for row in limit.rows(s, problem.machine))  # fmt: skip
    return any(
        limit.norm_bounds(problem.segments, problem.machine) for limit in problem.limits
    ) or any(
        sum(a * (new - old) for a, new, old in zip(row.size, raised, low, strict=False)) > 0.0
        for row in rows
    )


def _sides(
    name: str, field: str, asked: tuple[float, float], axis: int | None, shift: float
) -> Iterator[RelaxableRange]:
    """The parts of one range: its two ends, or one part where it is a number."""
    low, high = asked
    ways = [("≥", low, inf, "/min"), ("≤", -inf, high, "/max")]
    for sign, least, most, end in [("=", low, high, "")] if low == high else ways:
        value = most if least == -inf else least
        if abs(value) < inf:
            words = f"{name.replace('_', ' ')} {sign} {value:.6g} mm"
            members = (RelaxableValue(field + end, value),)
            yield RelaxableRange(
                name, words, "mm", members, axis, least + shift, most + shift, shift
            )
