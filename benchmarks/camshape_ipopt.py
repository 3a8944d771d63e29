"""camshape by a general solver: IPOPT on two statements of it, against the proven optimum."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import cos, pi
from typing import Any

import casadi
import numpy as np

from benchmarks.axis import Axis, relative, seconds
from benchmarks.camshape import ALPHA, LARGEST, LEAST, SIZES, breach, shape, step, value
from benchmarks.diagram import Diagram, Point, Series
from benchmarks.effort import FULL, Effort
from benchmarks.section import Section, Table
from benchmarks.timing import Call, Timing, in_turns
from synthesis.numerics.piecewise import Array

QUIET = {"ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": False}
NOISE = 1e-12
TEXT = """The same problem given to IPOPT with its default accuracy, from r = 1.5: once as
published, in the radii, and once in 1/r, where convexity is linear, with its rows over the square
of the step. IPOPT says *solved* in every row. Yet as published its value lies above the proven
optimum, the more so the larger n: second differences of near radii are so small that breaking them
by 10⁻⁸ is worth that much. It shows why rows are scaled here before any solver sees them."""


@dataclass(frozen=True)
class Outcome:
    """What a statement came to: radii r_{-1} .. r_{n+2}, and what the solver said."""

    n: int
    radii: Array
    word: str
    time: Timing

    @property
    def error(self) -> float:
        """Relative, above the optimum if positive."""
        return value(self.radii) / value(shape(self.n)) - 1.0


def run(effort: Effort = FULL) -> Section:
    """Both statements and the closed form, at every size."""
    statements: dict[str, Callable[[int], tuple[Array, str]]] = {
        "closed form": lambda n: (shape(n), "exact"),
        "IPOPT, as published": as_published,
        "IPOPT, in 1/r, rows scaled": scaled,
    }
    cases = {(name, n): partial(f, n) for name, f in statements.items() for n in effort.some(SIZES)}
    calls: dict[str, Call] = {f"{name} {n}": call for (name, n), call in cases.items()}
    times = in_turns(calls, effort.repeats(5), 0)
    found = {
        (name, n): Outcome(n, *call(), times[f"{name} {n}"]) for (name, n), call in cases.items()
    }
    return Section("camshape by a general solver", TEXT, [_diagram(found), _table(found)])


def as_published(n: int) -> tuple[Array, str]:
    """In the radii."""
    theta, r = step(n), casadi.MX.sym("r", n)
    ends = [1.0, 1.0], [LARGEST, LARGEST]
    full = casadi.vertcat(*ends[0], r, *ends[1])
    before, at, after = full[:-2], full[1:-1], full[2:]
    convex = 2.0 * before * after * cos(theta) - at * (before + after)
    growth = full[2:-1] - full[1:-2]
    most = np.concatenate([np.zeros(n + 2), np.full(n + 1, ALPHA * theta)])
    least = np.concatenate([np.full(n + 2, -np.inf), np.full(n + 1, -ALPHA * theta)])
    stated = {"x": r, "f": -pi / n * casadi.sum1(r), "g": casadi.vertcat(convex, growth)}
    found, word = _solved(stated, 1.5, (LEAST, LARGEST), (least, most))
    return np.concatenate([ends[0], found, ends[1]]), word


def scaled(n: int) -> tuple[Array, str]:
    """In u = 1/r; second differences over the squared step, first ones over the step."""
    theta, u = step(n), casadi.MX.sym("u", n)
    ends = [1.0, 1.0], [1.0 / LARGEST, 1.0 / LARGEST]
    full = casadi.vertcat(*ends[0], u, *ends[1])
    before, at, after = full[:-2], full[1:-1], full[2:]
    convex = (before - 2.0 * cos(theta) * at + after) / theta**2
    growth = (1.0 / full[2:-1] - 1.0 / full[1:-2]) / theta
    most = np.concatenate([np.full(n + 2, np.inf), np.full(n + 1, ALPHA)])
    least = np.concatenate([np.zeros(n + 2), np.full(n + 1, -ALPHA)])
    stated = {"x": u, "f": -pi / n * casadi.sum1(1.0 / u), "g": casadi.vertcat(convex, growth)}
    found, word = _solved(stated, 1.0 / 1.5, (1.0 / LARGEST, 1.0 / LEAST), (least, most))
    return 1.0 / np.concatenate([ends[0], found, ends[1]]), word


def _solved(
    stated: dict[str, Any], start: float, box: tuple[float, float], rows: tuple[Array, Array]
) -> tuple[Array, str]:
    """The unknowns and IPOPT's word."""
    solver: Any = casadi.nlpsol("camshape", "ipopt", stated, QUIET)
    first = np.full(stated["x"].shape[0], start)
    found = solver(x0=first, lbx=box[0], ubx=box[1], lbg=rows[0], ubg=rows[1])
    return np.asarray(found["x"]).ravel(), str(solver.stats()["return_status"])


Found = dict[tuple[str, int], Outcome]


def _table(found: Found) -> Table:
    rows = [
        (
            name, str(n), str(one.time), f"{value(one.radii):.9f}", f"{one.error:+.1e}",
            f"{breach(one.radii):.1e}", one.word.replace("_", " "),
        )
        for (name, n), one in found.items()
    ]  # fmt: skip
    head = ("way", ">n", ">time", ">objective", ">above the optimum by", ">worst breach", "word")
    return Table(head, rows)


def _diagram(found: Found) -> Diagram:
    series = []
    for name in dict.fromkeys(name for name, _ in found):
        sizes = {n: one for (way, n), one in found.items() if way == name}
        points = [
            Point(
                one.time.median, abs(one.error), one.time.low, one.time.high,
                str(n) if one.error and n in (min(sizes), max(sizes)) else "",
            )
            for n, one in sizes.items()
        ]  # fmt: skip
        series.append(Series(name, points))
    return Diagram(
        "camshape",
        "camshape: error against time",
        "Error of the objective against time; n beside the first and the last mark.",
        Axis("time", seconds),
        Axis("error of the objective", relative, least=NOISE),
        series,
    )
