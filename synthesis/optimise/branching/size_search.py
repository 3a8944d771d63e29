"""Branch and bound over sizes where all laws are given: nothing but the size is open.

Limits on a traced point (curvature, Hertz pressure) are not convex in the size. On a given motion
they imply linear rows over a box of sizes at every cam angle (``size_rows``): a box that breaks one
of these all over, or a half-plane of a linear limit, holds no cam. What is left bounds the size
from below, and the boxes that look best give cams, enlarged until all limits hold.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from synthesis.numerics.box_search import BoxSearch, Budget
from synthesis.numerics.piecewise import Array, Mask
from synthesis.optimise.branching.node import is_traced
from synthesis.optimise.recovery.candidate import cam_at_size
from synthesis.optimise.recovery.closed_form import half_planes
from synthesis.optimise.relaxation.size_rows import is_excluded, norm_range
from synthesis.optimise.state import SolveState, Stage

LEVELS, BOXES = 60, 6_000  # of one search
ANGLES = 192  # of a segment, at which rows are written
OUTSIDE = 1e-9  # of the stroke: what a box must leave of a half-plane, against rounding
VALID_FOR = "every size of the given laws"


class SizeSearch(BoxSearch[Array]):
    """A search over boxes (d, 2, n) of d size variables; its function is −radius.

    Attributes:
        state: its incumbent is the best cam. count: boxes that were bounded.
    """

    def __init__(self, state: SolveState) -> None:
        problem, norm = state.problem, state.problem.objective.norm(state.problem.machine)
        assert norm is not None
        self.state, self.norm, self.count = state, norm, 0
        self.children = 2
        self.normals, self.offsets = half_planes(problem)

    def bound(self, boxes: Array) -> Array:
        """−(least radius) on every box, −∞ where no cam is."""
        problem = self.state.problem
        self.count += boxes.shape[2]
        middle, half = boxes.mean(axis=1), 0.5 * np.ptp(boxes, axis=1)
        radius, _ = norm_range(self.norm, boxes)
        # 1. Boxes beyond a half-plane of a linear limit, or where a traced limit's rows are broken.
        least = self.normals @ middle - np.abs(self.normals) @ half
        beyond = least > self.offsets[:, None] + OUTSIDE * problem.length
        empty = beyond.any(axis=0) | is_excluded(problem, boxes, ANGLES)
        upper = np.where(empty, -np.inf, -radius)
        # 2. A cam from the middle of the box that looks best.
        best = int(np.argmax(upper))
        if upper[best] > -np.inf:
            cam = cam_at_size(problem, (), tuple(middle[:, best].tolist()))
            if np.all(self.normals @ np.array(cam.size) <= self.offsets):
                self.state = self.state.with_incumbent(cam)
        return upper

    def threshold(self) -> float:
        """The value that is to be proven."""
        return -self.target

    def is_late(self) -> bool:
        return self.state.time_left <= 0.0

    @property
    def target(self) -> float:
        """The value below which no cam is to be left [problem units]."""
        assert self.state.incumbent is not None
        return self.state.bound_to_prove(self.state.incumbent)

    def split(self, boxes: Array, keep: Mask) -> Array:
        """Each halved across its widest size."""
        kept = boxes[:, :, keep]
        axis, n = np.argmax(np.ptp(kept, axis=1), axis=0), np.arange(kept.shape[2])
        low, high = kept.copy(), kept.copy()
        low[axis, 1, n] = high[axis, 0, n] = kept[axis, :, n].mean(axis=1)
        return np.concatenate([low, high], axis=2)


def search_sizes(state: SolveState) -> SolveState:
    """Close the gap of given laws; the same state where the objective is not a radius of the cam.

    The boxes cover the sizes whose radius is no larger than the incumbent's.
    """
    problem, best, started = state.problem, state.incumbent, state.stopwatch
    norm = problem.objective.norm(problem.machine)
    if state.is_good_enough or best is None or norm is None or state.time_left <= 0.0:
        return state
    kinds = {limit.kind for limit in problem.limits if is_traced(state, limit)}
    state = replace(state, modelled_kinds=kinds)
    # no radius is below the least that the spec states: the best cam may be as small already
    least = state.raise_bound(0.0, VALID_FOR)
    if least.is_good_enough:
        return least
    # ‖M z + m‖ ≤ R leaves each y = M z + m within ±R, and z = M⁺ (y − m) but for a part of z of
    # which M does not speak
    matrix, (low, high) = np.array(norm.matrix), np.array(problem.sizing.bounds).T
    inverse = np.linalg.pinv(matrix)
    unseen = np.abs(np.eye(len(low)) - inverse @ matrix).sum(axis=1) > OUTSIDE
    reach = np.where(unseen, np.inf, np.abs(inverse).sum(axis=1) * best.value)
    middle = -inverse @ np.array(norm.shift)
    ends = np.stack([np.maximum(low, middle - reach), np.minimum(high, middle + reach)], axis=1)
    if not np.all(np.isfinite(ends)):
        return state
    search = SizeSearch(state)
    search.run(ends[:, :, None], Budget(LEVELS, BOXES))
    state = search.state.raise_bound(min(-search.proven, search.target), VALID_FOR)
    return state.with_stage(
        Stage(
            "sizes", f"linear rows in {search.count} boxes", "none", len(ends), 0, 0,
            state.stopwatch - started, "solved", "boxes without a better cam", search.count,
        )
    )  # fmt: skip
