"""Free lifts of moves that run into each other: one longer move, whose level at a joint is free.

Two free laws that follow each other without a rest, a state or a window of their own share all
derivatives of their class at the joint, as one law of that class does inside. So all cams of all
lifts are the cams of one move over both angles that passes the joint within the range of levels
that the lifts leave: a *point* of a free law, which the spec has, with linear rows. Curved limits,
searches and bounds over all laws serve it as it stands: the bound holds for all lifts, and the law
that comes out tells the best ones.

Of three and more moves the levels' ranges do not say all that the ranges of lifts do. Then the
longer move has more cams: the bound still holds, and each level is taken as near to the cam's as
the lifts before it, and those that are to follow, allow.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from math import fsum
from typing import Any

import numpy as np
from scipy.interpolate import make_interp_spline

from synthesis.catalogue.fields import ends
from synthesis.numerics.bspline import SplineSpace
from synthesis.numerics.piecewise import Array
from synthesis.optimise.problem.grid import SplineLaw
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.candidate import Candidate, recover_cam
from synthesis.spec.design_spec import DesignSpec
from synthesis.spec.motion_constraints import Point
from synthesis.spec.program import Return, Rise, Segment

SPARE = 1e-9  # of the lift: what rounding may put a level beside its range
Move = Rise | Return
Range = tuple[float, float]  # least and largest of a lift, or of a level


@dataclass(frozen=True, eq=False)
class MergedMoves:
    """A spec with a run of moves as one.

    Attributes:
        spec: with one move in place of them. original: the spec itself.
        first: the program's first move of the run. joints: x of the one move where they meet,
            with both ends: (k + 1,) for k moves.
    """

    spec: DesignSpec
    original: DesignSpec
    first: int
    joints: Array

    @classmethod
    def of(cls, spec: DesignSpec) -> MergedMoves | None:
        """The moves with free lifts as one; None where they are not one run of such moves."""
        program = spec.program
        free = [
            i for i, segment in enumerate(program)
            if any(name != "angle_deg" and len({*ends(value)}) > 1
                   for name, value in segment.free_fields().items())
        ]  # fmt: skip
        moves = [program[i] for i in free]
        if len(moves) < 2 or free != list(range(free[0], free[-1] + 1)):
            return None
        run = [move for move in moves if isinstance(move, Rise | Return)]
        if len(run) < len(moves) or not all(_run_on(*pair) for pair in pairwise(run)):
            return None
        # Lifts that are given say what the run has to move.
        given = (segment for i, segment in enumerate(program) if i not in free)
        lift = -run[0].sign * fsum(segment.signed_lift for segment in given)
        ranges = [ends(move.given("lift")) for move in run]
        if any(segment.kind not in ("rise", "return", "dwell") for segment in program):
            return None  # what other segments gain is not a lift in this unit
        total = fsum(move.degrees for move in run)
        at = [0.0, *accumulate(move.degrees for move in run)]
        name = run[0].given_field("lift")
        changes = {
            "angle_deg": total, name: lift, "end": run[-1].end,
            "points": [_point(j, at[j], lift, ranges, name) for j in range(1, len(run))],
        }  # fmt: skip
        merged: Segment = run[0].model_copy(update=changes)
        whole = [*program[: free[0]], merged, *program[free[-1] + 1 :]]
        joints = np.array(at) / total
        return cls(spec.model_copy(update={"program": whole}), spec, free[0], joints)

    def with_lifts(self, numbered: DesignSpec, cam: Candidate) -> DesignSpec:
        """The spec with the lifts of a cam of the one move, and the other numbers of its spec."""
        count, (_, law) = len(self.joints) - 1, self._merged_law(cam)
        run = self.original.program[self.first : self.first + count]
        name = run[0].given_field("lift")
        lift = abs(numbered.program[self.first].signed_lift)
        ranges = [ends(move.given("lift")) for move in run]
        lifts, reached = list[float](), 0.0
        for j, level in enumerate(lift * law.curve()(self.joints[1:])):
            low, high = _level_range([(reached, reached), ranges[j]], ranges[j + 1 :], lift)
            lifts.append(min(max(float(level), low), high) - reached)
            reached = fsum(lifts)
        moves = [
            move.model_copy(update={name: value}) for move, value in zip(run, lifts, strict=True)
        ]
        before, after = numbered.program[: self.first], numbered.program[self.first + 1 :]
        return self.original.model_copy(update={"program": [*before, *moves, *after]})

    def split(self, problem: Problem, cam: Candidate) -> Candidate:
        """The cam of the one move as one of the moves: their problem has the lifts of the cam."""
        position, law = self._merged_law(cam)
        count, curve = len(self.joints) - 1, law.curve()
        parts = []
        for segment, (low, high) in zip(
            problem.free[position : position + count], pairwise(self.joints), strict=True
        ):
            inner = law.space.breaks[(law.space.breaks > low) & (law.space.breaks < high)]
            breaks = np.concatenate([[0.0], (inner - low) / (high - low), [1.0]])
            space = SplineSpace(law.space.degree, breaks)
            x = space.greville
            whole = sum(s.lift for s in problem.free[position : position + count])
            values = (curve(low + (high - low) * x) - curve(np.array([low]))[0]) * whole
            spline = make_interp_spline(x, values / segment.lift, space.degree, space.knots)
            parts.append(SplineLaw(space, np.asarray(spline.c, dtype=float)))
        laws = (*cam.laws[:position], *parts, *cam.laws[position + 1 :])
        return recover_cam(problem, laws, cam.size, keep_size=True)

    def _merged_law(self, cam: Candidate) -> tuple[int, SplineLaw]:
        """Position among the free laws of the one move, and its law."""
        moving = [s.index for s in cam.problem.segments if s.free is not None]
        position = moving.index(self.first)
        return position, cam.laws[position]


def _run_on(before: Move, after: Move) -> bool:
    """Whether two moves are one: free laws of one kind, nothing asked for at the joint."""
    law = before.law.free_law()
    plain = not any((before.windows, before.points, after.windows, after.points))
    angles = all(len({*ends(move.angle_deg)}) == 1 for move in (before, after))
    states = before.end is None and after.start is None
    same = before.kind == after.kind and before.law == after.law
    return law is not None and plain and angles and states and same


def _level_range(before: Sequence[Range], after: Sequence[Range], lift: float) -> Range:
    """The levels that lifts in these ranges, before and after it, reach; all together ``lift``."""
    low = max(fsum(r[0] for r in before), lift - fsum(r[1] for r in after))
    return low, min(fsum(r[1] for r in before), lift - fsum(r[0] for r in after))


def _point(j: int, at: float, lift: float, ranges: Sequence[Range], name: str) -> Point:
    """The level after j moves: no less and no more than the lifts on both sides allow."""
    low, high = _level_range(ranges[:j], ranges[j:], lift)
    unit = name.removeprefix("lift")
    fields: dict[str, Any] = {
        "angle_deg": at, f"travel{unit}": 0.5 * (low + high),
        f"tolerance{unit}": max(0.5 * (high - low), 0.0) + SPARE * lift,
    }  # fmt: skip
    return Point(**fields)
