"""Peak memory of a call in a process of its own."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

STATUS = Path("/proc/self/status")
PEAK = "VmHWM:"
MIB = 1024.0**2
PROGRAM = """
from benchmarks import memory
{prepare}
before = memory.peak()
{measured}
print(before, memory.peak())
"""


def peak() -> float:
    """Largest resident size of this process so far [bytes].

    Linux tells it since the start of the program; elsewhere it is the system's record, which may
    be that of the parent before it.
    """
    if STATUS.exists():
        line = next(row for row in STATUS.read_text().splitlines() if row.startswith(PEAK))
        return 1024.0 * float(line.split()[1])
    import resource

    factor = 1.0 if sys.platform == "darwin" else 1024.0
    return factor * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def grown(prepare: str, measured: str) -> tuple[float, float]:
    """Peak before and after, of a program whose last step is ``measured`` [MiB]."""
    program = PROGRAM.format(prepare=prepare, measured=measured)
    ran = subprocess.run(
        [sys.executable, "-c", program], check=True, capture_output=True, text=True
    )
    before, after = map(float, ran.stdout.split())
    return before / MIB, after / MIB
