"""Random faults while designs and sweeps are under way: nothing acknowledged is lost.

    python -m tests.hard.faults --store sqlite --faults 100 --singles 500 --sweeps 5

The core is the fake one, so that the faults and not the solving take the time. Faults: kill -9 of
the service, of a worker, of the process that workers are forked from, and of PostgreSQL; the store
away for 10 s; a full disk (SQLite; where this account may mount a tmpfs); a service that stands
still for longer than its lease; a connection cut in the middle of an answer. PostgreSQL is shared
by two services. At the end every acknowledged question must have its answer and every sweep each
item once: lost, doubled and stuck are printed, and the exit code is 1 where one is not 0.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import pwd
import random
import shutil
import signal
import socket
import sqlite3
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import httpx2
import psycopg

from benchmarks import processes
from tests.service.killing import Process, answering, children, free_port, service
from tests.service.postgres import PASSWORD, postgres
from tests.service.specs import spec
from tests.service.sweeps.test_sweeps import sweep_of

AWAY_S = 10.0  # that the store is not there
LEASE_S = 2.0
SETTLED_S = 240.0  # after the last fault, until what is not answered counts as stuck
DISK = "48m"  # of the tmpfs that is filled
BETWEEN_S = (0.2, 2.5)  # from the end of a fault to the next
ENDED = ("successful", "failed", "dismissed")
AGAIN = (413, 429, 503)  # 413: the service stood still while it read the body


class Store:
    """Where the services keep what they have: how it goes away, and what is in it."""

    url: str
    services = 1

    def faults(self) -> dict[str, Callable[[], None]]:
        """What may happen to it."""
        raise NotImplementedError

    def rows(self, query: str) -> list[tuple[Any, ...]]:
        """What it answers."""
        raise NotImplementedError


class Sqlite(Store):
    """A file, on a disk of its own where this account may mount one."""

    def __init__(self, folder: Path) -> None:
        self._disk = folder / "disk"
        self._disk.mkdir()
        mount = ["mount", "-t", "tmpfs", "-o", f"size={DISK}", "tmpfs", str(self._disk)]
        self.mounted = subprocess.run(mount, capture_output=True, check=False).returncode == 0
        self._file = self._disk / "designs.db"
        self.url = f"sqlite:///{self._file}"

    def faults(self) -> dict[str, Callable[[], None]]:
        return {"store away": self._lock} | ({"disk full": self._fill} if self.mounted else {})

    def _lock(self) -> None:
        with contextlib.closing(sqlite3.connect(self._file, timeout=30.0)) as database:
            database.isolation_level = None
            database.execute("begin exclusive")
            time.sleep(AWAY_S)
            database.execute("rollback")

    def _fill(self) -> None:
        ballast = self._disk / "ballast"
        with contextlib.suppress(OSError), ballast.open("wb") as file:
            while True:
                file.write(bytes(4096))
                file.flush()
        time.sleep(AWAY_S)
        ballast.unlink()

    def rows(self, query: str) -> list[tuple[Any, ...]]:
        with contextlib.closing(sqlite3.connect(self._file)) as database:
            return database.execute(query).fetchall()

    def close(self) -> None:
        """Unmount the disk."""
        if self.mounted:
            subprocess.run(["umount", str(self._disk)], check=False)


class Postgres(Store):
    """A server of its own; two services share it."""

    services = 2

    def __init__(self, port: int) -> None:
        self._address = f"camwright:{PASSWORD}@127.0.0.1:{port}/camwright"
        self.url, self._port = f"postgresql+psycopg://{self._address}", port
        self._again: subprocess.Popen[bytes] | None = None

    def faults(self) -> dict[str, Callable[[], None]]:
        return {"store away": self._stop, "kill -9 of PostgreSQL": self._kill}

    def _family(self) -> list[int]:
        """The server, then the processes that it has forked."""
        for entry in Path("/proc").glob("[0-9]*"):
            with contextlib.suppress(OSError):
                words = (entry / "cmdline").read_bytes().split(b"\0")
                if f"port={self._port}".encode() in words:
                    return processes.family(int(entry.name))
        raise AssertionError("PostgreSQL does not run")

    def _stop(self) -> None:
        family = self._family()
        for process in family:
            os.kill(process, signal.SIGSTOP)
        time.sleep(AWAY_S)
        for process in family:
            os.kill(process, signal.SIGCONT)

    def _kill(self) -> None:
        first, *forked = self._family()
        command = [
            os.fsdecode(word)
            for word in Path(f"/proc/{first}/cmdline").read_bytes().split(b"\0")[:-1]
        ]
        account = pwd.getpwuid(Path(f"/proc/{first}").stat().st_uid).pw_name
        where = Path(f"/proc/{first}/cwd").readlink()
        os.kill(first, signal.SIGKILL)
        while any(Path(f"/proc/{each}/exe").exists() for each in forked):
            time.sleep(0.1)
        with contextlib.suppress(ChildProcessError):  # one that nobody waited for counts as alive
            os.waitpid(first, 0)
        # Until it takes connections: it ends at once where a process of the old one still lives.
        while self._again is None or self._again.poll() is not None or not self._there():
            if self._again is None or self._again.poll() is not None:
                user = account if os.geteuid() == 0 else None
                self._again = subprocess.Popen(
                    command, user=user, cwd=where, stdout=subprocess.DEVNULL,
                    stderr=subprocess.DEVNULL,
                )  # fmt: skip
            time.sleep(0.3)

    def _there(self) -> bool:
        try:
            psycopg.connect(f"postgresql://{self._address}").close()
        except psycopg.OperationalError:
            return False
        return True

    def rows(self, query: str) -> list[tuple[Any, ...]]:
        with psycopg.connect(f"postgresql://{self._address}") as connection:
            return connection.execute(query.encode()).fetchall()

    def close(self) -> None:
        """Stop the server where it was started again here."""
        if self._again is not None:
            self._again.send_signal(signal.SIGINT)
            self._again.wait(60.0)


@contextmanager
def opened(kind: str, folder: Path) -> Iterator[Store]:
    """The store of this kind."""
    if kind == "sqlite":
        store = Sqlite(folder)
        try:
            yield store
        finally:
            store.close()
        return
    with postgres("camwright", "camwright") as port:
        server = Postgres(port)
        try:
            yield server
        finally:
            server.close()


class Asking:
    """Clients that post until what they posted is acknowledged, and remember that."""

    def __init__(self, ports: list[int], draw: random.Random) -> None:
        self._ports, self._draw = ports, draw
        self.designs: dict[str, dict[str, Any]] = {}  # by address, the spec
        self.sweeps: dict[str, int] = {}  # by address, the items
        self.statuses: Counter[int | str] = Counter()

    def ask(self, method: str, path: str, **more: Any) -> httpx2.Response:
        """Ask one of the services, until one answers otherwise than that it cannot now."""
        while True:
            try:
                url = f"http://127.0.0.1:{self._draw.choice(self._ports)}{path}"
                answer = httpx2.request(method, url, timeout=60.0, **more)
            except httpx2.TransportError as error:
                self.statuses[type(error).__name__] += 1
            else:
                self.statuses[answer.status_code] += 1
                failed = answer.status_code == 503 and "has failed" in answer.text
                if answer.status_code not in AGAIN or failed:
                    return answer
            time.sleep(0.2)

    def post_designs(self, count: int, until_s: float) -> None:
        """So many, evenly over this time."""
        for _ in range(count):
            body = spec(f"sleep {self._draw.uniform(0.05, 0.6):.3f}")
            answer = self.ask("POST", "/v1/designs", json=body, headers={"Prefer": "respond-async"})
            assert answer.status_code == 202, answer.text
            self.designs[answer.headers["location"]] = body
            time.sleep(until_s / count)

    def post_sweeps(self, count: int, items: int) -> None:
        """So many sweeps of so many items."""
        for number in range(count):
            names = [f"sleep {0.1 + 1e-4 * number + 1e-6 * i:.6f}" for i in range(items)]
            answer = self.ask("POST", "/v1/sweeps", json=sweep_of(names))
            assert answer.status_code in (200, 202), answer.text
            self.sweeps[json.loads(answer.content)["links"]["self"]] = items


class Services:
    """The services that share the store, each with its own port."""

    def __init__(self, folder: Path, store: Store, draw: random.Random) -> None:
        self.ports = [free_port() for _ in range(store.services)]
        self._draw, self.stopped = draw, threading.Event()
        more = {"CAMWRIGHT_DATABASE_URL": store.url, "CAMWRIGHT_LEASE_S": str(LEASE_S),
                "FAKE_CORE_LOG": str(folder / "log")}  # fmt: skip
        self.all: list[Process] = []
        for number, port in enumerate(self.ports):
            own = folder / f"service {number}"
            own.mkdir()
            self.all.append(service(own, port, **more))

    def supervise(self) -> None:
        """Start again whatever has ended, as Docker and systemd do."""
        while not self.stopped.wait(1.0):
            for each in self.all:
                if each.running.poll() is not None:
                    each.start()

    def wait(self) -> None:
        """Until all of them answer."""
        for port in self.ports:
            with httpx2.Client(base_url=f"http://127.0.0.1:{port}", timeout=60.0) as client:
                answering(client)

    def faults(self) -> dict[str, Callable[[], None]]:
        """What may happen to them."""
        return {
            "kill -9 of the service": self._kill, "kill -9 of a worker": self._kill_worker,
            "kill -9 of what forks": self._kill_forking, "stands still": self._stop,
            "connection cut": self._cut,
        }  # fmt: skip

    def _kill(self) -> None:
        self._draw.choice(self.all).kill()

    def _kill_worker(self) -> None:
        workers = children(self._draw.choice(self.all).running.pid)
        for worker in workers[:1]:
            os.kill(worker, signal.SIGKILL)

    def _kill_forking(self) -> None:
        family = processes.family(self._draw.choice(self.all).running.pid)
        workers = processes.workers(family)
        for forking in {int(Path(f"/proc/{each}/stat").read_text().rpartition(")")[2].split()[1])
                        for each in workers}:  # fmt: skip
            os.kill(forking, signal.SIGKILL)

    def _stop(self) -> None:
        chosen = self._draw.choice(self.all).running
        chosen.send_signal(signal.SIGSTOP)
        time.sleep(1.5 * LEASE_S)
        chosen.send_signal(signal.SIGCONT)

    def _cut(self) -> None:
        body = json.dumps(spec("sleep 0.3")).encode()
        head = f"POST /v1/designs HTTP/1.1\r\nHost: x\r\nContent-Length: {len(body)}\r\n"
        with (
            contextlib.suppress(OSError),
            socket.create_connection(
                ("127.0.0.1", self._draw.choice(self.ports)), 5.0
            ) as connection,
        ):
            connection.sendall(head.encode() + b"Content-Type: application/json\r\n\r\n" + body)
            connection.settimeout(self._draw.choice((0.1, 0.5)))
            connection.recv(100)


def judge(asking: Asking, store: Store, settled_s: float) -> int:
    """Wait for all answers; print what is lost, doubled, stuck and failed; how many there are."""
    until, waiting = time.monotonic() + settled_s, {*asking.designs, *asking.sweeps}
    lost, failed = set[str](), dict[str, str]()
    while waiting and time.monotonic() < until:
        for where in list(waiting):
            answer = asking.ask("GET", where)
            if answer.status_code == 404:
                lost.add(where)
            elif answer.status_code >= 400:
                failed[where] = answer.text
            elif answer.status_code == 202 or (
                where in asking.sweeps and answer.json()["state"] not in ENDED
            ):
                continue
            elif where in asking.sweeps and answer.json()["state"] != "successful":
                failed[where] = answer.text
            waiting.discard(where)
        time.sleep(0.5)
    rows = store.rows("select id from answers")
    twice = len(rows) - len(set(rows))
    items = store.rows("select sweep, number, status from sweep_items")
    twice += len(items) - len({(sweep, number) for sweep, number, _ in items})
    expected = sum(asking.sweeps.values())
    states = Counter(status for _, _, status in items)
    # Each answer is that of its question, and asking again gives the same.
    for where, body in random.Random(0).sample(
        sorted(asking.designs.items()), min(20, len(asking.designs))
    ):
        again = asking.ask("POST", "/v1/designs", json=body)
        assert again.headers["content-location"] == where
        assert again.content == asking.ask("GET", where).content
    owned = store.rows("select count(*) from answers where owner is not null")[0][0]
    print(f"designs {len(asking.designs)}, sweeps {len(asking.sweeps)} with {expected} items")
    print(f"items {dict(states)}; answers of the service {dict(asking.statuses)}")
    print(f"lost {len(lost) + max(0, expected - len(items))}, doubled {twice}, "
          f"stuck {len(waiting)}, failed {len(failed)}, leases left {owned}")  # fmt: skip
    for where, text in list(failed.items())[:5]:
        print(f"  {where}: {text[:300]}")
    for where in list(waiting)[:5]:
        print(f"  stuck: {where}")
    bad = states.get("failed", 0) + len(failed)
    return len(lost) + twice + len(waiting) + bad + max(0, expected - len(items))


def main() -> int:
    """Faults in random order until there were enough; 0 where nothing is lost."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--store", choices=("sqlite", "postgresql"), default="sqlite")
    for name, default in (("faults", 100), ("singles", 500), ("sweeps", 5), ("items", 200),
                          ("seed", 1)):  # fmt: skip
        parser.add_argument(f"--{name}", type=int, default=default)
    chosen = parser.parse_args()
    draw, folder = random.Random(chosen.seed), Path(tempfile.mkdtemp(prefix="faults-"))
    with ExitStack() as stack:
        stack.callback(shutil.rmtree, folder, ignore_errors=True)
        store = stack.enter_context(opened(chosen.store, folder))
        services = Services(folder, store, draw)
        for each in services.all:
            stack.callback(each.stop)
        services.wait()
        supervisor = threading.Thread(daemon=True, target=services.supervise)
        supervisor.start()
        stack.callback(supervisor.join)
        stack.callback(services.stopped.set)
        asking = Asking(services.ports, draw)
        posting = [
            threading.Thread(
                daemon=True, target=asking.post_sweeps, args=(chosen.sweeps, chosen.items)
            ),
            threading.Thread(
                daemon=True, target=asking.post_designs, args=(chosen.singles, 3.0 * chosen.faults)
            ),
        ]
        for each in posting:
            each.start()
        faults = {**services.faults(), **store.faults()}
        done, started = Counter[str](), time.monotonic()
        for number in range(chosen.faults):
            time.sleep(draw.uniform(*BETWEEN_S))
            # Each kind in turn, in a new random order for every round.
            if number % len(faults) == 0:
                order = draw.sample(sorted(faults), len(faults))
            name = order[number % len(faults)]
            if name not in store.faults():  # these may meet a service that starts
                services.wait()
            faults[name]()
            done[name] += 1
        for each in posting:
            each.join()
        print(f"{chosen.store}: {chosen.faults} faults in {time.monotonic() - started:.0f} s, "
              f"seed {chosen.seed}: {dict(done)}")  # fmt: skip
        sys.stdout.flush()
        return min(judge(asking, store, SETTLED_S), 1)


if __name__ == "__main__":
    sys.exit(main())
