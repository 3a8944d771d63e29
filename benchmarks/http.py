"""What HTTP adds: designs posted to a service on loopback, beside the core's own time."""

from __future__ import annotations

import http.client
import json
import os
import socket
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from benchmarks.main_job import CONVEX

POSTS = 40
PATIENCE_S = 60.0


def run() -> str:
    """Markdown table: the whole, the core's share as the design reports it, the difference."""
    with _service() as port:
        connection = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE_S)
        for k in range(5):
            _post(connection, f"warm-up {k}")
        measured = [_post(connection, f"measured {k}") for k in range(POSTS)]
        again = [_post(connection, "measured 0")[0] for _ in range(POSTS)]
    whole, core = zip(*measured, strict=True)
    added = [a - b for a, b in measured]
    lines = ["### A design over HTTP", "", "| | median | quartiles |", "|---|---|---|"]
    for name, values in (
        ("whole request", whole),
        ("core, as reported", core),
        ("added by HTTP, engine and store", added),
        ("the same spec again, from the store", again),
    ):
        low, median, high = (1e3 * v for v in statistics.quantiles(values, n=4))
        lines.append(f"| {name} | {median:.1f} ms | {low:.1f} to {high:.1f} |")
    return "\n".join(lines)


def _post(connection: http.client.HTTPConnection, name: str) -> tuple[float, float]:
    """Seconds of the whole request and of the core."""
    body = json.dumps(CONVEX | {"name": name})
    started = time.perf_counter()
    connection.request("POST", "/v1/designs", body, {"Content-Type": "application/json"})
    answer = connection.getresponse()
    content = answer.read()
    seconds = time.perf_counter() - started
    if answer.status != 200:
        raise RuntimeError(content.decode())
    return seconds, json.loads(content)["report"]["seconds"]


@contextmanager
def _service() -> Iterator[int]:
    """A service of its own on a free port, with a store of its own."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with tempfile.TemporaryDirectory() as folder:
        settings = {
            "CAMWRIGHT_HOST": "127.0.0.1",
            "CAMWRIGHT_PORT": str(port),
            "CAMWRIGHT_DATABASE_URL": f"sqlite:///{Path(folder) / 'designs.db'}",
        }
        process = subprocess.Popen(
            [sys.executable, "-m", "service"],
            env=os.environ | settings,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            _await(port)
            yield port
        finally:
            process.terminate()
            process.wait(30.0)


def _await(port: int) -> None:
    """Until /readyz says yes."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        try:
            connection = http.client.HTTPConnection("127.0.0.1", port, timeout=5.0)
            connection.request("GET", "/readyz")
            if connection.getresponse().status == 200:
                return
        except OSError:
            pass
        time.sleep(0.2)
    raise RuntimeError(f"the service on port {port} did not get ready in {PATIENCE_S:.0f} s")
