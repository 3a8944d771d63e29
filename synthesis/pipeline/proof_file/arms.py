"""Witnesses of bounds of an arm's size: a tree of boxes of e and s0, each with its multipliers.

Symbols as in ``docs/proof.md``: lengths over the arm's own, e and s0 where the axis is from the
roller's centre in the lowest position. In a box the pressure angle implies linear rows, which the
checker derives; linear programs over laws and sizes find multipliers for them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from copy import copy
from fractions import Fraction
from functools import partial
from itertools import product
from math import hypot, tan
from typing import Any

import numpy as np
from scipy.interpolate import BSpline

from synthesis.numerics.piecewise import Array
from synthesis.pipeline.proof_file.boxes import Leaf, search
from synthesis.pipeline.proof_file.checker import as_bytes, checker
from synthesis.pipeline.proof_file.laws import ORDER, Json, Row
from synthesis.pipeline.proof_file.program import DEGREE, Program

KNOTS = 24  # equal intervals of a law
PLACES = 12  # of a free law, where its position is bounded
SAMPLES = 81  # of a given law
NEARER = 41  # places around one that binds
LEAVES = (
    300,
    40,
)  # of a tree, at most: of given laws, and of free ones, which take 10 times as long
TRIES = 14  # radii at which a leaf's multipliers are evaluated
PRICE = 4.0  # of breaking rows, in radii: more than their multipliers sum to
CLOSE = 1e-4  # of the target: what is left to gain
FIGURES = 3  # decimals of a swing [deg] where a plane touches
LOST = 2e-4  # of the target: what an interval may lose to a ψ that changes its sign
NOTHING: Json = {"order": 3, "segments": []}


def in_boxes(asked: bytes, laws: Sequence[Json | None], target: float) -> tuple[float, Json] | None:
    """What shows that no cam of an arm is smaller than nearly its target.

    Args:
        asked: the question. laws: of its best cam. target: base radius [mm].

    Returns:
        the base radius that is reached [mm], and the witness; None where the jerk of a free law is
        not limited.
    """
    judge = checker()
    judge.spent.clear()
    question = judge.Question(judge.read(asked))
    free = [s for s in question.turning if s.free]

    def swing(index: int, x: Array) -> Array:
        law, segment = laws[index], question.program[index]
        assert law is not None
        degree = int(law["degree"])
        knots = np.concatenate([np.zeros(degree), law["knots"], np.ones(degree)])
        g = BSpline(knots, np.array(law["coefficients"], dtype=float), degree)(x)
        found: Array = float(segment.level) + float(segment.lift) * g
        return found

    if None in question.arms or (question.jerk is None and free):
        return None
    radius = Fraction(repr(target)) + question.gap
    question.radii[1] = min(radius, question.radii[1] or radius)
    most = question.highest()
    question.offsets, question.heights = [-most, most], [Fraction(0), most]
    knots = {s.index: np.linspace(0.0, 1.0, KNOTS + 1) for s in free}
    root = Leaf(0.0, 0, question, {"below": target})
    # 1. Where laws can be at some places, whatever the size.
    steps = list(_swings(Program(question, knots)))
    if steps:
        root.body["rounds"] = [[step for step, _ in steps]]
        judge.narrow(question, [bound for _, bound in steps])
    # 2. The box that has the smallest cams is halved, until nothing is to be gained.
    enough, leaves = float(question.radii[1]) * (1.0 - CLOSE), LEAVES[bool(free)]
    value = search(root, partial(_fill, knots=knots, swing=swing), enough, leaves)
    return value - float(question.gap), root.body


def _swings(program: Program) -> Iterator[tuple[Json, Any]]:
    """Steps that bound the position of free laws at places, with their bounds."""
    judge, question = program.judge, program.question
    aims, costs = list[Json](), list[Array]()
    for law in program.laws:
        for x in np.linspace(0.0, 1.0, PLACES + 1)[1:-1].round(9).tolist():
            for k in (0, 1):
                cost = (-1.0) ** k * program.motion(law.segment, np.array([x]), 0)[0][0]
                aims.append({"bound": k, "segment": law.segment.index, "x": x})
                costs.append(cost)
    found = program.minimise(costs, program.fixed, float(question.highest())) if costs else None
    for aim, (_, nu, z) in zip(aims, found or (), strict=False):
        step = {**aim, "multipliers": program.stated(nu, z, program.fixed)}
        judge.spent.clear()
        try:
            bound = judge.bound_of(question, judge.read(as_bytes(step)))
        except judge.Failure:  # where two laws meet that may overshoot, nothing bounds them
            continue
        yield step, bound


def _fill(leaf: Leaf, knots: dict[int, Array], swing: Callable[[int, Array], Array]) -> None:
    """Find the multipliers of a leaf, and what they exclude."""
    question = leaf.question
    judge, most = checker(), question.highest()
    leaf.body["multipliers"] = NOTHING
    leaf.value = float(question.radii[1])
    if question.empty(most):
        return
    near = [float(max(low, -high, 0)) for low, high in (question.offsets, question.heights)]
    program, reached = Program(question, knots), hypot(*near)
    touches = {s.index: _touches(s, program, swing) for s in question.turning}
    for _ in range(2):
        rows = program.fixed + list(_swing_rows(program, touches))
        last = program.minimise((), rows, None, PRICE)
        if last is None:
            break
        ((_, nu, z),) = last
        value = float(most)
        stated = program.stated(nu, z, rows)
        judge.spent.clear()
        part, high = copy(question), value
        try:
            constant, sizes = judge.half_plane(part, judge.read(as_bytes(stated)))
        except judge.Failure:  # as in _swings
            break
        for _ in range(TRIES):  # halve the gap between a radius that is excluded and one not
            if value <= reached:
                break
            part.radii = [None, Fraction(value) * question.arms[0]]
            if constant > judge.reach(part, *sizes):
                reached, leaf.body["multipliers"] = value, stated
            else:
                high = value
            value = 0.5 * (reached + high) if high - reached > 0.1 * CLOSE * high else reached
        if reached >= float(most):
            break
        active = [(row.segment, row.x) for row, each in zip(rows, z, strict=True) if each > 0.0]
        touches = {s.index: _touches(s, program, program.place, active) for s in question.turning}
        program = Program(question, program.finer(nu, z, rows, LOST * float(most)))
    leaf.value = reached * float(question.arms[0])


def _touches(
    segment: Any,
    program: Program,
    swing: Callable[[int, Array], Array],
    active: Sequence[tuple[int, float]] = (),
) -> tuple[Array, Array]:
    """Places of a segment, and the swings where planes touch there.

    ``active``: segment and place of rows with multipliers, near which places are close.
    """
    if not segment.lift:
        return np.zeros(1), np.array([float(segment.level)])
    if not segment.free:
        x = np.linspace(0.0, 1.0, SAMPLES)
        fine = np.linspace(-x[1], x[1], NEARER)
        x = np.concatenate([x, *(at + fine for index, at in active if index == segment.index)])
        x = np.unique(x.clip(0.0, 1.0).round(9))
        return x, program.motion(segment, x, 0)[1]
    x = np.linspace(0.0, 1.0, 4 * PLACES + 1).round(9)
    return x, swing(segment.index, x).round(FIGURES)


def _swing_rows(program: Program, touches: dict[int, tuple[Array, Array]]) -> Iterator[Row]:
    """Rows of an arm's pressure angle over the box of sizes, and of its pivot's distance.

    ``touches``: of each segment the places, (n,), and the swings where planes touch [deg].
    """
    question, none = program.question, np.zeros(1)
    first = question.turning[0]
    for side in (1, -1):
        found = question.distance_row(side)
        if found is not None:
            matrix, upper = program.row(first, none, *found)
            alpha = np.zeros((1, ORDER))
            yield Row(
                first.index, "distance", side, 0.0, 0.0, matrix[0], float(upper[0]), none, alpha,
                elastic=True,
            )  # fmt: skip
    named = [each for each in question.limits.items() if question.bends(each[1])]
    for (name, limit), segment, side in product(named, question.turning, (1, -1)):
        most = limit[f"{segment.sense}_deg"]
        x, touch = touches[segment.index]
        low, high = touch, touch
        if segment.free:
            hulls = [_hull(question, segment, at) for at in x.tolist()]
            if any(end is None for ends in hulls for end in ends):
                continue
            low, high = np.array(hulls, dtype=float).T
            touch = np.clip(touch, low, high)
        if most is None:
            continue
        steep, sizes, rest = _planes(question, side, float(most), touch, low, high)
        h, d = float(segment.lift), float(segment.degrees)
        alpha = np.stack([-steep * h, np.full(len(x), side * h / d), 0.0 * steep], axis=1)
        table, rest = np.zeros((len(x), program.width)), rest + steep * float(segment.level)
        for k in (0, 1):
            part, constant = program.motion(segment, x, k, 1.0)
            table += alpha[:, k, None] * part
            rest -= alpha[:, k] * constant
        table[:, -2:] -= sizes
        for n, at in enumerate(x.tolist()):
            own = slice(n, n + 1)
            yield Row(
                segment.index, name, side, at, at, table[n], float(rest[n]), x[own], alpha[own],
                float(touch[n]), elastic=True,
            )  # fmt: skip


def _hull(question: Any, segment: Any, x: float) -> list[float | None]:
    """Where s of a free law lies at x, of a question whose rounds are over."""
    known = question.__dict__.setdefault("hulls", {})
    if (segment.index, x) not in known:
        known[segment.index, x] = question.swings(segment, Fraction(repr(x)))
    found: list[float | None] = known[segment.index, x]
    return found


def _planes(
    question: Any, side: int, degrees: float, touch: Array, low: Array, high: Array
) -> tuple[Array, Array, Array]:
    """The checker's ``swing_row`` of many places at once: factors of s and sizes, and the rest."""
    slope, k = tan(degrees * DEGREE), question.sense
    e, s0 = np.array(list(product(question.offsets, question.heights)), dtype=float).T
    a, b = slope * s0 + side * (e + k), slope * (1 + k * e) - side * k * s0
    points = [np.array([np.sin(p * DEGREE), np.cos(p * DEGREE)]) for p in (touch, low, high)]
    # (corners, places)
    first, *ends = (np.outer(b, sine) + np.outer(a, cosine) for sine, cosine in points)
    width, (sine, cosine) = high - low, points[0]
    steep = DEGREE * (b.mean() * cosine - a.mean() * sine)
    chord = (ends[1].mean(axis=0) - ends[0].mean(axis=0)) / np.maximum(width, 1e-12)
    steep = np.where((first.mean(axis=0) < 0.0) & (width > 0.0), chord, steep)
    sizes = np.stack([slope * k * sine + side * cosine, slope * cosine - side * k * sine])
    bend = (DEGREE * width) ** 2 / 8.0
    bow = (np.abs(a) + np.abs(b))[:, None] * bend
    most = np.maximum(ends[0] - steep * low, ends[1] - steep * high)
    most += (np.maximum(np.maximum(*ends), 0.0) + bow) * bend
    least = np.minimum(*ends) - bow
    turn = DEGREE * (np.outer(b, cosine) - np.outer(a, sine)) - steep
    curved = first - steep * touch + turn**2 / (2 * DEGREE**2 * np.where(least > 0, least, 1.0))
    most = np.where(least > 0.0, np.minimum(most, curved), most)
    rest = (most - np.outer(e, sizes[0]) - np.outer(s0, sizes[1]) - side * k).max(axis=0)
    return steep, sizes.T, rest
