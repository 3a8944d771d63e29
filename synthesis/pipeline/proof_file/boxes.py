"""Trees of boxes of the size, each leaf with its multipliers, as a proof file states them."""

from __future__ import annotations

import heapq
from collections.abc import Callable
from copy import copy
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from synthesis.pipeline.proof_file.laws import Json


@dataclass(order=True)
class Leaf:
    """A box of the tree: what its multipliers exclude, and where it stands in the file.

    Attributes:
        value: radius below which it has no cam [mm]. number: of the leaf.
        question: with the box. body: its part of the file, to be filled.
    """

    value: float
    number: int
    question: Any = field(compare=False)
    body: Json = field(compare=False)


def search(root: Leaf, fill: Callable[[Leaf], None], enough: float, most: int) -> float:
    """Halve the box that has the smallest cams until nothing is to be gained; what all exclude.

    ``fill`` finds the multipliers of a leaf and its value; ``enough``: a value that suffices.
    ``most``: leaves.
    """
    fill(root)
    leaves = [root]
    while len(leaves) < most and leaves[0].value < enough:
        leaf = heapq.heappop(leaves)
        for part in _halves(leaf, 2 * len(leaves) + leaf.number):
            fill(part)
            heapq.heappush(leaves, part)
    return leaves[0].value


def _halves(leaf: Leaf, number: int) -> list[Leaf]:
    """The two parts of a leaf, across its widest side."""
    question = leaf.question
    ends = {"offset": question.offsets, "s0": question.heights}
    widths = {name: float(high - low) for name, (low, high) in ends.items()}
    low, high = question.arms
    widths["arm"] = float(high / low - 1) * float(question.highest())
    name = max(widths, key=lambda each: widths[each])
    low, high = {**ends, "arm": question.arms}[name]
    value = float(f"{float(low + high) / 2:.6g}")
    cases = list[Json]([{}, {}])
    leaf.body.pop("multipliers", None)
    leaf.body.update({"of": name, "value": value, "cases": cases})
    parts = []
    for k, case in enumerate(cases):
        part = copy(question)
        part.offsets, part.heights = question.offsets[:], question.heights[:]
        part.arms, part.bent = question.arms[:], {}
        part.known = {place: bounds[:] for place, bounds in question.known.items()}
        {"offset": part.offsets, "s0": part.heights, "arm": part.arms}[name][1 - k] = Fraction(
            repr(value)
        )
        parts.append(Leaf(0.0, number + k + 1, part, case))
    return parts
