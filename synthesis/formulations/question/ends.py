"""How a free law meets its neighbours: what they settle of it, and what both share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synthesis.formulations.question.grid import Grid
from synthesis.motion import EndState, Stretch
from synthesis.numerics.bspline import SplineSpace
from synthesis.numerics.piecewise import Array

TYPICAL_END = 1e3  # derivatives of end splines in g: keeps the rows of joints near one


@dataclass(frozen=True, eq=False)
class Ends:
    """Known derivatives of g at x = 0 and x = 1, from order 0 up, and the coefficients they fix.

    Attributes:
        start, end: (p,) and (q,) known values of g, g', … at the two ends.
        first, last: the p first and q last spline coefficients, which follow from them.
    """

    start: Array
    end: Array
    first: Array
    last: Array

    def expand(self, inner: Array) -> Array:
        """All coefficients from the unknown ones."""
        return np.concatenate([self.first, inner, self.last])

    def split(self, dense: Array) -> tuple[Array, Array]:
        """Rows over all coefficients as rows over the unknown ones, and the known part: (r,)."""
        p, q = len(self.first), len(self.last)
        stop = dense.shape[1] - q
        fixed = dense[:, stop:] @ self.last
        if np.count_nonzero(self.first):  # none where it starts at rest
            fixed += dense[:, :p] @ self.first
        return dense[:, p:stop], fixed


@dataclass(frozen=True)
class Joint:
    """A joint of two free laws where derivatives from ``lowest`` to ``highest`` are shared.

    Attributes:
        before, after: positions among the free stretches.
    """

    before: int
    after: int
    lowest: int
    highest: int


@dataclass(frozen=True, eq=False)
class JointSide:
    """One side of a joint: rows dense · c of the law at ``position``, orders lowest to highest.

    ``units`` is the factor with which g^(k) enters each row.
    """

    position: int
    dense: Array
    units: Array


def joint_rows(
    joint: Joint, free: Sequence[Stretch], grids: Sequence[Grid]
) -> tuple[JointSide, JointSide]:
    """Rows of equal derivatives, before minus after, in units of the larger side."""
    orders = np.arange(joint.lowest, joint.highest + 1)
    sizes = [free[k].lift / free[k].angle ** orders for k in (joint.before, joint.after)]
    scale = np.maximum(np.abs(sizes[0]), np.abs(sizes[1])) * TYPICAL_END
    units = (sizes[0] / scale, -sizes[1] / scale)
    rows = [
        grids[k].space.boundary(x, joint.highest + 1)[joint.lowest :]
        for k, x in ((joint.before, 1.0), (joint.after, 0.0))
    ]
    return (
        JointSide(joint.before, units[0][:, None] * rows[0], units[0]),
        JointSide(joint.after, units[1][:, None] * rows[1], units[1]),
    )


def meet(stretches: Sequence[Stretch], grids: Sequence[Grid]) -> tuple[list[Ends], list[Joint]]:
    """What the neighbours settle of every free law, and the joints between free laws.

    Args:
        stretches: the whole turn in order, none of zero angle.
        grids: one per free stretch.
    """
    position = {s.index: k for k, s in enumerate(s for s in stretches if s.law is None)}
    starts: list[Array] = [np.zeros(1)] * len(position)
    finishes: list[Array] = [np.ones(1)] * len(position)
    joints: list[Joint] = []
    for before, after in zip(stretches, (*stretches[1:], stretches[0]), strict=True):
        if before.law is None and after.law is None:
            joint, known = _free_joint(before, after, position)
            joints.append(joint)
            finishes[joint.before] = _in_g(1.0, known[0], before)
            starts[joint.after] = _in_g(0.0, known[1], after)
        elif before.law is None:
            finishes[position[before.index]] = _settled(before, after, at_start=False)
        elif after.law is None:
            starts[position[after.index]] = _settled(after, before, at_start=True)
    found = [_ends(g.space, a, b) for g, a, b in zip(grids, starts, finishes, strict=True)]
    return found, joints


def _free_joint(
    before: Stretch, after: Stretch, position: dict[int, int]
) -> tuple[Joint, tuple[EndState, EndState]]:
    """The joint of two free laws, and what is known of it on both sides.

    Where the follower turns back without overshoot its velocity is known to be 0.
    """
    assert before.free is not None
    assert after.free is not None
    monotone = not (before.free.overshoot and after.free.overshoot)
    turn = EndState(0.0 if monotone and before.lift * after.lift < 0.0 else None)
    sides = before.at_end.or_else(turn), after.at_start.or_else(turn)
    highest = min(before.free.promised(at_start=False), after.free.promised(at_start=True))
    lowest = 1 + sum(value is not None for value in sides[0].known)
    highest = max(highest, lowest - 1)
    return Joint(position[before.index], position[after.index], lowest, highest), sides


def _in_g(value: float, known: EndState, stretch: Stretch) -> Array:
    """g and as many of its derivatives as are known at an end."""
    derivatives = known.normalised(stretch.angle, stretch.lift)
    return np.array([value, *(v for v in derivatives if v is not None)])


def _settled(free: Stretch, given: Stretch, *, at_start: bool) -> Array:
    """Derivatives of g where a free law meets a given one: those asked for, else the given's."""
    assert free.free is not None
    highest = free.free.promised(at_start=at_start)
    values = given.beside(max(highest, 2), at_start=not at_start)
    known = values * free.angle ** np.arange(len(values)) / free.lift
    known[0] = 0.0 if at_start else 1.0
    asked = (free.at_start if at_start else free.at_end).normalised(free.angle, free.lift)
    count = highest + 1
    for order, value in enumerate(asked, start=1):
        if value is not None:
            known[order], count = value, max(count, order + 1)
    return np.asarray(known[:count])


def _ends(space: SplineSpace, start: Array, end: Array) -> Ends:
    first = _fixed(space, 0.0, start, slice(0, len(start)))
    last = _fixed(space, 1.0, end, slice(space.size - len(end), space.size))
    return Ends(start, end, first, last)


def _fixed(space: SplineSpace, x: float, values: Array, where: slice) -> Array:
    """The coefficients at an end that its known derivatives settle; all equal at rest."""
    if not values[1:].any():
        return np.full(len(values), values[0])
    rows = space.boundary(x, len(values))[:, where]
    return np.asarray(np.linalg.solve(rows, values), dtype=float)
