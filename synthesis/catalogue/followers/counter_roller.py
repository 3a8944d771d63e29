"""Functions that place the counter roller of conjugate cams.

A pair of conjugate cams has a second roller on the same follower. Its place may be left free: then
the main cam is sized without it, and the place is fixed afterwards. All of this is the closure's
matter; a follower without a counter roller has a closure that answers with nothing.
"""

from __future__ import annotations

from collections.abc import Mapping

from synthesis.catalogue.followers.base import Follower
from synthesis.catalogue.followers.flank import CounterRollerRange
from synthesis.catalogue.ranges import Range


def counter_paths(follower: Follower) -> tuple[str, ...]:
    """Names of the traced curves of counter rollers."""
    return follower.active_closure.counter_paths


def counter_dimensions(follower: Follower) -> Mapping[str, tuple[str, float | Range | None]]:
    """Dimensions fixed after the size: by field, name among the dimensions and requested value."""
    return follower.active_closure.counter_dimensions()


def counter_range(follower: Follower, z: tuple[float, ...], s_max: float) -> CounterRollerRange:
    """Where a counter roller can be for a size z and displacements up to ``s_max``."""
    return follower.active_closure.counter_range(follower, z, s_max)


def with_free_counter(follower: Follower) -> Follower:
    """The follower with the place of its counter roller left free."""
    return follower.with_closure(follower.active_closure.with_free_counter())


def without_free_counter(follower: Follower) -> Follower:
    """The follower without a counter roller whose place is still free."""
    return follower.with_closure(follower.active_closure.without_free_counter())


def counter_only(follower: Follower, values: Mapping[str, float]) -> Follower:
    """The follower with the flanks of its counter roller alone, at the place in ``values``."""
    return follower.with_closure(follower.active_closure.counter_only(values))


def with_counter(follower: Follower, values: Mapping[str, float]) -> Follower:
    """The follower with its counter roller at a place, by the names of the dimensions."""
    return follower.with_closure(follower.active_closure.with_counter(values))
