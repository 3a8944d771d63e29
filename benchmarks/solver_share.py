"""What a design costs over its solver: total time against Clarabel alone on the same matrices."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import clarabel

from benchmarks.effort import FULL, Effort
from benchmarks.main_job import CONVEX
from benchmarks.section import Section, Table
from benchmarks.timing import in_turns, timed
from synthesis import DesignSpec, synthesise

TOLERANCES = (5e-3, 1e-3, 5e-4, 1e-4)
SPAN_S = 4.0  # on each tolerance: what else the machine does comes and goes within seconds
TEXT = """Example 13-6's motion, laws free, under pressure angle and jerk, to several proven gaps.
The cone programs that a design states on its way are collected, and solved again by Clarabel with
nothing around them; both take turns. The rest is stating them, the bound over all motion laws,
the certificate and the report."""
Program = tuple[Any, ...]


def run(effort: Effort = FULL) -> Section:
    """Times and their ratio, tolerance by tolerance."""
    rows = [_row(tolerance, effort) for tolerance in effort.some(TOLERANCES)]
    head = (
        ">tolerance", ">proven gap", ">base radius", ">cone programs", ">design",
        ">Clarabel alone", ">ratio",
    )  # fmt: skip
    front = [("design against Clarabel alone, tolerance 0.5 %", f"{rows[0][-1]} times", rows[0][1])]
    return Section("What a design costs over its solver", TEXT, [Table(head, rows)], front)


def _row(tolerance: float, effort: Effort) -> tuple[str, ...]:
    spec = DesignSpec.model_validate(CONVEX | {"tolerance": tolerance})
    with _recorded() as programs:
        design = synthesise(spec)
    calls = {"design": lambda: synthesise(spec), "alone": lambda: _solve(programs)}
    repeats = int(SPAN_S / timed(lambda: [call() for call in calls.values()], 3, 0).median)
    times = in_turns(calls, effort.repeats(repeats), effort.warm_up(3))
    gap = design.certificate.gap
    return (
        f"{100.0 * tolerance:g} %",
        "none" if gap is None else f"{100.0 * gap:.3f} %",
        f"{design.dimensions['base_radius_mm']:.4f} mm",
        str(len(programs)),
        str(times["design"]),
        str(times["alone"]),
        times["design"].over(times["alone"]),
    )


def _solve(programs: list[Program]) -> None:
    for program in programs:
        clarabel.DefaultSolver(*program).solve()


@contextmanager
def _recorded() -> Iterator[list[Program]]:
    """The arguments of every solver that is made meanwhile."""
    made: list[Program] = []
    solver = clarabel.DefaultSolver

    def recording(*arguments: Any) -> Any:
        made.append(arguments)
        return solver(*arguments)

    clarabel.DefaultSolver = recording
    try:
        yield made
    finally:
        clarabel.DefaultSolver = solver
