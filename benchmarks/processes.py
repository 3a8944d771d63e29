"""Memory of a running service: its own process and those of its workers, as Linux counts it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

PROC = Path("/proc")
FORKS = "multiprocessing.forkserver"  # what the command line of a process and of its forks says
KIB = 1 / 1024.0


@dataclass(frozen=True)
class Memory:
    """Of one process [MiB].

    Attributes:
        resident: now, pages that it shares with others counted in full; peak: the most so far.
        share: now, of a page shared by n processes 1/n: these add up.
    """

    resident: float
    peak: float
    share: float


def there() -> bool:
    """Whether this system tells it."""
    return (PROC / "self" / "smaps_rollup").exists()


def of(process: int) -> Memory:
    """What a process takes now."""
    status = _fields(PROC / str(process) / "status")
    rollup = _fields(PROC / str(process) / "smaps_rollup")
    return Memory(status["VmRSS"] * KIB, status["VmHWM"] * KIB, rollup["Pss"] * KIB)


def _fields(file: Path) -> dict[str, float]:
    """Sizes of one of these files [KiB]."""
    lines = (line.partition(":") for line in file.read_text().splitlines())
    return {
        name: float(reported.split()[0]) for name, _, reported in lines if reported.endswith(" kB")
    }


def family(process: int) -> list[int]:
    """A process and all that it has started, directly or not."""
    parents, found = _parents(), [process]
    for each in found:  # grows while it is gone through
        found += [child for child, parent in parents.items() if parent == each]
    return found


def workers(processes: Sequence[int]) -> list[int]:
    """Those of them that do the solving: forked off one that holds the core."""
    parents, forking = _parents(), {each for each in processes if FORKS in _command(each)}
    return [each for each in processes if each in forking and parents.get(each) in forking]


def _parents() -> dict[int, int]:
    """Of each process of the system its parent."""
    parents = {}
    for entry in PROC.glob("[0-9]*/stat"):
        try:
            reported = entry.read_text().rpartition(")")[2].split()
        except OSError:  # ended meanwhile
            continue
        parents[int(entry.parent.name)] = int(reported[1])
    return parents


def _command(process: int) -> str:
    try:
        return (PROC / str(process) / "cmdline").read_text()
    except OSError:
        return ""
