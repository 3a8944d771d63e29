"""Why a solver stopped, in one vocabulary. What the point is worth is measured elsewhere."""

from enum import Enum


class StopReason(Enum):
    """Reason of a stop; a word that a table does not know means FAILED."""

    SOLVED = "solved"
    INACCURATE = "solved to reduced accuracy"
    INFEASIBLE = "infeasible"
    UNBOUNDED = "unbounded"
    OUT_OF_TIME = "out of time"
    OUT_OF_ITERATIONS = "out of iterations"
    FAILED = "failed"
    NOT_NEEDED = "not needed"


USABLE = (StopReason.SOLVED, StopReason.INACCURATE)
"""Stops that leave a point worth looking at."""
