"""kill -9 of the service and of its workers: no item lost, none in the store twice."""

from __future__ import annotations

import os
import signal
import sqlite3
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx2

from tests.service.conftest import Running, wait_until, wait_until_idle
from tests.service.fake_core import Gate
from tests.service.killing import answering, children, free_port, service
from tests.service.specs import spec
from tests.service.sweeps.test_sweeps import counted, items_at, over, posted, sweep_of


def slow(items: int, gate: Gate) -> dict[str, Any]:
    """Items of 30 ms each, and a last one that waits: the sweep runs until the gate is open."""
    return sweep_of([*(f"sleep {0.03 + 1e-6 * i:.6f}" for i in range(items - 1)), *gate.names(1)])


def done(client: httpx2.Client, where: str) -> int:
    number: int = client.get(where).json()["counts"]["done"]
    return number


def until(reached: Callable[[], bool]) -> None:
    for _ in range(1200):
        if reached():
            return
        time.sleep(0.25)  # to ask takes a hundredth of a second
    raise AssertionError("it does not come to that")


def every_item_once(client: httpx2.Client, where: str, expected: int, folder: Path) -> None:
    """By the answers, and by the rows of the database."""
    counted(over(client, where), items=expected, done=expected, optimal=expected)
    numbers = [item["number"] for item in items_at(client, where)]
    with sqlite3.connect(folder / "designs.db") as database:
        rows = [row[0] for row in database.execute("select number from sweep_items")]
    database.close()
    lost = set(range(expected)) - set(rows)
    twice = len(rows) - len(set(rows))
    print(f"items expected {expected}, done {len(rows)}, lost {len(lost)}, duplicated {twice}")
    assert sorted(numbers) == sorted(rows) == list(range(expected))


def test_the_service_and_its_workers_killed(tmp_path: Path) -> None:
    """The service goes, with its workers; then each worker goes while the service stays."""
    port, items, gate = free_port(), 240, Gate(tmp_path / "gate")
    running = service(tmp_path, port)
    with httpx2.Client(base_url=f"http://127.0.0.1:{port}", timeout=180.0) as client:
        try:
            answering(client)
            where = posted(client, slow(items, gate))
            until(lambda: done(client, where) >= 10)
            kept, workers = done(client, where), children(running.running.pid)
            running.kill()
            until(lambda: not any(map(alive, workers)))  # none is orphaned
            running.start()
            answering(client)
            assert done(client, where) >= kept  # what counted as done is there
            for worker in children(running.running.pid):
                kept = done(client, where)
                os.kill(worker, signal.SIGKILL)
                until(lambda kept=kept: done(client, where) > kept)
            assert client.get(where).json()["state"] == "running"
            gate.open()
            every_item_once(client, where, items, tmp_path)
        finally:
            running.stop()


def alive(process: int) -> bool:
    return Path(f"/proc/{process}").exists()


def test_items_that_kill_their_worker_are_blamed_alone(service: Running) -> None:
    names = [f"die 0.0{' ' * i}" if i in (7, 8) else f"item {i}" for i in range(40)]
    where = posted(service.client, sweep_of(names))
    found = over(service.client, where)
    assert found["state"] == "successful"
    counted(found, items=40, done=40, optimal=38, failed=2)
    failed = items_at(service.client, where, status="failed")
    assert sorted(item["number"] for item in failed) == [7, 8]
    for item in failed:
        assert item["problem"]["type"] == "/problems/worker-lost"
        assert "signal 9" in item["problem"]["detail"]


def test_strikes_outlive_the_service(tmp_path: Path) -> None:
    """Killed after an item has taken two workers with it, the service gives it one more only."""
    port, log, gate = free_port(), tmp_path / "log", Gate(tmp_path / "gate")
    (deadly,) = gate.names(1, "wait-and-die")
    gate.let(2)
    running = service(tmp_path, port, FAKE_CORE_LOG=str(log), CAMWRIGHT_WORKERS="1")
    with httpx2.Client(base_url=f"http://127.0.0.1:{port}", timeout=180.0) as client:
        try:
            answering(client)
            where = posted(client, sweep_of([deadly, "fine", "fine too"]))
            until(lambda: strikes(tmp_path) == [(0, 2)])
            running.kill()
            gate.open()
            running.start()
            answering(client)
            counted(over(client, where), items=3, done=3, optimal=2, failed=1)
            begun = log.read_text().splitlines().count(deadly)
            print(f"strikes {strikes(tmp_path)}, begun {begun} times")
            assert strikes(tmp_path) == [(0, 3)]
            assert begun <= 4  # once more where the service was killed in the middle of it
        finally:
            running.stop()


def strikes(folder: Path) -> list[tuple[int, int]]:
    with sqlite3.connect(folder / "designs.db") as database:
        found = database.execute("select number, strikes from sweep_strikes").fetchall()
    database.close()
    return found


def test_an_item_that_nothing_stops_is_stopped(service: Running) -> None:
    names = ["sleep 3600", *(f"item {i}" for i in range(9))]
    body = sweep_of(names)
    body["base"] = spec(time_budget_s=1.0)
    where = posted(service.client, body)
    counted(over(service.client, where), items=10, done=10, optimal=9, failed=1)
    (failed,) = items_at(service.client, where, status="failed")
    assert (failed["number"], failed["problem"]["type"]) == (0, "/problems/time-budget")


def test_a_single_design_goes_before_the_rest_of_a_sweep(service: Running, tmp_path: Path) -> None:
    """Every item holds its worker until it may go on: the design gets the first place set free."""
    client, gate = service.client, Gate(tmp_path / "gate")
    wait_until_idle(client)
    where = posted(client, sweep_of(gate.names(5)))
    wait_until(client, running=2)
    single = client.post("/v1/designs", json=spec("now"), headers={"Prefer": "respond-async"})
    wait_until(client, waiting=1)
    gate.let(1)
    until(lambda: client.get(single.headers["location"]).status_code == 200)
    until(lambda: done(client, where) == 1)
    client.delete(where)
