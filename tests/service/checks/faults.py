"""Random faults while designs and sweeps are under way: nothing acknowledged is lost.

    python -m tests.service.checks.faults --store sqlite --faults 100 --singles 500 --sweeps 5

Two services share the store: one with workers of its own, one with those of a Dask scheduler. The
core is the fake one, so that the faults and not the solving take the time; `--core real` asks the
real one. Faults: kill -9 of a service, of a worker, of the process that workers are forked from, of
the scheduler, of a worker of its, and of PostgreSQL; its connections ended; the store away for
10 s; a full disk (where this account may mount a tmpfs); a service that stands still for longer
than its lease; a connection cut in the middle of an answer; with `--clock` (which needs a C
compiler) the clock of all of them set forward by an hour, or back again. Everything is started
again, as Docker and systemd do. At the end every acknowledged question must have its answer and
every sweep each item once, as its owner sees them over HTTP: lost, doubled, stuck, failed and wrong
are printed, and the exit code is 1 where one of them is not 0.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import random
import shutil
import signal
import socket
import sys
import tempfile
import threading
import time
from collections import Counter
from contextlib import ExitStack
from pathlib import Path

import httpx2

from benchmarks import processes
from service.workers.scheduler import make_certificate
from tests.service.checks.asking import Asking, FakeWork, RealWork, judge
from tests.service.checks.clock import Clock
from tests.service.checks.stores import Fault, Store, opened
from tests.service.fake_core import LOG
from tests.service.killing import Process, answering, children, free_port, service
from tests.service.workers.test_remote import cluster_of

LEASE_S = 2.0
SETTLED_S = 240.0  # after the last fault, until what is not answered counts as stuck
BETWEEN_S = (0.2, 2.5)  # from the end of a fault to the next
PACE_S = 3.0  # by fault, over which designs are posted


class Services:
    """Services that share the store, and the cluster of the second; each started again."""

    def __init__(
        self, folder: Path, store: Store, draw: random.Random, real: bool, count: int
    ) -> None:
        self.ports, scheduler = [free_port() for _ in range(count)], free_port()
        self._draw, self.stopped = draw, threading.Event()
        certificate = folder / "cluster.pem"
        make_certificate(certificate)
        cluster = {**cluster_of(certificate), LOG: str(folder / "log")}
        address = f"tls://127.0.0.1:{scheduler}"
        more = {"CAMWRIGHT_DATABASE_URL": store.url, "CAMWRIGHT_LEASE_S": str(LEASE_S),
                "CAMWRIGHT_ACCESS": "open-to-anyone", **cluster}  # fmt: skip
        self.services: list[Process] = []
        for number, port in enumerate(self.ports):
            place = folder / f"service {number}"
            place.mkdir()
            workers = {"CAMWRIGHT_SCHEDULER": address} if number else {}
            self.services.append(service(place, port, real=real, **more, **workers))
        self.cluster = [
            Process(*words, **cluster) for words in (
                ("-m", "service.workers.scheduler", "--host=127.0.0.1", f"--port={scheduler}",
                 "--no-dashboard", "--dashboard-address=127.0.0.1:0"),
                ("-m", "dask", "worker", address, "--nworkers=1", "--nthreads=1", "--no-dashboard",
                 "--dashboard-address=127.0.0.1:0", f"--local-directory={folder}",
                 "--death-timeout=60"),
            ) if count > 1
        ]  # fmt: skip
        self.all = [*self.cluster, *self.services]

    def supervise(self) -> None:
        """Start again whatever has ended, as Docker and systemd do."""
        while not self.stopped.wait(1.0):
            for each in self.all:
                if each.running.poll() is not None:
                    each.start()

    def wait(self) -> None:
        """Until both answer."""
        for port in self.ports:
            with httpx2.Client(base_url=f"http://127.0.0.1:{port}", timeout=60.0) as client:
                answering(client)

    def faults(self, asking: Asking) -> dict[str, Fault]:
        """What may happen to them."""
        found = {
            "kill -9 of a service": self._draw.choice(self.services).kill,
            "kill -9 of a worker": self._kill_worker,
            "kill -9 of what forks": self._kill_forking,
            "stands still": self._stop,
            "connection cut": lambda: self._cut(asking),
        }  # fmt: skip
        if self.cluster:
            found["kill -9 of the scheduler"] = self.cluster[0].kill
            found["kill -9 of a worker of the scheduler"] = self._kill_remote
        return found

    def _kill_worker(self) -> None:
        for worker in children(self.services[0].running.pid)[:1]:
            os.kill(worker, signal.SIGKILL)

    def _kill_forking(self) -> None:
        workers = children(self.services[0].running.pid)
        for forking in {int(Path(f"/proc/{each}/stat").read_text().rpartition(")")[2].split()[1])
                        for each in workers}:  # fmt: skip
            os.kill(forking, signal.SIGKILL)

    def _kill_remote(self) -> None:
        """What solves, or now and then what starts it again as well."""
        nanny, *forked = processes.family(self.cluster[1].running.pid)
        if self._draw.random() < 0.3 or not forked:
            os.kill(nanny, signal.SIGKILL)
        for each in forked:
            with contextlib.suppress(ProcessLookupError):
                os.kill(each, signal.SIGKILL)

    def _stop(self) -> None:
        chosen = self._draw.choice(self.services).running
        chosen.send_signal(signal.SIGSTOP)
        time.sleep(1.5 * LEASE_S)
        chosen.send_signal(signal.SIGCONT)

    def _cut(self, asking: Asking) -> None:
        """Ask and wait for the answer; reset the connection before it, or in the middle of it."""
        question = asking.work.design(self._draw)
        asking.seen.cut.append(question)
        body = json.dumps(question).encode()
        head = f"POST /v1/designs HTTP/1.1\r\nHost: localhost\r\nContent-Length: {len(body)}\r\n"
        port = self._draw.choice(self.ports)
        with (
            contextlib.suppress(OSError),
            socket.create_connection(("127.0.0.1", port), 5.0) as connection,
        ):
            connection.sendall(head.encode() + b"Content-Type: application/json\r\n\r\n" + body)
            connection.settimeout(self._draw.choice((0.1, 0.5, 5.0)))
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")
            connection.recv(self._draw.choice((1, 100, 2000)))


def main() -> int:
    """Faults in random order until there were enough; 0 where nothing is lost."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--store", choices=("sqlite", "postgresql"), default="sqlite")
    parser.add_argument("--core", choices=("fake", "real"), default="fake")
    for name, default in (("faults", 100), ("singles", 500), ("sweeps", 5), ("items", 200),
                          ("seed", 1), ("services", 2)):  # fmt: skip
        parser.add_argument(f"--{name}", type=int, default=default)
    parser.add_argument("--clock", action="store_true", help="set the clock too")
    parser.add_argument("--only", default="", help="faults whose name holds this")
    chosen = parser.parse_args()
    draw, folder = random.Random(chosen.seed), Path(tempfile.mkdtemp(prefix="faults-"))
    real = chosen.core == "real"
    with ExitStack() as stack:
        stack.callback(shutil.rmtree, folder, ignore_errors=True)
        clock = {"clock set": Clock(folder).set_by_an_hour} if chosen.clock else {}
        store = stack.enter_context(opened(chosen.store))
        services = Services(folder, store, draw, real, chosen.services)
        for each in services.all:
            stack.callback(each.stop)
        supervisor = threading.Thread(daemon=True, target=services.supervise)
        supervisor.start()
        stack.callback(supervisor.join)
        stack.callback(services.stopped.set)
        services.wait()
        work = RealWork() if real else FakeWork()
        asking = Asking(services.ports, random.Random(chosen.seed), work)
        stack.callback(asking.close)
        posting = [
            threading.Thread(daemon=True, target=target, args=arguments)
            for target, arguments in (
                (asking.post_sweeps, (chosen.sweeps, chosen.items)),
                (asking.post_designs, (chosen.singles, PACE_S * chosen.faults)),
            )
        ]
        watching = threading.Thread(daemon=True, target=asking.watch)
        for thread in (*posting, watching):
            thread.start()
        done, started, order = Counter[str](), time.monotonic(), list[str]()
        for _ in range(chosen.faults):
            time.sleep(draw.uniform(*BETWEEN_S))
            faults = {**services.faults(asking), **store.faults(), **clock}
            # Each kind in turn, in a new random order for every round.
            order = order or [each for each in draw.sample(sorted(faults), len(faults))
                              if chosen.only in each]  # fmt: skip
            name = order.pop()
            if name not in store.faults():  # these may meet a service that starts
                services.wait()
            print(f"{time.monotonic() - started:6.1f} s  {name}", flush=True)
            faults[name]()
            done[name] += 1
        lasted = time.monotonic() - started
        for thread in posting:
            thread.join()
        asking.over.set()
        watching.join()
        print(f"{chosen.store}, {chosen.core} core: {sum(done.values())} faults in {lasted:.0f} s, "
              f"seed {chosen.seed}: {dict(done)}", flush=True)  # fmt: skip
        found = judge(asking, store, SETTLED_S)
        if not real:
            begun = Counter((folder / "log").read_text().splitlines())
            print(f"the core began {sum(begun.values())} times, {len(begun)} different ones")
        return min(found, 1)


if __name__ == "__main__":
    sys.exit(main())
