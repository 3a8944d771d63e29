"""Questions without an answer.

No cam is the best one, a limit speaks of what is infinite, or rounding hides the motion.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from pydantic_core import PydanticCustomError

from synthesis.catalogue.constraints import Ends
from synthesis.catalogue.fields import named_lengths
from synthesis.catalogue.followers import Follower
from synthesis.catalogue.limits import Limit, Machine
from synthesis.catalogue.motion import Segments
from synthesis.catalogue.objectives import Objective

JERK = 3  # order of the derivative
LARGEST_RATIO = 1e9  # of a length to the stroke: numbers of the problem are rounded to 1e-11


def check_size_ratio(follower: Follower, requested: Ends, stroke: float) -> None:
    """Refuse lengths [mm] so far above the stroke that rounding errors are as large as the motion.

    ``requested``: base radii. What leaves a range open towards small lengths is no such length.
    """
    named = [("base_radius_mm", *requested), *named_lengths(follower)]
    for field, low, high in named:
        if max(low, -high) > LARGEST_RATIO * stroke:
            sign = "=" if low == high else "≥" if low > 0.0 else "≤"
            raise PydanticCustomError(
                "length_beyond_stroke",
                "{field} {sign} {length} mm is over a billion times the stroke, which is {stroke} "
                "mm: numbers of 16 digits do not tell such a motion from rounding errors. Check "
                "the units of the two.",
                {"field": field, "sign": sign, "length": f"{low if low > 0.0 else high:.6g}",
                 "stroke": f"{stroke:.6g}"},
            )  # fmt: skip


def check_growth_ends(
    follower: Follower,
    limits: Sequence[Limit],
    objectives: Sequence[Objective],
    requested: Ends,
    searched: Ends,
    reached: Ends,
) -> None:
    """Refuse a least pressure angle of a cam that may grow: a larger cam has a smaller one.

    Base radii [mm] are requested, open ends infinite; searched, open ends replaced; and, in part,
    reached by the follower.
    """
    kinds = [objective.kind for objective in objectives]
    if "peak_pressure_angle" not in kinds:
        return
    curves = follower.pressure_angle_constraints(1.0)
    if not curves and all(row.is_constant for row in follower.pressure_angle_rows(1.0)):
        raise PydanticCustomError(
            "pressure_angle_given",
            "objective peak_pressure_angle is not offered for a {kind} follower: its face "
            "settles the pressure angle. Choose another objective.",
            {"kind": follower.kind},
        )
    if not (
        math.isfinite(requested[1])
        or any(limit.kind == "outer_radius" for limit in limits)
        or "base_radius" in kinds[: kinds.index("peak_pressure_angle")]
        or reached[1] < searched[1]
    ):
        raise PydanticCustomError(
            "no_best_pressure_angle",
            "objective peak_pressure_angle has no best value while the cam may grow "
            "without end: every larger cam has a smaller pressure angle. Give "
            "base_radius_mm a max, limit outer_radius, or put base_radius before it.",
        )


def check_shrinking_ends(
    follower: Follower, limits: Sequence[Limit], requested: Ends, *, law_is_free: bool
) -> None:
    """Refuse a least base radius of a cam that may shrink: a free law can be bent to any cam."""
    kept = math.isfinite(requested[0]) or any(limit.bounds_size_below for limit in limits)
    why = follower.reason_without_minimum
    if law_is_free and why and not kept:
        raise PydanticCustomError(
            "no_smallest_cam",
            "objective base_radius has no best value here: nothing keeps the cam from shrinking "
            "to a point: {why}, its laws are free, and no limit speaks of its shape. Limit "
            "pressure_angle (30° to 45° are usual) or profile_radius, or give base_radius_mm a "
            "min.",
            {"why": why},
        )


def check_jerk_finite(
    segments: Segments,
    limits: Sequence[tuple[str, Limit]],
    objectives: Sequence[Objective],
    machine: Machine,
) -> None:
    """Refuse a spline of class C1 where something speaks of jerk, which is infinite there.

    Limits come with their names for people.
    """
    for segment in segments:
        if segment.free is None or segment.free.smoothness >= JERK - 1:
            continue
        # What has a row on the jerk of this segment, or makes its mean square small.
        rows = [(name, limit.rows(segment, machine)) for name, limit in limits]
        rows += [(f"objective {aim.kind}", aim.rows(segment, machine, 1.0)) for aim in objectives]
        of_jerk = [name for name, own in rows if any(row.coefficients[JERK] for row in own)]
        of_jerk += [f"objective {aim.kind}" for aim in objectives if aim.energy_order() == JERK]
        if of_jerk:
            raise PydanticCustomError(
                "spline_too_rough",
                "program/{position} is a spline of smoothness {value}, whose acceleration may "
                "jump, but {name} speaks of jerk, which is infinite there. Take smoothness 2, or "
                "leave {name} out.",
                {"position": segment.index, "value": segment.free.smoothness, "name": of_jerk[0]},
            )
