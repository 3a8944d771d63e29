"""How much memory a process may take: the kernel refuses it more, and it ends by itself."""

from __future__ import annotations

import os
from pathlib import Path

MIB = 2**20  # bytes
PROC = Path("/proc")
CGROUP = Path("/sys/fs/cgroup/memory.max")  # what a container may have
RESERVE = 0.95  # of the memory: the rest is for all else; the share that Dask's nannies leave too
# Beyond what a new process has, at least: the largest file, a datasheet as PDF, takes 190 MiB.
LEAST = 256 * MIB
SPENT = 77  # status of a process that has ended for lack of memory; no other ends with it


def memory_of_this_machine() -> int:
    """Memory [bytes] of the machine, or of the container; 0 where the system does not tell."""
    if not PROC.exists():
        return 0
    whole = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    limit = CGROUP.read_text().strip() if CGROUP.exists() else "max"
    return min(whole, int(limit)) if limit.isdecimal() else whole


def share_of_memory(workers: int) -> int:
    """What each of so many workers may take [bytes]: no core is to have more; 0: no limit."""
    return int(memory_of_this_machine() * RESERVE / max(workers, os.cpu_count() or 1))


def limit_memory(most: int) -> None:
    """Let this process have so much [bytes]: then what it asks for is refused; 0: no limit.

    Counted is what is its own and can be written (RLIMIT_DATA): libraries, which all share, are
    not. What does not catch the refusal, such as a compiled solver, aborts.
    """
    if most and PROC.exists():
        import resource

        pages = int((PROC / "self/statm").read_text().split()[5])
        most = max(most, pages * os.sysconf("SC_PAGE_SIZE") + LEAST)
        resource.setrlimit(resource.RLIMIT_DATA, (most, most))


def needed_more(most: int) -> str:
    """What is said of a process that has ended so."""
    return f"needed more than {most / MIB:.0f} MiB of memory and was stopped"
