"""Times of calls: medians with their quartiles, and several calls beside each other.

Calls that are to be compared take turns, so that whatever else the machine does falls on all of
them alike; then ratios of their medians mean more than the times themselves.
"""

from __future__ import annotations

import gc
import random
import statistics
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from time import perf_counter

Call = Callable[[], object]


@dataclass(frozen=True)
class Timing:
    """Seconds of a call's runs, in their order."""

    seconds: tuple[float, ...]

    @property
    def median(self) -> float:
        """Half of the runs took longer."""
        return statistics.median(self.seconds)

    @property
    def low(self) -> float:
        """A quarter of the runs took less."""
        return _quartiles(self.seconds)[0]

    @property
    def high(self) -> float:
        """A quarter of the runs took more."""
        return _quartiles(self.seconds)[2]

    def __str__(self) -> str:
        return spread(self.median, self.low, self.high)

    def over(self, other: Timing) -> str:
        """How many times the other's: of the medians, and the quartiles of the rounds' ratios."""
        rounds = [a / b for a, b in zip(self.seconds, other.seconds, strict=True)]
        low, _, high = _quartiles(rounds)
        return f"{_short(self.median / other.median)} ({_short(low)} to {_short(high)})"


def _quartiles(values: Sequence[float]) -> list[float]:
    several = values if len(values) > 1 else [*values, *values]
    return statistics.quantiles(several, n=4, method="inclusive")


def _short(ratio: float) -> str:
    return f"{ratio:.0f}" if ratio >= 20.0 else f"{ratio:.1f}" if ratio >= 2.0 else f"{ratio:.2f}"


def spread(median: float, low: float, high: float) -> str:
    """Seconds for people, quartiles beside the median, all three in one unit and as exact."""
    factor, unit = (1e3, "ms") if median < 1.0 else (1.0, "s")
    shown = median * factor
    decimals = 3 if shown < 1.0 else 2 if shown < 10.0 else 1 if shown < 100.0 else 0
    ends = f"{low * factor:.{decimals}f} to {high * factor:.{decimals}f}"
    return f"{shown:.{decimals}f} {unit} ({ends})"


def timed(call: Call, repeats: int = 200, warm_up: int = 10) -> Timing:
    """Time ``call`` alone, after a few calls that do not count."""
    return in_turns({"": call}, repeats, warm_up)[""]


def in_turns(calls: Mapping[str, Call], repeats: int, warm_up: int = 1) -> dict[str, Timing]:
    """Time several calls that take turns, after a few rounds that do not count.

    Each round has another order, so that none always runs after the same one.
    """
    for _ in range(warm_up):
        for call in calls.values():
            call()
    seconds: dict[str, list[float]] = {name: [] for name in calls}
    order = random.Random(1)
    with _no_collecting():
        for _ in range(repeats):
            for name, call in order.sample(list(calls.items()), len(calls)):
                start = perf_counter()
                call()
                seconds[name].append(perf_counter() - start)
    return {name: Timing(tuple(times)) for name, times in seconds.items()}


@contextmanager
def _no_collecting() -> Iterator[None]:
    """Without the collector, which would fall on whichever call it likes."""
    collecting = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        yield
    finally:
        if collecting:
            gc.enable()
