"""What HTTP adds: designs posted to a service on loopback, beside the core's own time."""

from __future__ import annotations

import http.client
import json
import os
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from benchmarks.effort import FULL, Effort
from benchmarks.main_job import CONVEX
from benchmarks.section import Section, Table
from benchmarks.timing import Timing

POSTS = 40
PATIENCE_S = 300.0  # at the longest
TEXT = """The convex scene of the main job, posted to a service on loopback that keeps its designs
in SQLite and solves in worker processes."""


def run(effort: Effort = FULL) -> Section:
    """The whole, the core's share as the design reports it, the difference."""
    posts = effort.repeats(POSTS)
    with service() as port, closing(connection(port, PATIENCE_S)) as wire:
        for k in range(effort.warm_up(5)):
            _post(wire, f"warm-up {k}")
        measured = [_post(wire, f"measured {k}") for k in range(posts)]
        again = [_post(wire, "measured 0")[0] for _ in range(posts)]
    whole, core = zip(*measured, strict=True)
    times = {
        "whole request": Timing(whole),
        "core, as reported": Timing(core),
        "added by HTTP, engine and store": Timing(tuple(a - b for a, b in measured)),
        "the same spec again, from the store": Timing(tuple(again)),
    }
    rows = [(name, str(time)) for name, time in times.items()]
    added = ("HTTP, engine and store add", rows[2][1], "–")
    return Section("A design over HTTP", TEXT, [Table(("", ">time"), rows)], [added])


def connection(port: int, patience: float) -> http.client.HTTPConnection:
    return http.client.HTTPConnection("127.0.0.1", port, timeout=patience)


def _post(wire: http.client.HTTPConnection, name: str) -> tuple[float, float]:
    """Seconds of the whole request and of the core."""
    body = json.dumps(CONVEX | {"name": name})
    started = time.perf_counter()
    wire.request("POST", "/v1/designs", body, {"Content-Type": "application/json"})
    answer = wire.getresponse()
    content = answer.read()
    seconds = time.perf_counter() - started
    if answer.status != 200:
        raise RuntimeError(content.decode())
    return seconds, json.loads(content)["report"]["seconds"]


@contextmanager
def service() -> Iterator[int]:
    """The port of a service of its own, with a store of its own."""
    with started() as (port, _):
        yield port


@contextmanager
def started() -> Iterator[tuple[int, int]]:
    """The same, with the number of its process."""
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
            yield port, process.pid
        finally:
            process.terminate()
            process.wait(PATIENCE_S)


def _await(port: int) -> None:
    """Until /readyz says yes."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        try:
            with closing(connection(port, 5.0)) as wire:
                wire.request("GET", "/readyz")
                if wire.getresponse().status == 200:
                    return
        except OSError:
            pass
        time.sleep(0.2)
    raise RuntimeError(f"the service on port {port} did not get ready in {PATIENCE_S:.0f} s")
