"""Laws whose acceleration may jump, and questions about jerk: they do not go together."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from pydantic_core import PydanticCustomError

from synthesis.catalogue.limits import Limit, Machine
from synthesis.catalogue.motion import PlacedSegment
from synthesis.catalogue.objectives import Objective

JERK = 3


def check_jerk_finite(
    segments: Iterable[PlacedSegment],
    limits: Iterable[tuple[str, Limit]],
    objectives: Iterable[Objective],
    machine: Machine,
) -> None:
    """Refuse a spline of class C1 where something speaks of jerk, which is infinite there.

    Args:
        segments: the program on the cam. machine: the machine.
        limits: what may not be exceeded, each with its name for people. objectives: in order.

    Raises:
        PydanticCustomError: with the segment and what speaks of jerk.
    """
    rough = [s for s in segments if s.free is not None and s.free.smoothness < JERK - 1]
    for segment in rough:
        for name in _of_jerk(segment, limits, objectives, machine):
            raise PydanticCustomError(
                "spline_too_rough",
                "program/{position} is a spline of smoothness {value}, whose acceleration may "
                "jump, but {name} speaks of jerk, which is infinite there. Take smoothness 2, or "
                "leave {name} out.",
                {"position": segment.index, "value": segment.free.smoothness
                 if segment.free is not None else 0, "name": name},
            )  # fmt: skip


def _of_jerk(
    segment: PlacedSegment,
    limits: Iterable[tuple[str, Limit]],
    objectives: Iterable[Objective],
    machine: Machine,
) -> Iterator[str]:
    """Names of what has a row on the jerk of this segment, or makes its mean square small."""
    for name, limit in limits:
        if any(row.coefficients[JERK] != 0.0 for row in limit.rows(segment, machine)):
            yield name
    for objective in objectives:
        rows = objective.rows(segment, machine, 1.0)
        if objective.energy_order() == JERK or any(row.coefficients[JERK] != 0.0 for row in rows):
            yield f"objective {objective.kind}"
