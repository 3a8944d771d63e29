"""A clock that may be set, for processes that are started under it; the monotonic one goes on."""

from __future__ import annotations

import os
import struct
import subprocess
from pathlib import Path

HOUR_S = 3600
# Put before the C library: what asks for the time gets that of the kernel, and what is in the file.
SOURCE = r"""
#define _GNU_SOURCE
#include <fcntl.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

static volatile long *ahead;

__attribute__((constructor)) static void begin(void) {
    int file = open(getenv("CLOCK_AHEAD"), O_RDONLY);
    ahead = mmap(0, sizeof *ahead, PROT_READ, MAP_SHARED, file, 0);
    close(file);
}

int clock_gettime(clockid_t which, struct timespec *now) {
    int failed = syscall(SYS_clock_gettime, which, now);
    if (!failed && which == CLOCK_REALTIME && ahead) now->tv_sec += *ahead;
    return failed;
}

int gettimeofday(struct timeval *now, void *zone) {
    struct timespec fine;
    clock_gettime(CLOCK_REALTIME, &fine);
    now->tv_sec = fine.tv_sec;
    now->tv_usec = fine.tv_nsec / 1000;
    return 0;
}

time_t time(time_t *now) {
    struct timespec fine;
    clock_gettime(CLOCK_REALTIME, &fine);
    if (now) *now = fine.tv_sec;
    return fine.tv_sec;
}
"""


class Clock:
    """The clock of every process that is started from here on; it needs a C compiler."""

    def __init__(self, folder: Path) -> None:
        self._file, self._ahead_s = folder / "ahead", 0
        self._file.write_bytes(struct.pack("l", 0))
        source, library = folder / "clock.c", folder / "clock.so"
        source.write_text(SOURCE, encoding="ascii")
        subprocess.run(["cc", "-shared", "-fPIC", "-O2", "-o", library, source], check=True)
        folder.chmod(0o755)  # PostgreSQL has an account of its own
        os.environ |= {"LD_PRELOAD": str(library), "CLOCK_AHEAD": str(self._file)}

    def set_by_an_hour(self) -> None:
        """Forward, or back again."""
        self._ahead_s = HOUR_S - self._ahead_s
        with self._file.open("r+b") as file:
            file.write(struct.pack("l", self._ahead_s))
