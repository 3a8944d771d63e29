"""Time to import the library: by itself, with the spec, and with everything a design needs."""

from __future__ import annotations

import statistics
import subprocess
import sys

REPEATS = 9
CASES = {
    "`import synthesis`": "import synthesis",
    "and `DesignSpec`": "from synthesis import DesignSpec",
    "and `synthesise`": "from synthesis import synthesise",
}
MEASURE = "import time; t = time.perf_counter(); {}; print(time.perf_counter() - t)"


def run() -> str:
    """Markdown table."""
    lines = ["### Importing the library", "", "| what | median | slowest |", "|---|---|---|"]
    for name, statement in CASES.items():
        seconds = [_once(statement) for _ in range(REPEATS)]
        median, slowest = statistics.median(seconds), max(seconds)
        lines.append(f"| {name} | {median:.3f} s | {slowest:.3f} s |")
    return "\n".join(lines)


def _once(statement: str) -> float:
    command = [sys.executable, "-c", MEASURE.format(statement)]
    return float(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
