"""Questions that have no best answer: each better cam leads to a still better one, without end."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from pydantic_core import PydanticCustomError

from synthesis.catalogue.followers import Follower
from synthesis.catalogue.limits import Limit
from synthesis.catalogue.objectives import Objective

Ends = tuple[float, float]


@dataclass(frozen=True)
class SizeProblem:
    """What decides whether there is a best cam.

    Attributes:
        objectives: in order. limits: those asked for.
        asked: base radius as asked, open ends infinite. opened: with open ends replaced.
        reached: the part of those that the follower reaches, all [mm].
        free: whether any motion law is part of the answer.
    """

    follower: Follower
    objectives: Sequence[Objective]
    limits: Sequence[Limit]
    asked: Ends
    opened: Ends
    reached: Ends
    free: bool

    @property
    def kinds(self) -> list[str]:
        """Of the objectives."""
        return [objective.kind for objective in self.objectives]


def check_has_optimum(asked: SizeProblem) -> None:
    """Refuse a question without a best answer.

    Raises:
        PydanticCustomError: with the objective, and what would give it one.
    """
    if "peak_pressure_angle" in asked.kinds:
        _check_largest(asked)
    if asked.kinds[0] == "base_radius":
        _check_smallest(asked)


def _check_largest(asked: SizeProblem) -> None:
    """A larger cam has a smaller pressure angle: something has to end its growth."""
    follower, kinds = asked.follower, asked.kinds
    curves = follower.pressure_angle_constraints(1.0)
    if not curves and all(row.is_constant for row in follower.pressure_angle_rows(1.0)):
        raise PydanticCustomError(
            "pressure_angle_given",
            "objective peak_pressure_angle is not offered for a {kind} follower: its face "
            "settles the pressure angle. Choose another objective.",
            {"kind": follower.kind},
        )
    sized = math.isfinite(asked.asked[1]) or any(
        limit.kind == "outer_radius" for limit in asked.limits
    )
    sized = sized or "base_radius" in kinds[: kinds.index("peak_pressure_angle") + 1]
    sized = sized or asked.reached[1] < asked.opened[1]  # by what it reaches
    if not sized:
        raise PydanticCustomError(
            "no_best_pressure_angle",
            "objective peak_pressure_angle has no best value while the cam may grow "
            "without end: every larger cam has a smaller pressure angle. Give "
            "base_radius_mm a max, limit outer_radius, or put base_radius before it.",
            {},
        )


def _check_smallest(asked: SizeProblem) -> None:
    """A free law can be bent so that any cam carries it: something has to end its shrinking."""
    kept = math.isfinite(asked.asked[0]) or any(limit.bounds_size_below for limit in asked.limits)
    why = asked.follower.reason_without_minimum
    if asked.free and why and not kept:
        raise PydanticCustomError(
            "no_smallest_cam",
            "objective base_radius has no best value here: nothing keeps the cam from shrinking "
            "to a point: {why}, its laws are free, and no limit speaks of its shape. Limit "
            "pressure_angle (30° to 45° are usual) or profile_radius, or give base_radius_mm a "
            "min.",
            {"why": why},
        )
