"""Large sweeps: what an item takes besides its solve, and memory that does not grow with them."""

from __future__ import annotations

import csv
import http.client
import time
from collections.abc import Iterator
from contextlib import closing
from typing import Any

from benchmarks import processes
from benchmarks.effort import FULL, Effort
from benchmarks.http import PATIENCE_S, connection, started
from benchmarks.section import Section, Table
from benchmarks.sweeps import WORKERS, answer, swept

SIZES = (10, 1000, 20_000)
REST_S = 3.0  # after the start and after a sweep, until memory is read
GIVEN = {
    "program": [
        {"kind": "rise", "angle_deg": 180.0, "lift_mm": 10.0, "law": {"kind": "simple_harmonic"}},
        {"kind": "return", "angle_deg": 180.0, "lift_mm": 10.0, "law": {"kind": "simple_harmonic"}},
    ],
    "follower": {"kind": "translating_roller", "roller_radius_mm": 10.0, "offset_mm": 0.0},
    "base_radius_mm": 30.0,
}
TEXT = f"""The cheapest items there are, cams given down to their size, of which only the motion's
speed differs: one service with {WORKERS} workers, sweep after sweep. What an item takes besides is
the time of the whole sweep over its items, less the time in the core over the workers: sending,
keeping, counting, and workers that wait. Memory is that of the processes as Linux counts it, three
seconds after each sweep; peaks are since the start. The share of all counts pages that processes
have in common once: it is what the service takes from the machine."""


def run(effort: Effort = FULL) -> Section:
    """Sweeps one after the other on one service, its memory before and after each."""
    times, memory = [], []
    with started() as (port, process):
        rest_s = 0.0 if effort.trial else REST_S
        memory.append(_memory("at rest, before any", process, rest_s))
        for size in effort.some(SIZES):
            with closing(connection(port, PATIENCE_S)) as wire:
                whole, first = swept(wire, _asked(size))
                core = sum(_seconds(wire))
            over = (whole - core / WORKERS) / size
            times.append(
                (f"{size:,}", f"{whole:.1f} s", f"{1e3 * core / size:.2f} ms",
                 f"{1e3 * over:.2f} ms", f"{first:.2f} s")
            )  # fmt: skip
            memory.append(_memory(f"after {size:,}", process, rest_s))
    head = (">items", ">whole sweep", ">an item in the core", ">besides, an item",
            ">first item after")  # fmt: skip
    columns = ("items", ">service now", ">peak", ">largest worker now", ">peak", ">share of all")
    front = [(f"an item of a sweep of {times[-1][0]} takes besides", times[-1][3], "–")]
    return Section("Large sweeps", TEXT, [Table(head, times), Table(columns, memory)], front)


def _asked(size: int) -> dict[str, Any]:
    axis = {"kind": "range", "pointer": "/speed_rpm", "start": 60.0, "stop": 600.0, "count": size}
    return {"name": f"{size} given cams", "base": GIVEN, "axes": [axis]}


def _seconds(wire: http.client.HTTPConnection) -> Iterator[float]:
    """Time in the core of each item of the newest sweep, by its table."""
    where = answer(wire, "GET", "/v1/sweeps?limit=1")["items"][0]["links"]["items.csv"]
    wire.request("GET", where)
    table = wire.getresponse().read().decode()
    return (float(row["seconds"]) for row in csv.DictReader(table.splitlines()))


def _memory(when: str, process: int, rest_s: float) -> tuple[str, ...]:
    """A row of the table of memory."""
    time.sleep(rest_s)
    if not processes.there():
        return (when, *["not reported by this system"] * 5)
    service, family = processes.of(process), processes.family(process)
    largest = max((processes.of(each) for each in processes.workers(family)), key=_peak)
    share = sum(processes.of(each).share for each in family)
    shown = (service.resident, service.peak, largest.resident, largest.peak, share)
    return (when, *(f"{value:.0f} MiB" for value in shown))


def _peak(memory: processes.Memory) -> float:
    return memory.peak
