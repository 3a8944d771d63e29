"""Load table: how long a quiet owner waits beside a loud one with many clients.

    python -m tests.service.load [clients] ...

It starts a service of its own with one key for each owner. The loud owner runs a sweep, and each of
his clients asks for one design after the other; who is refused comes back when Retry-After says.
The quiet owner asks for a design, waits for it, and asks for another. Every question is a new one
and takes some 10 ms in the core. Columns: clients of the loud owner; the quiet owner's answers,
and the times that he waited for them (percentiles 50, 95, 99, in ms); the loud owner's answers,
their times, and how often he was refused; of those who were refused and came back, how many found
room; refusals of the quiet owner; other errors; memory of all processes, at most [MiB].
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from statistics import quantiles
from typing import Any

from tests.service.specs import CAM
from tests.service.wire.hostile import free_port

CLIENTS = (1, 10, 50, 200)
HELD_S = 12.0  # for which each number of clients asks
LATE_S = 60.0  # after that an answer counts as an error
SWEPT = 20_000  # items of the loud owner's sweep: more than fit into the time
numbers = count()


@dataclass
class Record:
    """What came of the questions of one owner: times [s], refusals, and who came back."""

    times: list[float] = field(default_factory=list)
    counts: Counter[str] = field(default_factory=Counter)

    def percentiles(self) -> str:
        """The 50th, 95th and 99th of the times [ms]."""
        if len(self.times) < 2:
            return "-"
        cuts = quantiles(self.times, n=100, method="inclusive")
        return " ".join(f"{1e3 * cuts[at - 1]:.0f}" for at in (50, 95, 99))


def design() -> dict[str, Any]:
    """A question that nobody has asked."""
    return {**CAM, "name": "load", "speed_rpm": 100.0 + 1e-3 * next(numbers)}


async def ask(
    port: int, key: str, method: str, path: str, body: Any = None
) -> tuple[int, dict[str, str], bytes]:
    """Status, headers and body of an answer, over a connection of its own."""
    sent = b"" if body is None else json.dumps(body).encode()
    head = (
        f"{method} {path} HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {key}\r\n"
        f"Content-Type: application/json\r\nContent-Length: {len(sent)}\r\n"
        "Connection: close\r\n\r\n"
    )
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    try:
        writer.write(head.encode() + sent)
        whole = await reader.read()
    finally:
        writer.close()
    first, _, rest = whole.partition(b"\r\n\r\n")
    status, *lines = first.decode().split("\r\n")
    pairs = (line.partition(": ") for line in lines)
    return int(status.split()[1]), {name.lower(): value for name, _, value in pairs}, rest


async def keep_asking(port: int, key: str, asked: Record, end: float) -> None:
    """One client: a design after the other; who is refused waits as long as he is told."""
    told, body = False, design()
    while time.monotonic() < end:
        began = time.monotonic()
        try:
            async with asyncio.timeout(LATE_S):
                status, headers, _ = await ask(port, key, "POST", "/v1/designs", body)
        except (OSError, TimeoutError, IndexError, ValueError):
            asked.counts["error"] += 1
            await asyncio.sleep(0.1)
            continue
        if told:
            asked.counts["came back"] += 1
            asked.counts["found room"] += status != 429
        told = status == 429
        if told:  # the same question again
            asked.counts["refused"] += 1
            again_s = float(headers["retry-after"])
            if time.monotonic() + again_s > end:
                break
            await asyncio.sleep(again_s)
            continue
        body = design()
        if status == 200:
            asked.times.append(time.monotonic() - began)
        else:
            asked.counts["error"] += 1


def memory(session: int) -> float:
    """Memory [MiB] of the processes of a session; pages that several share count once."""
    most = 0
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError, ValueError, IndexError):
            if os.getsid(int(folder.name)) == session:
                lines = (folder / "smaps_rollup").read_text().splitlines()
                most += next(int(line.split()[1]) for line in lines if line.startswith("Pss:"))
    return most / 1024


async def measure(port: int, session: int, keys: list[str], clients: int) -> str:
    """A line of the table."""
    quiet, loud = Record(), Record()
    swept = {"kind": "range", "pointer": "/speed_rpm", "start": 10.0 + clients,
             "stop": 5000.0 + clients, "count": SWEPT}  # fmt: skip
    body = {"name": "load", "base": CAM, "axes": [swept]}
    _, headers, _ = await ask(port, keys[1], "POST", "/v1/sweeps", body)
    end = time.monotonic() + HELD_S
    tasks = [asyncio.create_task(keep_asking(port, keys[1], loud, end)) for _ in range(clients)]
    tasks.append(asyncio.create_task(keep_asking(port, keys[0], quiet, end)))
    most = 0.0
    while time.monotonic() < end:
        await asyncio.sleep(1.0)
        most = max(most, await asyncio.to_thread(memory, session))
    await tasks[-1]  # the quiet owner's last answer counts, however late it is
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)
    await ask(port, keys[1], "DELETE", headers["location"])
    back, room = loud.counts["came back"], loud.counts["found room"]
    cells = (
        clients, len(quiet.times), quiet.percentiles(), len(loud.times), loud.percentiles(),
        loud.counts["refused"], f"{room} of {back}", quiet.counts["refused"],
        quiet.counts["error"] + loud.counts["error"], f"{most:.0f}",
    )  # fmt: skip
    return "| " + " | ".join(map(str, cells)) + " |"


def main() -> None:
    """Measure for each number of clients."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # so that the service ends too
    with tempfile.TemporaryDirectory() as folder:
        port = free_port()
        environment = {
            **os.environ, "CAMWRIGHT_PORT": str(port), "CAMWRIGHT_LOG_LEVEL": "error",
            "CAMWRIGHT_DATABASE_URL": f"sqlite:///{folder}/designs.db",
        }  # fmt: skip
        make = [sys.executable, "-m", "service.cli", "keys", "create"]
        keys = [
            subprocess.run([*make, name, "--owner", name], env=environment, check=True,
                           stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True).stdout
            for name in ("quiet", "loud")
        ]  # fmt: skip
        keys = [next(word for word in text.split() if "camwright_" in word) for text in keys]
        with Path(folder, "log").open("wb") as log:
            process = subprocess.Popen(
                [sys.executable, "-m", "service"], env=environment, stdout=log, stderr=log,
                start_new_session=True,
            )  # fmt: skip
        try:
            asyncio.run(_measure_all(port, process.pid, keys))
        finally:
            process.terminate()
            process.wait()


async def _measure_all(port: int, session: int, keys: list[str]) -> None:
    for _ in range(600):
        with contextlib.suppress(OSError, IndexError):
            if (await ask(port, keys[0], "GET", "/readyz"))[0] == 200:
                break
        await asyncio.sleep(0.1)
    sys.stdout.write(
        "| clients | quiet: answers | p50 p95 p99 [ms] | loud: answers | p50 p95 p99 [ms] | "
        "refused | found room | quiet: refused | errors | MiB |\n"
        f"{10 * '|--:'}|\n"
    )
    for clients in [int(word) for word in sys.argv[1:]] or CLIENTS:
        sys.stdout.write(await measure(port, session, keys, clients) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
