"""Tables of displacement over cam angle: what makes sense of one, and how it is read."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from pydantic_core import PydanticCustomError

from synthesis.catalogue.motion import SegmentKind
from synthesis.numerics.piecewise import Array

FEWEST, MOST = 4, 20_000
SAME_ANGLE = 1e-9  # deg: where a table begins and ends
WHOLE_TURN = 360.0


@lru_cache(maxsize=64)
def read(
    points: tuple[tuple[float, float], ...] | None,
    angles: tuple[float, ...] | None,
    displacements: tuple[float, ...] | None,
    angle: float,
    lift: float | None,
) -> tuple[Array, Array, float]:
    """Where the rows are, as fractions of the segment, what they say, and the lift: (m,), (m,).

    Displacement counts from the segment's start, so that the first and the last row miss its two
    ends by the same amount.

    Args:
        points, angles, displacements: as for ``columns``.
        angle: of the segment [deg].
        lift: what it is meant to gain; None: last row less first row, on a whole turn 0.
    """
    degrees, s = columns(points, angles, displacements)
    check(degrees, angle)
    degrees, s = closed(degrees, s, angle)
    own = 0.0 if angle >= WHOLE_TURN else float(s[-1] - s[0])
    gained = own if lift is None else lift
    return degrees / degrees[-1], s - (s[0] + s[-1] - gained) / 2.0, gained


def columns(
    points: Sequence[tuple[float, float]] | None,
    angles: Sequence[float] | None,
    displacements: Sequence[float] | None,
) -> tuple[Array, Array]:
    """The two columns [deg, mm], from rows or from columns.

    Raises:
        PydanticCustomError: neither or both are given, or columns of unequal length.
    """
    by_rows, by_columns = points is not None, angles is not None or displacements is not None
    if by_rows == by_columns or (angles is None) != (displacements is None):
        raise PydanticCustomError(
            "table_columns",
            "A table is given once: as points, or as angles_deg with displacements_mm (on an arm "
            "displacements_deg). "
            "Give one of the two.",
            {},
        )
    if points is not None:
        table = np.array(points, dtype=float).reshape(-1, 2)
        return table[:, 0], table[:, 1]
    one, other = np.array(angles, dtype=float), np.array(displacements, dtype=float)
    if len(one) != len(other):
        raise PydanticCustomError(
            "table_columns",
            "{angles} angles_deg stand beside {displacements} displacements. "
            "Give as many of one as of the other.",
            {"angles": len(one), "displacements": len(other)},
        )
    return one, other


def check(degrees: Array, angle: float) -> None:
    """Angles must increase, and span the segment from its start to its end.

    Raises:
        PydanticCustomError: with the number of the first row that breaks the rule, from 0.
    """
    if not FEWEST <= len(degrees) <= MOST:
        raise PydanticCustomError(
            "table_size",
            "A table of {count} rows cannot be read: it takes {fewest} to {most}. "
            "Give more rows, or a named law; or leave some out.",
            {"count": len(degrees), "fewest": FEWEST, "most": MOST},
        )
    for row in np.flatnonzero(np.diff(degrees) <= 0.0)[:1] + 1:
        again = degrees[row] == degrees[row - 1]
        raise PydanticCustomError(
            "table_order",
            "{angle}° in row {row} does not come after the {before}° of the row before. {remedy}",
            {"angle": float(degrees[row]), "row": int(row), "before": float(degrees[row - 1]),
             "remedy": "Remove one of the two rows." if again else "Sort the rows by angle."},
        )  # fmt: skip
    outside = (degrees < -SAME_ANGLE) | (degrees > angle + SAME_ANGLE)
    for row in np.flatnonzero(outside)[:1]:
        raise PydanticCustomError(
            "table_outside",
            "{angle}° in row {row} lies outside the segment, which runs from 0° to {end}°. "
            "Count angles from the segment's start, or remove the row.",
            {"angle": float(degrees[row]), "row": int(row), "end": angle},
        )
    last = angle if angle < WHOLE_TURN - SAME_ANGLE else float(degrees[-1])
    for row, end in ((0, 0.0), (len(degrees) - 1, last)):
        if abs(degrees[row] - end) > SAME_ANGLE:
            raise PydanticCustomError(
                "table_ends",
                "{angle}° in row {row} should be {end}°: a table begins at 0° and ends at its "
                "angle_deg. Add a row there (on a whole turn the last one may be missing).",
                {"angle": float(degrees[row]), "row": row, "end": end},
            )


def closed(degrees: Array, displacements: Array, angle: float) -> tuple[Array, Array]:
    """The table of a whole turn with its first row repeated at the end, if that is missing."""
    if angle - degrees[-1] <= SAME_ANGLE:
        return degrees, displacements
    return np.append(degrees, angle), np.append(displacements, displacements[0])


def sense(displacements: Array, tolerance: float) -> SegmentKind:
    """Whether a table rises, returns or stands still but for its tolerance; or turns back."""
    rising = np.max(np.maximum.accumulate(displacements) - displacements) <= 2.0 * tolerance
    falling = np.max(displacements - np.minimum.accumulate(displacements)) <= 2.0 * tolerance
    if rising and falling:
        return "dwell"
    return "rise" if rising else "return" if falling else "table"


def check_tolerance(length: float | None, angle: float | None) -> None:
    """A table has a tolerance, in one unit.

    Raises:
        PydanticCustomError: there is none.
    """
    if length is None and angle is None:
        raise PydanticCustomError(
            "table_tolerance",
            "A table needs a tolerance: how far the motion may pass a row. "
            "Give tolerance_mm for a follower that slides, or tolerance_deg for one on an arm.",
            {},
        )


def check_lift(own: float, asked: float, tolerance: float) -> None:
    """What is asked of the lift may differ from the table's own by its tolerance at both ends.

    Raises:
        PydanticCustomError: it differs by more.
    """
    error = abs(own - asked)
    if error > 2.0 * tolerance:
        raise PydanticCustomError(
            "table_lift",
            "{error} lie between the lift of the table, {lift}, and the one asked for: more than "
            "twice its tolerance. Correct the lift or the table; a table of a whole turn ends "
            "where it begins.",
            {"error": error, "lift": own},
        )


def check_range(moved: float, tolerance: float) -> None:
    """A table moves by more than its tolerance.

    Raises:
        PydanticCustomError: it does not.
    """
    if moved <= 2.0 * tolerance:
        raise PydanticCustomError(
            "table_still",
            "{range} is all that the table moves, within its tolerance. "
            "Use a dwell, or a smaller tolerance.",
            {"range": moved},
        )
