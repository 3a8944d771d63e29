"""Time and memory with the number of segments and of knots."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import radians
from typing import Any

from benchmarks import memory
from benchmarks.axis import Axis, plain, relative, seconds
from benchmarks.diagram import Diagram, Point, Series
from benchmarks.effort import FULL, Effort
from benchmarks.main_job import CONVEX
from benchmarks.section import Section, Table
from benchmarks.timing import Call, Timing, in_turns
from synthesis import DesignSpec, synthesise
from synthesis.numerics.solvers.clarabel import solve
from synthesis.optimise.conic.program import formulate
from synthesis.optimise.dual_bound.bound import dual_bound
from synthesis.optimise.problem.grid import uniform_grid
from synthesis.optimise.problem.problem import formulate_problem

SEGMENTS = (1, 2, 4, 10, 20, 50, 100)  # with free laws
INTERVALS = (10, 20, 40, 80, 160, 320, 640)  # of each of two laws
LEAST = 0.1  # MiB; less is noise
SMALL = 0.5  # size of the other steps: of the lift that the same jerk allows over their angle
TEXT = """How designs grow. *Segments*: rises and returns with free laws, the main job's two and
many smaller ones in the rest of the turn, all under one jerk limit, in one cone program; whole
designs at a tolerance of 0.5 %, certificate included. With one, the return is cycloidal. *Knots*:
one round of the main job on so many equal intervals a law: matrices, solver, bound. *Memory* is
what a process of its own needed beyond the loaded library at its peak."""


@dataclass(frozen=True)
class Outcome:
    """One size: time, memory beyond the library [MiB], and what came out."""

    size: int
    time: Timing
    memory: float
    reported: str


def run(effort: Effort = FULL) -> Section:
    """Both ways of growing."""
    segments = _measured("design", effort.some(SEGMENTS), effort)
    knots = _measured("one_round", effort.some(INTERVALS), effort)
    curves = {"segments with free laws": segments, "intervals of each law": knots}
    return Section(
        "Scaling",
        TEXT,
        [
            _diagram("scaling-time", "time", Axis("time", seconds), curves),
            _diagram("scaling-memory", "memory", Axis("memory, MiB", plain), curves),
            _table(">segments", "proven gap", segments),
            _table(">intervals", "proven gap", knots),
        ],
    )


def design(segments: int) -> str:
    """A whole design; its gap."""
    gap = synthesise(DesignSpec.model_validate(program(segments))).certificate.gap
    return "none" if gap is None else relative(gap)


def one_round(intervals: int) -> str:
    """One cone program with its bound; the gap."""
    spec = DesignSpec.model_validate(CONVEX)
    problem = formulate_problem(spec, spec.objectives()[0])
    plan = formulate(problem, [uniform_grid(segment, intervals) for segment in problem.free])
    solution = solve(plan.program)
    reached = plan.program.value(solution.x) * plan.scales.size
    return f"{1.0 - dual_bound(plan, solution).value / reached:.1e}"


CALLS = {"design": design, "one_round": one_round}


def program(segments: int) -> dict[str, Any]:
    """The main job's rise and return, and smaller ones in the remaining 240°."""
    rise: dict[str, Any] = {"kind": "rise", "angle_deg": 60.0, "lift_mm": 30.0}
    back = {"kind": "return", "angle_deg": 60.0, "lift_mm": 30.0}
    if segments == 1:
        back["law"] = {"kind": "cycloidal"}
    more = max(segments - 2, 0)
    moving = [rise, back]
    for k in range(more):
        angle = 240.0 / more
        lift = min(30.0, SMALL * 30.0 * (radians(angle) / radians(60.0)) ** 3)
        kind = ("rise", "return")[k % 2]
        moving.append({"kind": kind, "angle_deg": angle, "lift_mm": lift})
    rest = [] if more else [{"kind": "dwell", "angle_deg": 240.0}]
    # a small roller and small angles of pressure: curvature must not bind, or it is another task
    return CONVEX | {
        "program": [*moving, *rest],
        "follower": {"kind": "translating_roller", "roller_radius_mm": 1.0},
        "limits": [
            {"kind": "pressure_angle", "rise_deg": 20.0, "return_deg": 20.0},
            CONVEX["limits"][1],
        ],
    }


def _measured(name: str, sizes: tuple[int, ...], effort: Effort) -> list[Outcome]:
    call = CALLS[name]
    reported: dict[int, str] = {}
    calls: dict[str, Call] = {
        str(size): (lambda s=size: reported.update({s: call(s)})) for size in sizes
    }
    times = in_turns(calls, effort.repeats(3), 0)
    return [Outcome(size, times[str(size)], _memory(name, size), reported[size]) for size in sizes]


def _memory(name: str, size: int) -> float:
    """Beyond a process that has loaded all and solved the smallest one [MiB]."""
    prepare = f"from benchmarks.scaling import {name}\n{name}(1 if {name!r} == 'design' else 4)"
    before, after = memory.grown(prepare, f"{name}({size})")
    return max(after - before, LEAST)


def _table(size: str, reported: str, found: list[Outcome]) -> Table:
    rows = [(str(one.size), str(one.time), _mebibytes(one.memory), one.reported) for one in found]
    return Table((size, ">time", ">memory", f">{reported}"), rows)


def _mebibytes(memory: float) -> str:
    return f"{memory:.0f} MiB" if memory >= 1.0 else "below 1 MiB"


def _diagram(name: str, kind: str, axis: Axis, curves: Mapping[str, list[Outcome]]) -> Diagram:
    series = [
        Series(
            reported,
            [Point(one.size, one.time.median if kind == "time" else one.memory) for one in found],
        )
        for reported, found in curves.items()
    ]
    return Diagram(
        name,
        f"Scaling: {kind} with segments and with knots",
        f"How {kind} grows with the number of segments, and of knots of two laws.",
        Axis("number", plain),
        axis,
        series,
    )
