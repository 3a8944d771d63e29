"""Two services on one PostgreSQL: one works on a sweep, and the other goes on where it died."""

from __future__ import annotations

import os
import signal
import time
from collections import Counter
from pathlib import Path

import httpx2
import psycopg

from tests.service.killing import answering, free_port, service
from tests.service.postgres import PASSWORD, postgres
from tests.service.test_kills import done, until
from tests.service.test_sweeps import counted, items_at, over, posted, sweep_of

ITEMS = 160
LEASE_S = 1.5


def test_every_item_once_while_owners_die_and_stand_still(tmp_path: Path) -> None:
    """The owner stands still for longer than its lease, and wakes; the next one is killed."""
    log, ports = tmp_path / "log", (free_port(), free_port())
    with postgres("camwright", "camwright") as database:
        address = f"camwright:{PASSWORD}@127.0.0.1:{database}/camwright"
        services = [
            service(
                folder, port, FAKE_CORE_LOG=str(log), CAMWRIGHT_WORKERS="1",
                CAMWRIGHT_SWEEP_LEASE_S=str(LEASE_S),
                CAMWRIGHT_DATABASE_URL=f"postgresql+psycopg://{address}",
            )
            for folder, port in zip(folders(tmp_path), ports, strict=True)
        ]  # fmt: skip
        first, second = (
            httpx2.Client(base_url=f"http://127.0.0.1:{port}", timeout=30.0) for port in ports
        )
        try:
            answering(first)
            answering(second)
            where = posted(first, sweep_of([f"sleep 0.05{' ' * i}" for i in range(ITEMS)]))
            assert posted(second, second.get(where).json()["spec"]) == where  # joined, not begun
            until(lambda: done(second, where) >= 50)
            assert max(Counter(log.read_text().splitlines()).values()) == 1
            os.kill(services[0].running.pid, signal.SIGSTOP)
            print(f"stopped: {goes_on(second, where):.1f} s until the other went on")
            until(lambda: done(second, where) >= 90)
            os.kill(services[0].running.pid, signal.SIGCONT)
            kept = done(first, where)
            services[1].kill()
            assert kept < ITEMS
            print(f"killed: {goes_on(first, where):.1f} s until the other went on")
            counted(over(first, where), items=ITEMS, done=ITEMS, optimal=ITEMS)
            listed = [item["number"] for item in items_at(first, where)]
            with psycopg.connect(f"postgresql://{address}") as connection:
                rows = [row[0] for row in connection.execute("select number from sweep_items")]
        finally:
            for client in (first, second):
                client.close()
            for process in services:
                process.stop()
    lost, twice = set(range(ITEMS)) - set(rows), len(rows) - len(set(rows))
    begun = len(log.read_text().splitlines())
    print(f"items expected {ITEMS}, done {len(rows)}, lost {len(lost)}, duplicated {twice}")
    print(f"begun {begun}: {begun - ITEMS} more than once, as their owner was lost with them")
    assert sorted(rows) == sorted(listed) == list(range(ITEMS))
    assert begun - ITEMS <= 60


def folders(folder: Path) -> list[Path]:
    found = [folder / name for name in ("first", "second")]
    for each in found:
        each.mkdir()
    return found


def goes_on(client: httpx2.Client, where: str) -> float:
    """Seconds until more is done."""
    started, kept = time.monotonic(), done(client, where)
    until(lambda: done(client, where) > kept)
    return time.monotonic() - started
