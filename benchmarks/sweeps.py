"""Sweeps: designs on two workers of a service against one process that does nothing else."""

from __future__ import annotations

import http.client
import json
import time
from contextlib import closing
from typing import Any

from benchmarks.effort import FULL, Effort
from benchmarks.http import PATIENCE_S, connection, service
from benchmarks.main_job import CONVEX
from benchmarks.section import Section, Table
from service.workers.tasks import solve_design
from synthesis.studies.sweeps import SweepSpec

WORKERS = 2
SIZES = (10, 1000)
ALONE = 200  # of these, evenly spread, in one process
TEXT = f"""The convex scene of the main job with as many pressure-angle limits as items, once one
after the other in this process and once as a sweep on {WORKERS} workers, from the request to the
last item in the store. A share of 100 % is twice the throughput of the one process."""


def run(effort: Effort = FULL) -> Section:
    """Time an item takes in one process and in a sweep, and when the first one is there."""
    rows = []
    with service() as port, closing(connection(port, PATIENCE_S)) as wire:
        for size in effort.some(SIZES):
            question = _asked(size)
            alone = _alone(question, effort.repeats(min(size, ALONE)))
            whole, first = swept(wire, question)
            share = alone / WORKERS / (whole / size)
            rows.append(
                (str(size), f"{1e3 * alone:.1f} ms", f"{1e3 * whole / size:.1f} ms",
                 f"{100.0 * share:.0f} %", f"{first:.2f} s")
            )  # fmt: skip
    head = (">items", ">an item in one process", ">an item of the sweep",
            f">share of {WORKERS} × one process", ">first item after")  # fmt: skip
    return Section("Sweeps", TEXT, [Table(head, rows)])


def _asked(size: int) -> dict[str, Any]:
    axis = {"kind": "range", "pointer": "/limits/0/rise_deg", "start": 28.0, "stop": 34.0}
    return {"name": f"{size} items", "base": CONVEX, "axes": [axis | {"count": size}]}


def _alone(question: dict[str, Any], count: int) -> float:
    """Seconds an item, in this process."""
    sweep = SweepSpec.model_validate(question)
    numbers = range(0, sweep.size, max(1, sweep.size // count))
    specs = [json.dumps(sweep.item(sweep.item_values(number))).encode() for number in numbers]
    solve_design(specs[0], PATIENCE_S)
    started = time.perf_counter()
    for spec in specs:
        solve_design(spec, PATIENCE_S)
    return (time.perf_counter() - started) / len(specs)


def swept(wire: http.client.HTTPConnection, question: dict[str, Any]) -> tuple[float, float]:
    """Seconds until all items are there, and until the first one is."""
    started, first = time.perf_counter(), 0.0
    where = answer(wire, "POST", "/v1/sweeps", json.dumps(question))["links"]["self"]
    while True:
        found = answer(wire, "GET", where)
        passed = time.perf_counter() - started
        if found["counts"]["done"] and not first:
            first = passed
        if found["state"] not in ("accepted", "running"):
            return passed, first
        time.sleep(0.5 if first and question["axes"][0]["count"] > 100 else 0.02)


def answer(
    wire: http.client.HTTPConnection, method: str, path: str, body: str | None = None
) -> dict[str, Any]:
    """What the service answers with, over a connection that does not rest until the next look."""
    headers = {"Content-Type": "application/json", "Connection": "close"}
    wire.request(method, path, body, headers)
    reported = wire.getresponse()
    content = reported.read()
    if reported.status >= 300:
        raise RuntimeError(content.decode())
    found: dict[str, Any] = json.loads(content)
    return found
