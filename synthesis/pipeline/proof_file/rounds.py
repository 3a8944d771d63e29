"""Witnesses of bounds that a roller's profile radius raises: rounds of steps, then multipliers.

Symbols as in ``docs/proof.md``: X = s0 + s, U = v − c e, E = c e, angles in degrees. A round bounds
the size, and X and U at places of the free laws where radii are small; from these bounds the
checker derives the rows of the next round.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import product
from math import ceil
from typing import Any

import numpy as np
from scipy.interpolate import BSpline

from synthesis.numerics.piecewise import Array
from synthesis.pipeline.proof_file.checker import as_bytes, checker
from synthesis.pipeline.proof_file.laws import Json, Row
from synthesis.pipeline.proof_file.program import DEGREE, LEAST, SMALL, Program, thinned

KNOTS = 24  # equal intervals of a law, at least
PLACE_STEP = 0.05  # of a law: between places where X and U are bounded
ZONE_STEP = 0.02  # of a law: between knots where rows of radii are written
NEAR = 0.8  # of the largest curvature allowed: from there on a law is looked at
LOST = 2e-5  # of the least radius, in mm: what an interval may lose to a ψ that changes its sign
ROUNDS, MESHES = 6, 4  # at most; meshes of the last rows, each finer than the one before
FINE_ENOUGH = 0.15  # of what is missing: what coarse knots may lose
HALVINGS, WORK = "halvings of intervals", 0.7  # the checker's work; rounds' share of what it may be
SHARE = 0.01  # of what is missing: what one interval may lose
WIDTH = 2e-3  # of a law: least distance of the first knots
MARGIN = 0.02  # of a law: by which parts with small radii are widened
NEARER = 4  # halvings of what lies around a place of a given law
GAIN = 0.1  # of what is missing: a round that gains less is the last
JOINED = 30  # samples: parts that are no farther apart are one


def in_rounds(
    asked: bytes, laws: Sequence[Json | None], size: Array, target: float
) -> tuple[float, Json] | None:
    """What shows that no cam of a question is smaller than nearly its target.

    Args:
        asked: the question. laws, size: of its best cam. target: base radius [mm].

    Returns:
        the base radius that is reached [mm], and the witness; None where nothing limits the jerk of
        a roller, so that no row of a radius is known.
    """
    judge = checker()
    judge.spent.clear()
    question = judge.Question(judge.read(asked))
    free = any(s.free for s in question.turning)
    if question.face or question.arm or (question.jerk is None and free):
        return None
    radius = Fraction(repr(target)) + question.gap
    question.radii[1] = min(radius, question.radii[1] or radius)
    question.heights[1] = question.radii[1]
    own = {s.index: _knots(laws[s.index]) for s in question.turning if s.free}
    zones = {s.index: _zones(question, s, laws[s.index], size) for s in question.turning if s.free}
    program = Program(question, {k: _with_zones(x, zones[k]) for k, x in own.items()})
    rounds, before, work = list[list[Json]](), -np.inf, 0
    for number in range(ROUNDS):
        # 1. Bounds of the size, then of the path as well, from the rows known so far.
        if number:
            rows = program.fixed + list(program.bend_rows(zones))
            steps = list(_round(program, rows, zones, with_places=number > 1 or not own))
            work += sum(taken for *_, taken in steps)
            if not steps or work > WORK * judge.MOST[HALVINGS]:
                break
            rounds.append([step for step, *_ in steps])
            judge.narrow(question, [bound for _, bound, _ in steps])
        # 2. The least radius under the rows that follow, and finer knots where these lose much.
        rows = program.fixed + list(program.bend_rows(zones))
        last = program.minimise((), rows, None)
        if last is None:
            return None
        ((least, nu, z),) = last
        missing = abs(least - float(radius))
        least_lost = max(LOST * target, SHARE * missing)
        program = _finer(program, nu, z, rows, least_lost)
        # 3. Until nothing is left to gain. The first bounds of the size gain nothing by themselves.
        if least > float(radius) or (number > 1 and least - before < GAIN * missing):
            break
        before = least
    # 4. What the last rows exclude, in exact arithmetic, on knots that lose little.
    reached: tuple[float, Json] | None = None
    for _ in range(MESHES):
        rows = program.fixed + list(program.bend_rows(zones))
        last = program.minimise((), rows, None)
        if last is None:
            return reached
        ((least, nu, z),) = last
        found = program.stated(nu, z, rows)
        judge.spent.clear()
        excess = float(judge.least(question, judge.read(as_bytes(found))))
        if reached is None or target + excess > reached[0]:
            witness = {"below": target, "rounds": rounds, "multipliers": found}
            reached = min(target + excess, target), witness
        loss = least - float(radius) - excess
        if excess > 0.0 or loss < FINE_ENOUGH * abs(excess):
            break
        # intervals that lose more than half of what they lose in the mean
        count = sum(len(law.knots) for law in program.laws) or 1
        program = _finer(program, nu, z, rows, loss / (2 * count))
    return reached


def _finer(
    program: Program, nu: Array, z: Array, rows: Sequence[Row], least_lost: float
) -> Program:
    """The same program on finer knots, and with more places around those that bind elsewhere."""
    found, active = program.finer(nu, z, rows, least_lost), defaultdict[int, list[float]](list)
    for row, value in zip(rows, z, strict=True):
        if value > SMALL * float(z.max(initial=0.0)):
            active[row.segment].append(row.x)
    for segment in program.question.turning:
        if segment.free or not segment.lift:
            continue
        old = program.points(segment)
        at = np.searchsorted(old, np.unique(active[segment.index]))
        width = np.diff(old, prepend=old[0] - old[1], append=2.0 * old[-1] - old[-2])
        new = [
            old[at] + side * width[at + (side > 0)] / 2.0**k
            for side in (-1, 1)
            for k in range(1, NEARER)
        ]
        found[segment.index] = thinned(np.clip(np.concatenate([old, *new]), 0.0, 1.0), LEAST)
    return Program(program.question, found)


def _round(program: Program, rows: Sequence[Row], zones: Any, with_places: bool) -> Iterator[Any]:
    """Steps that narrow what is known of the size, and of X and U at places.

    With their bounds, and the halvings that they take of the checker.
    """
    judge, question, width = program.judge, program.question, program.width
    aims, costs = list[Json](), list[Array]()
    for k in range(4):
        ends = (question.offsets, question.heights)[k // 2]
        if ends[0] is not None and ends[0] == ends[1]:
            continue
        cost = np.zeros(width)
        cost[-2 if k < 2 else -1] = (-1.0) ** k * (program.unit if k < 2 else 1.0)
        aims.append({"bound": k})
        costs.append(cost)
    if with_places:
        for index, parts in zones.items():
            segment = question.program[index]
            for a, b in parts:
                for x in np.round(np.linspace(a, b, 1 + max(1, ceil((b - a) / PLACE_STEP))), 9):
                    for k in range(4):
                        cost = (-1.0) ** k * program.motion(segment, np.array([x]), k // 2)[0][0]
                        cost[-1 if k < 2 else -2] += (-1.0) ** k * (1.0 if k < 2 else -program.unit)
                        aims.append({"bound": k, "segment": index, "x": float(x)})
                        costs.append(cost)
    found = program.minimise(costs, rows, float(question.radii[1]))
    if found is None:
        return
    for aim, (_, nu, z) in zip(aims, found, strict=True):
        step = {**aim, "multipliers": program.stated(nu, z, rows)}
        judge.spent.clear()
        bound = judge.bound_of(question, judge.read(as_bytes(step)))
        yield step, bound, judge.spent[HALVINGS]


def _knots(law: Json | None) -> Array:
    found = np.linspace(0.0, 1.0, KNOTS + 1)
    if law is not None:
        found = np.union1d(found, np.array(law["knots"], dtype=float))
    return thinned(found, WIDTH)


def _with_zones(x: Array, zones: Sequence[tuple[float, float]]) -> Array:
    for a, b in zones:
        x = np.union1d(x, np.linspace(a, b, 1 + ceil((b - a) / ZONE_STEP)))
    return thinned(x, WIDTH)


def _zones(question: Any, segment: Any, law: Json | None, size: Array) -> list[tuple[float, float]]:
    """Parts of a free law where a radius is small on the cam."""
    x = np.linspace(0.0, 1.0, 401)
    if law is None:
        return []
    degree = int(law["degree"])
    knots = np.concatenate([np.zeros(degree), law["knots"], np.ones(degree)])
    spline = BSpline(knots, np.array(law["coefficients"], dtype=float), degree)
    h, d = float(segment.lift), float(segment.degrees) * DEGREE
    s, v, a = (h / d**k * spline(x, k) for k in range(3))
    e, s0 = size
    rise, u = s0 + s + float(segment.level), v - e
    bend = (rise**2 + u * (2 * v - e) - rise * a) / np.hypot(rise, u) ** 3
    near = np.zeros(len(x), dtype=bool)
    flanks = [(side, gap) for side, gap, _, path in question.flanks if path == 0]
    for limit, (side, gap) in product(question.limits.values(), flanks):
        if limit["kind"] == "profile_radius":
            near |= side * bend * float(gap + limit["min_mm"]) > NEAR
        if limit["kind"] == "cutter_radius":
            near |= -side * bend * float(limit["radius_mm"] - gap) > NEAR
    where = np.flatnonzero(near)
    runs = np.split(where, np.flatnonzero(np.diff(where) > JOINED) + 1) if len(where) else []
    return [
        (round(float(max(x[r[0]] - MARGIN, 0.0)), 9), round(float(min(x[r[-1]] + MARGIN, 1.0)), 9))
        for r in runs
    ]
