"""Witnesses of bounds of a swinging face's size under given laws: a tree of boxes.

Symbols as in ``docs/proof.md``. Where the motion is known every limit is linear in the size, (e,
s0); the distance of the pivot is so in a box alone. Nothing here has to be right: what is wrong
proves less.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np
from scipy.optimize import linprog

from synthesis.numerics.piecewise import Array
from synthesis.pipeline.proof_file.boxes import Leaf, search
from synthesis.pipeline.proof_file.checker import as_bytes, checker
from synthesis.pipeline.proof_file.laws import Json

SAMPLES = 33  # of a law
NEARER, MESHES = 9, 4  # places around one that binds, each time as near as they were; how often
LEAVES = 300  # of a tree, at most
PRICE = 4.0  # of breaking rows, in mm of the base radius: more than their multipliers sum to
TRIES = 20  # radii at which a leaf's multipliers are evaluated
CLOSE = 1e-6  # of the target: what is left to gain
FIGURES = 9  # of a multiplier
NOTHING: Json = {"order": 3, "segments": []}


@dataclass(frozen=True)
class Place:
    """A row of the size, normal · (e, s0) ≤ upper, and where it stands in the file."""

    segment: int
    limit: str
    side: int
    x: float
    normal: Array
    upper: float


def in_boxes_of_face(asked: bytes, target: float | None) -> tuple[float, Json] | None:
    """What shows that no cam of a swinging face is smaller than nearly its target.

    Args:
        asked: the question. target: base radius [mm]; None: there is no cam at all.

    Returns:
        the base radius that is reached [mm], and the witness; None of other followers, and of laws
        that are free.
    """
    judge = checker()
    judge.spent.clear()
    question = judge.Question(judge.read(asked))
    if not (question.face and question.swung) or any(s.free for s in question.turning):
        return None
    if target is not None:
        question.radii[1] = min(Fraction(repr(target)), question.radii[1] or Fraction(repr(target)))
    most = question.highest()
    if most is None:
        return None
    question.heights[1] = most
    root = Leaf(0.0, 0, question, {} if target is None else {"below": target})
    # Places of all laws, then nearer ones around those that bind in the whole box.
    places = {s.index: np.linspace(0.0, 1.0, SAMPLES if s.lift else 1) for s in question.turning}
    width = 1.0 / (SAMPLES - 1)
    rows = [row for index, x in places.items() for row in _rows(question, index, x)]
    for _ in range(MESHES):
        active, fine = _least(root, rows)[0], np.linspace(-width, width, NEARER)
        for row, factor in zip(rows[:], active, strict=False):
            if factor > 0.0:
                rows += _rows(question, row.segment, (row.x + fine).clip(0.0, 1.0))
        width = float(fine[1] - fine[0])
    value = search(root, partial(_fill, rows=rows), float(most) * (1.0 - CLOSE), LEAVES)
    return value, root.body


def _rows(question: Any, index: int, x: Array) -> list[Place]:
    """All rows of a segment at some places."""
    judge, found, segment = checker(), list[Place](), question.program[index]
    for name, limit in question.limits.items():
        for side in (1, -1) if question.bends(limit) else ():
            for at in x.round(9).tolist():
                judge.spent.clear()
                try:
                    _, size, upper = question.face_row(segment, limit, Fraction(repr(at)), side)
                except judge.Failure:
                    break
                normal = np.array(size, dtype=float)
                found.append(Place(index, name, side, at, normal, float(upper)))
    return found


def _least(leaf: Leaf, rows: list[Place]) -> tuple[Array, list[Place]]:
    """Multipliers of the least base radius in a box, with those of the pivot's distance last."""
    question, every = leaf.question, list(rows)
    first = question.turning[0].index
    for side in (1, -1):
        found = question.distance_row(side)
        if found is not None:
            _, size, upper = found
            normal = np.array(size, dtype=float)
            every.append(Place(first, "distance", side, 0.0, normal, float(upper)))
    table, upper = np.array([row.normal for row in every]), np.array([row.upper for row in every])
    scale = np.maximum(np.abs(table).max(axis=1), 1e-12)
    table = np.column_stack([table / scale[:, None], -np.ones(len(every))])
    (left, right), (low, high) = (map(float, e) for e in (question.offsets, question.heights))
    ends = [(left, right), (low, 2.0 * high + 1.0), (0.0, None)]
    found = linprog([0.0, 1.0, PRICE], table, upper / scale, bounds=ends)
    factors = np.zeros(len(every)) if found.x is None else -found.ineqlin.marginals
    return np.maximum(factors, 0.0) / scale, every


def _fill(leaf: Leaf, rows: list[Place]) -> None:
    """Find the multipliers of a leaf, and the base radius below which they exclude its box."""
    judge, question, most = checker(), leaf.question, leaf.question.highest()
    leaf.body["multipliers"], leaf.value = NOTHING, float(most)
    if question.empty(most) or question.heights[0] >= most:
        return
    factors, every = _least(leaf, rows)
    groups = dict[int, list[Json]]()
    for row, factor in zip(every, factors.tolist(), strict=True):
        if factor > 0.0:
            value = [row.x, float(f"{factor:.{FIGURES}g}")]
            group = {"limit": row.limit, "side": row.side, "multipliers": [value]}
            groups.setdefault(row.segment, []).append(group)
    parts = [{"segment": index, "rows": own, "ends": []} for index, own in sorted(groups.items())]
    stated: Json = {**NOTHING, "segments": parts}
    judge.spent.clear()
    constant, sizes = judge.half_plane(question, judge.read(as_bytes(stated)))
    low, high = (float(end) for end in question.heights)
    excludes: Callable[[float], bool] = partial(_excludes, question, constant, sizes)
    if not excludes(min(high, float(most))):
        high, best = min(high, float(most)), low
        for _ in range(TRIES):
            middle = 0.5 * (best + high)
            best, high = (middle, high) if excludes(middle) else (best, middle)
        leaf.value = best
    leaf.body["multipliers"] = stated


def _excludes(question: Any, constant: Fraction, sizes: Any, radius: float) -> bool:
    kept = question.heights[1]
    question.heights[1] = Fraction(radius)
    found: bool = constant > checker().reach(question, *sizes)
    question.heights[1] = kept
    return found
