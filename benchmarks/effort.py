"""How much a run of the benchmarks may take: all of it, or a trial that only shows they work."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

T = TypeVar("T")


@dataclass(frozen=True)
class Effort:
    """All sizes and repeats, or in a trial the first size of each list, once."""

    trial: bool = False

    def repeats(self, count: int) -> int:
        """How often to repeat what should be repeated ``count`` times."""
        return 1 if self.trial else count

    def warm_up(self, count: int) -> int:
        """How many calls go before those that count."""
        return 0 if self.trial else count

    def some(self, sizes: Sequence[T], least: int = 1) -> Sequence[T]:
        """Those to be run; ``least``: how many a trial needs."""
        return sizes[:least] if self.trial else sizes


FULL, TRIAL = Effort(), Effort(trial=True)
