"""Databases of their own for the checks, each on a small disk, and what may happen to them."""

from __future__ import annotations

import contextlib
import os
import pwd
import shutil
import signal
import sqlite3
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import psycopg

from benchmarks import processes
from tests.service.postgres import PASSWORD, postgres

AWAY_S = 10.0  # that a store is not there
DISK = "400m"  # of the tmpfs that is filled: a new cluster of PostgreSQL takes some 60 MB
Fault = Callable[[], None]


class Store:
    """Where services keep what they have: what may happen to it, and what is in it."""

    url: str
    mounted: bool

    def faults(self) -> dict[str, Fault]:
        """What may happen to it."""
        raise NotImplementedError

    def rows(self, query: str) -> list[tuple[Any, ...]]:
        """What it answers."""
        raise NotImplementedError


@contextmanager
def small_disk() -> Iterator[tuple[Path, bool]]:
    """A folder on a disk of its own, and whether there is such a disk: this account may mount."""
    folder = Path(tempfile.mkdtemp(prefix="disk-"))
    mount = ["mount", "-t", "tmpfs", "-o", f"size={DISK},mode=777", "tmpfs", str(folder)]
    mounted = subprocess.run(mount, capture_output=True, check=False).returncode == 0
    folder.chmod(0o777)
    try:
        yield folder, mounted
    finally:
        if mounted:
            subprocess.run(["umount", "--lazy", str(folder)], check=False)
        shutil.rmtree(folder, ignore_errors=True)


def fill(disk: Path) -> Path:
    """Fill a disk to the last block; the file that fills it."""
    ballast = disk / "ballast"
    with contextlib.suppress(OSError), ballast.open("wb", buffering=0) as file:
        for size in (2**20, 4096):  # until a short write, or none
            with contextlib.suppress(OSError):
                while file.write(bytes(size)) == size:
                    pass
    return ballast


class Sqlite(Store):
    """A file."""

    def __init__(self, disk: Path, mounted: bool) -> None:
        self._disk, self.mounted = disk, mounted
        self.file = disk / "designs.db"
        self.url = f"sqlite:///{self.file}"

    def faults(self) -> dict[str, Fault]:
        return {"store away": self._lock} | ({"disk full": self._fill} if self.mounted else {})

    def _lock(self) -> None:
        with contextlib.closing(sqlite3.connect(self.file, timeout=60.0)) as database:
            database.isolation_level = None
            database.execute("begin exclusive")
            time.sleep(AWAY_S)
            database.execute("rollback")

    def _fill(self) -> None:
        ballast = fill(self._disk)
        time.sleep(AWAY_S)
        ballast.unlink()

    def rows(self, query: str) -> list[tuple[Any, ...]]:
        with contextlib.closing(sqlite3.connect(self.file, timeout=60.0)) as database:
            return database.execute(query).fetchall()


class Postgres(Store):
    """A server of its own, started again where it has ended."""

    def __init__(self, port: int, disk: Path, mounted: bool) -> None:
        self._disk, self.mounted, self._port = disk, mounted, port
        self._address = f"camwright:{PASSWORD}@127.0.0.1:{port}/camwright"
        self.url = f"postgresql+psycopg://{self._address}"
        self._again: subprocess.Popen[bytes] | None = None
        first = self._family()[0]
        words = Path(f"/proc/{first}/cmdline").read_bytes().split(b"\0")[:-1]
        self._command = [os.fsdecode(word) for word in words]
        account = pwd.getpwuid(Path(f"/proc/{first}").stat().st_uid).pw_name
        self._user = account if os.geteuid() == 0 else None
        self._where = Path(f"/proc/{first}/cwd").readlink()

    def faults(self) -> dict[str, Fault]:
        """What may happen to it."""
        known = {
            "store away": self._stop, "kill -9 of PostgreSQL": self._kill,
            "connections to the store cut": self._cut,
        }  # fmt: skip
        return known | ({"disk full": self._fill} if self.mounted else {})

    def _family(self) -> list[int]:
        """The server, then the processes that it has forked; none where it does not run."""
        for entry in Path("/proc").glob("[0-9]*"):
            with contextlib.suppress(OSError):
                words = (entry / "cmdline").read_bytes().split(b"\0")
                if f"port={self._port}".encode() in words and (entry / "exe").exists():
                    return processes.family(int(entry.name))
        return []

    def _stop(self) -> None:
        family = self._family()
        for process in family:
            os.kill(process, signal.SIGSTOP)
        time.sleep(AWAY_S)
        for process in family:
            os.kill(process, signal.SIGCONT)

    def _kill(self) -> None:
        first, *forked = self._family()
        os.kill(first, signal.SIGKILL)
        while any(Path(f"/proc/{each}/exe").exists() for each in forked):
            time.sleep(0.1)
        with contextlib.suppress(ChildProcessError):  # one that nobody waited for counts as alive
            os.waitpid(first, 0)
        self._start()

    def _fill(self) -> None:
        """On a full disk the server ends where it cannot write its log: it is started again."""
        ballast = fill(self._disk)
        time.sleep(AWAY_S)
        ballast.unlink()
        self._start()

    def _cut(self) -> None:
        for backend in self._family()[1:]:  # those of connections alone are ended by this
            with contextlib.suppress(OSError):
                if b"127.0.0.1" in Path(f"/proc/{backend}/cmdline").read_bytes():
                    os.kill(backend, signal.SIGTERM)

    def _start(self) -> None:
        """Until it takes connections: it ends at once where a process of the old one lives."""
        while not self._there():
            if not self._family():
                if self._again is not None:
                    self._again.wait(60.0)
                self._again = subprocess.Popen(
                    self._command, user=self._user, cwd=self._where, stdout=subprocess.DEVNULL,
                    stderr=subprocess.DEVNULL,
                )  # fmt: skip
            time.sleep(0.3)

    def _there(self) -> bool:
        try:
            with psycopg.connect(f"postgresql://{self._address}", connect_timeout=5) as there:
                return there.execute("select 1").fetchone() == (1,)
        except psycopg.Error:
            return False

    def rows(self, query: str) -> list[tuple[Any, ...]]:
        with psycopg.connect(f"postgresql://{self._address}") as connection:
            return connection.execute(query.encode()).fetchall()

    def close(self) -> None:
        """Stop the server where it was started again here."""
        if self._again is not None:
            self._again.send_signal(signal.SIGINT)
            self._again.wait(60.0)


@contextmanager
def opened(kind: str) -> Iterator[Store]:
    """The store of this kind: "sqlite" or "postgresql"."""
    with small_disk() as (disk, mounted):
        if kind == "sqlite":
            yield Sqlite(disk, mounted)
            return
        with postgres("camwright", "camwright", disk, fsync=True) as port:
            server = Postgres(port, disk, mounted)
            try:
                yield server
            finally:
                server.close()
