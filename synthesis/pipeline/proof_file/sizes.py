"""Witnesses of what every law keeps of a slide's size, whether its derivatives are capped or not.

A move takes a least time, and under a flat face it comes to rest (``docs/proof.md``, step 11). Both
are half-planes of the size, tangents at some size: those at the least size on all of them have the
multipliers. Nothing here has to be right: what is wrong proves less.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import cos, radians
from typing import Any

import numpy as np
from scipy.optimize import nnls

from synthesis.numerics.piecewise import Array
from synthesis.pipeline.proof_file.checker import as_bytes, checker
from synthesis.pipeline.proof_file.laws import Json
from synthesis.pipeline.proof_file.program import given_law

CELLS = 200  # of the heights of a move, each passed in as much time: the loss is of second order
FINEST, GRID = 1e-10, 400  # of a move: height next to its ends; heights on either side
SAMPLES = 401  # of a given law
TANGENTS = 60  # at most, of each move
HALVINGS = 60  # of a step towards a size at which a height cannot be passed
CLOSE = 1e-10  # of an angle: what a duration may exceed it by
FIGURES = 9  # of a multiplier
SMALL = 1e-9  # of the largest multiplier: what is left out
FAR = 1e3  # lifts: a size at which every height can be passed, if at any


@dataclass(frozen=True)
class Plane:
    """A half-plane normal · (e, s0) ≤ offset, and its part of the file times a factor."""

    normal: Array
    offset: float
    stated: Callable[[float], Json]


def in_sizes(asked: bytes) -> tuple[float, Json] | None:
    """The least base radius that every law keeps [mm], and its multipliers.

    Infinite where no size is left; None of other followers than those on slides.
    """
    judge = checker()
    judge.spent.clear()
    question = judge.Question(judge.read(asked))
    if question.swung:
        return None
    planes = [*_ranges(question), *_given(question), *_rests(question)]
    stroke = max(abs(float(s.lift)) for s in question.turning)
    size: Array | None = np.array([0.0, FAR * stroke])
    for _ in range(TANGENTS):
        alone = [p for p in planes if not p.normal.any() and p.offset < 0.0]
        if alone:  # whatever the size
            return np.inf, _stated(alone[:1], np.ones(1))
        _, least = _least(planes)
        if least is None or size is None:
            break
        # a tangent where every height can be passed, on the way to the least size
        aimed = least
        for _ in range(HALVINGS):
            new = [_duration(question, segment, least) for segment in question.turning]
            if None not in new:
                break
            least = 0.5 * (least + size)
        size = least
        found = [p for p in new if p is not None and p.offset < np.inf]
        excess = [p.normal @ size - p.offset - CLOSE * abs(p.offset) for p in found]
        if size is aimed and max(excess, default=0.0) <= 0.0:
            break
        planes += found
    factors, size = _least(planes)
    if not np.any(factors):
        return None
    value = np.inf if size is None else float(np.hypot(*size)) - float(question.gap)
    if question.face and size is not None:
        value = float(size[1]) * cos(radians(float(question.tilt)))
    return value, _stated(planes, factors / factors.max())


def _stated(planes: list[Plane], factors: Array) -> Json:
    """Multipliers as the file has them: those of ranges are the checker's own."""
    pairs = zip(planes, factors.tolist(), strict=True)
    parts = [plane.stated(float(f"{x:.{FIGURES}g}")) for plane, x in pairs if x > SMALL]
    return {"order": 3, "segments": [part for part in parts if part]}


def _least(planes: list[Plane]) -> tuple[Array, Array | None]:
    """Multipliers of the least size, and it; those that leave none, and None (Lawson, Hanson)."""
    normals = np.array([plane.normal for plane in planes])
    scale = np.hypot(*normals.T)
    scale[scale == 0.0] = np.inf
    offsets = np.array([plane.offset for plane in planes]) / scale
    unit = float(np.abs(offsets).max()) or 1.0
    table = np.vstack([-(normals / scale[:, None]).T, -offsets / unit])
    factors, residual = nnls(table, np.array([0.0, 0.0, 1.0]))
    rest = table @ factors - np.array([0.0, 0.0, 1.0])
    size = None if residual < CLOSE else -rest[:2] / rest[2] * unit
    return factors / scale, size


def _ranges(question: Any) -> Iterator[Plane]:
    """What the checker knows of e and s0 by itself: it needs no multipliers."""
    for sign, end in zip((-1.0, 1.0), question.offsets, strict=True):
        if end is not None:
            yield Plane(np.array([sign, 0.0]), sign * float(end), lambda _: {})
    yield Plane(np.array([0.0, -1.0]), 0.0, lambda _: {})


def _given(question: Any) -> Iterator[Plane]:
    """What limits ask of the size where the motion is known."""
    for segment, (name, limit), side in _named_rows(question):
        row = question.row(segment, limit, side)
        if segment.free or row is None or not any(row[1]):
            continue
        x = np.linspace(0.0, 1.0, SAMPLES if segment.lift else 1).round(9)
        alpha, (first, second), upper = row
        rest = np.full(len(x), float(upper))
        for k, factor in enumerate(alpha):
            if factor:
                scale = float(segment.lift) / float(segment.degrees) ** k
                g = np.array([given_law(segment.law, k, at) for at in x.tolist()])
                rest -= float(factor) * (scale * g + (float(segment.level) if k == 0 else 0.0))
        at = int(np.argmin(rest))
        where, normal = float(x[at]), np.array([float(first * question.unit[0]), float(second)])

        def stated(factor: float, own: Any = (segment.index, name, side, where)) -> Json:
            index, limit, sense, place = own
            rows = [{"limit": limit, "side": sense, "multipliers": [[place, factor]]}]
            return {"segment": index, "rows": rows, "ends": []}

        yield Plane(normal, float(rest[at]), stated)


def _named_rows(question: Any) -> Iterator[tuple[Any, tuple[str, Json], int]]:
    for item in question.limits.items():
        if question.bends(item[1]) or item[1]["kind"] in ("distance", "within"):
            continue
        for segment in question.turning:
            for side in (1, -1):
                yield segment, item, side


def _speeds(question: Any, segment: Any) -> list[tuple[str, int, Array]]:
    """Rows that limit how fast a move is: F = constant + slope · s + normal · (e, s0)."""
    found = []
    for own, (name, limit), side in _named_rows(question):
        row = question.row(segment, limit, side) if own is segment else None
        if row is None or any(row[0][2:]) or row[0][1] * segment.lift <= 0:
            continue
        (steep, along, *_), (first, second), upper = row
        values = [upper, -steep, -first * question.unit[0], -second]
        found.append((name, side, np.array(values, dtype=float) / abs(float(along))))
    return found


def _duration(question: Any, segment: Any, size: Array) -> Plane | None:
    """The tangent of a move's least duration at a size; None where it cannot pass a height.

    Without an end where nothing limits how fast it is.
    """
    rows = _speeds(question, segment) if segment.free else []
    if not rows:
        return Plane(np.zeros(2), np.inf, lambda _: {})
    table = np.array([values for *_, values in rows])
    fine = np.geomspace(FINEST, 0.5, GRID)
    x = np.unique(np.concatenate([[0.0], fine, 1.0 - fine, [1.0]]))
    level, lift = float(segment.level), float(segment.lift)

    def fastest(at: Array) -> Array:
        """(rows, places)"""
        base = table[:, 0] + table[:, 2:] @ size
        speeds: Array = base[:, None] + np.outer(table[:, 1], level + lift * at)
        return speeds

    speed = fastest(0.5 * (x[1:] + x[:-1])).min(axis=0)
    if np.any(speed <= 0.0):
        return None
    # cells that are passed in as much time each
    time = np.concatenate([[0.0], np.cumsum(np.diff(x) / speed)])
    cuts = np.interp(np.linspace(0.0, time[-1], CELLS + 1), time, x)
    cuts = np.unique(np.round(cuts, 12))
    speeds = fastest(0.5 * (cuts[1:] + cuts[:-1]))
    which = np.argmin(speeds, axis=0)
    q = np.array([float(f"{1 / v:.{FIGURES}g}") for v in speeds.min(axis=0).tolist()])
    width, middle = abs(lift) * np.diff(cuts), level + lift * 0.5 * (cuts[1:] + cuts[:-1])
    share, own = width * q**2, table[which]
    normal = -(share @ own[:, 2:])
    least = float(np.sum(2.0 * width * q - share * (own[:, 0] + own[:, 1] * middle)))

    def stated(factor: float) -> Json:
        cells = np.stack([cuts[:-1], cuts[1:], q], axis=1)
        groups = [
            {"limit": name, "side": side, "cells": cells[which == k].tolist()}
            for k, (name, side, _) in enumerate(rows)
            if np.any(which == k)
        ]
        body = {"factor": factor, "rows": groups}
        return {"segment": segment.index, "rows": [], "ends": [], "duration": body}

    return Plane(normal, float(segment.degrees) - least, stated)


def _rests(question: Any) -> Iterator[Plane]:
    """How moves come to rest under a flat face."""
    if not question.face:
        return
    judge = checker()
    for name, limit in question.limits.items():
        for segment in question.turning if limit["kind"] == "profile_radius" else ():
            for end in (0, 1):
                body = {"limit": name, "end": end}
                try:
                    asked = judge.read(as_bytes(body))
                    constant, sizes = judge.rest(question, segment, asked)
                except judge.Failure:
                    continue

                def stated(factor: float, index: int = segment.index, own: Json = body) -> Json:
                    part = {"segment": index, "rows": [], "ends": []}
                    return {**part, "rest": {"factor": factor, **own}}

                yield Plane(np.array([0.0, float(sizes[1])]), -float(constant), stated)
