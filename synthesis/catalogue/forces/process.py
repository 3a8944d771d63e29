"""The process force: what the machine's task asks of the follower, over the cam angle."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field
from pydantic_core import PydanticCustomError

from synthesis.numerics.piecewise import Piecewise
from synthesis.units import DEGREE, FULL_TURN

Angle = Annotated[float, Field(ge=0.0, le=360.0, description="Cam angle.")]
Point = tuple[float, float]


class ForcePoint(BaseModel):
    """The force at one cam angle; straight lines join the points."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    angle_deg: Angle
    force_n: Annotated[float, Field(ge=-1e12, le=1e12, description="Positive against the rise.")]


class MomentPoint(BaseModel):
    """The moment at one cam angle; straight lines join the points."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    angle_deg: Angle
    moment_n_m: Annotated[float, Field(ge=-1e12, le=1e12, description="Positive against the rise.")]


def check_order(points: Sequence[Point]) -> None:
    """Refuse points of which one lies before its predecessor, or three at one angle.

    Args:
        points: cam angle [deg] and value.
    """
    for (before, _), (after, _) in pairwise(points):
        if after < before:
            raise PydanticCustomError(
                "process_out_of_order",
                "process goes back from {before}° to {after}°. Give the points in the order of "
                "the cam angle; two at the same angle make a jump.",
                {"before": before, "after": after},
            )
    for (first, _), (_, _), (last, _) in zip(points, points[1:], points[2:], strict=False):
        if first == last:
            raise PydanticCustomError(
                "process_thrice",
                "process gives three values at {angle}°. Two make a jump; leave one out.",
                {"angle": first},
            )


def force_course(points: Sequence[Point], unit: float) -> Piecewise:
    """The force over one turn as straight pieces [N over rad].

    Between the last point and the first one of the next turn it runs straight, too; of no point it
    is 0, of one it is constant.

    Args:
        points: cam angle [deg] and value, in order. unit: N in one of the value's units.
    """
    if not points:
        return Piecewise.of([0.0, FULL_TURN], [[0.0]])
    known = [(angle * DEGREE, value * unit) for angle, value in points]
    first, last = known[0], known[-1]
    if first[0] > 0.0 or last[0] < FULL_TURN:
        gap = first[0] + FULL_TURN - last[0]
        share = (FULL_TURN - last[0]) / gap if gap > 0.0 else 0.0
        seam = last[1] + share * (first[1] - last[1])
        if first[0] > 0.0:
            known.insert(0, (0.0, seam))
        if last[0] < FULL_TURN:
            known.append((FULL_TURN, seam))
    pieces = [(one, other) for one, other in pairwise(known) if other[0] > one[0]]
    breaks = [one[0] for one, _ in pieces] + [FULL_TURN]
    rows = [[a, (b - a) / (end - start)] for (start, a), (end, b) in pieces]
    return Piecewise.of(breaks, rows)
