"""Measurements of speed. Each module exposes ``run() -> str``, its result as Markdown.

``python -m benchmarks`` runs them all, ``python -m benchmarks name …`` some of them, and
``python -m benchmarks --list`` says which there are.
"""

from __future__ import annotations

import gc
import statistics
from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter


@dataclass(frozen=True)
class Timing:
    """Seconds per call over repeated runs: median, and the quarter and three-quarter points."""

    median: float
    low: float
    high: float
    repeats: int

    def __str__(self) -> str:
        median, low, high = (1e3 * value for value in (self.median, self.low, self.high))
        return f"{median:.3f} ms ({low:.3f} to {high:.3f})"


def timed(call: Callable[[], object], repeats: int = 200, warm_up: int = 10) -> Timing:
    """Time ``call`` alone, after a few calls that do not count."""
    for _ in range(warm_up):
        call()
    seconds = []
    collecting = gc.isenabled()
    gc.disable()
    try:
        for _ in range(repeats):
            start = perf_counter()
            call()
            seconds.append(perf_counter() - start)
    finally:
        if collecting:
            gc.enable()
    low, median, high = statistics.quantiles(seconds, n=4)
    return Timing(median, low, high, repeats)
