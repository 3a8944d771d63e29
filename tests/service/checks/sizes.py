"""The sizes in docs/operations.md: memory by process, and what questions take on the disk.

    python -m tests.service.checks.sizes

It starts a service with one worker on SQLite, asks every worked example of a design, the dearest
files of each, a long body and a sweep, and prints a line for each figure. Memory is the resident
set [MiB], pages that processes share included; a worker's and a helper's at its highest.
"""

from __future__ import annotations

import contextlib
import socket
import sqlite3
import sys
import tempfile
import time
from pathlib import Path

import httpx2

from benchmarks import processes
from service.contract.examples import SELF_CHECK, examples
from tests.service.killing import answering, free_port, service

FILES = ("datasheet.pdf", "solid.step", "profile.png", "animation.html", "profile.csv")
IDLE, ITEMS, TABLE = 200, 400, 15_000  # connections, items of the sweep, points of the long body
KEPT = """select count(*), avg(length(spec) + length(body)), avg(length(body)) from answers
          where state = 'done' and kind = '/v1/designs'"""


def size(file: Path) -> int:
    """Of a database [bytes], all that its log holds in it."""
    with contextlib.closing(sqlite3.connect(file)) as database:
        database.execute("pragma wal_checkpoint(truncate)")
    return file.stat().st_size


def resident(process: int) -> float:
    """Memory of a process now [MiB]."""
    return processes.of(process).resident


def long_body() -> dict[str, object]:
    """A measured profile of very many points."""
    points = [[round(360.0 * k / TABLE, 4), 40.0] for k in range(TABLE)]
    return {"name": "long", "follower": {"kind": "translating_roller", "roller_radius_mm": 8.0},
            "points": points}  # fmt: skip


def main() -> int:
    """Print what was measured."""
    found: list[tuple[str, float, str]] = []
    with tempfile.TemporaryDirectory() as name:
        folder, port = Path(name), free_port()
        file = folder / "designs.db"
        running = service(folder, port, real=True, CAMWRIGHT_WORKERS="1",
                          CAMWRIGHT_LOG_LEVEL="error")  # fmt: skip
        try:
            client = httpx2.Client(base_url=f"http://127.0.0.1:{port}", timeout=600.0)
            answering(client)
            while client.get("/readyz").status_code != 200:
                time.sleep(0.2)
            main_process = running.running.pid
            family = processes.family(main_process)
            (worker,) = processes.workers(family)
            (forking,) = [each for each in family[1:] if each != worker
                          and worker in processes.family(each)]  # fmt: skip
            found += [("the service at its start", resident(main_process), "MiB"),
                      ("what processes are forked from", resident(forking), "MiB"),
                      ("a worker at its start", resident(worker), "MiB")]  # fmt: skip
            before = resident(main_process)
            held = [socket.create_connection(("127.0.0.1", port)) for _ in range(IDLE)]
            time.sleep(1.0)
            each = (resident(main_process) - before) * 1024 / IDLE
            found.append((f"a connection ({IDLE} of them)", each, "KiB"))
            for connection in held:
                connection.close()
            empty, asked = size(file), 0
            for example in examples().values():
                answer = client.post("/v1/designs", json=example["value"])
                asked += answer.status_code == 200
                for path in FILES:
                    client.get(f"{answer.headers.get('content-location')}/{path}")
            found.append(("a worker at most, files included", processes.of(worker).peak, "MiB"))
            with contextlib.closing(sqlite3.connect(file)) as database:
                ((count, mean, body),) = database.execute(KEPT).fetchall()
            after = size(file)
            by_answer = (after - empty) / 1e3 / count
            found += [(f"the file, by answer ({asked} designs)", by_answer, "kB"),
                      ("a question and its answer", mean / 1e3, "kB"),
                      ("the answer itself", body / 1e3, "kB")]  # fmt: skip
            client.post("/v1/profile-analyses", json=long_body())
            helpers = [each for each in processes.workers(processes.family(main_process))
                       if each != worker]  # fmt: skip
            peaks = [processes.of(each).peak for each in helpers]
            found.append((f"a reader or writer at most ({len(peaks)})", max(peaks), "MiB"))
            found.append(("the service afterwards", resident(main_process), "MiB"))
            after = size(file)
            axis = {"kind": "range", "pointer": "/limits/0/rise_deg", "start": 25, "stop": 40,
                    "count": ITEMS}  # fmt: skip
            swept = {"name": "sizes", "base": examples()[SELF_CHECK]["value"], "axes": [axis]}
            where = client.post("/v1/sweeps", json=swept).headers["location"]
            while client.get(where).json()["state"] in ("accepted", "running"):
                time.sleep(0.5)
            found.append(("the file, by item of a sweep", (size(file) - after) / 1e3 / ITEMS, "kB"))
        finally:
            running.stop()
    for what, number, unit in found:
        print(f"{what:45} {number:8.1f} {unit}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
