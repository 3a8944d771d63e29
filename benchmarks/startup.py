"""Time to import the library: by itself, with the spec, and with everything a design needs."""

from __future__ import annotations

import subprocess
import sys

from benchmarks.effort import FULL, Effort
from benchmarks.section import Section, Table
from benchmarks.timing import Timing

CASES = {
    "`import synthesis`": "import synthesis",
    "and `DesignSpec`": "from synthesis import DesignSpec",
    "and `synthesise`": "from synthesis import synthesise",
}
MEASURE = "import time; t = time.perf_counter(); {}; print(time.perf_counter() - t)"


def run(effort: Effort = FULL) -> Section:
    """Each in processes of its own, taking turns."""
    cases = dict(effort.some(list(CASES.items())))
    seconds: dict[str, list[float]] = {name: [] for name in cases}
    for _ in range(effort.repeats(9)):
        for name, statement in cases.items():
            seconds[name].append(_once(statement))
    rows = [(name, str(Timing(tuple(times)))) for name, times in seconds.items()]
    text = "What a fresh process waits for before its first design."
    return Section("Importing the library", text, [Table(("what", ">time"), rows)])


def _once(statement: str) -> float:
    command = [sys.executable, "-c", MEASURE.format(statement)]
    return float(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
