"""Two services on one PostgreSQL: one works on a sweep, and the other goes on where it died."""

from __future__ import annotations

import asyncio
import os
import signal
import time
from collections import Counter
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import httpx2
import pytest

from service.storage.store import Store
from service.storage.tables import SweepRow
from service.sweeps.store import Done, LeaseLost, SweepStore
from service.sweeps.tasks import ItemAnswer
from synthesis.design.identity import ENGINE_NUMBER
from tests.lazy import LazyModule
from tests.service.conftest import settings_for
from tests.service.fake_core import Gate
from tests.service.killing import Process, answering, free_port, service
from tests.service.postgres import PASSWORD, postgres
from tests.service.sweeps.test_kills import done, until
from tests.service.sweeps.test_sweeps import counted, items_at, over, posted, sweep_of

psycopg = LazyModule("psycopg")

ITEMS = 160
LEASE_S = 4.0  # renewed every half second: long enough for a process on a busy machine


def test_one_at_a_time_and_nobody_else_writes(tmp_path: Path) -> None:
    """Two processes' leases on one store: what the second may do, and what the first may not."""

    async def reported(store: Store) -> None:
        one, other = SweepStore(store, 60.0), SweepStore(store, 60.0)
        row = await one.accept(a_sweep())
        number = row.sequence
        assert [each.id for each in await one.unleased_rows()] == [row.id]
        assert await one.take(number)
        assert not await other.take(number)
        assert await other.unleased_rows() == []
        assert (await one.record(number, [an_item(0)])).done == 1
        one.lease_s = -1.0  # has run out as soon as it is renewed
        assert number in await one.renew()
        assert await other.take(number)
        assert number not in await one.renew()
        assert await one.unleased_rows() == []
        with pytest.raises(LeaseLost):
            await one.record(number, [an_item(1)])
        await one.release(number)  # not its own to give
        assert number in await other.renew()
        assert (await other.record(number, [an_item(0), an_item(1)])).done == 2
        await one.end(number, "dismissed")  # by whoever does not work on it
        with pytest.raises(LeaseLost):
            await other.record(number, [an_item(2)])
        await one.accept(a_sweep())
        assert await one.take(number)
        await one.end(number, "dismissed")
        assert (await one.record(number, [an_item(2)])).done == 3  # at hand by then

    store = Store(settings_for(tmp_path))
    try:
        asyncio.run(reported(store))
    finally:
        store.dispose()


@pytest.mark.parametrize(("engine", "left"), [(ENGINE_NUMBER, False), (ENGINE_NUMBER + 1, True)])
def test_what_a_later_engine_began_is_left_to_it(tmp_path: Path, engine: int, left: bool) -> None:
    """Services that share a database are updated one by one."""

    async def work(store: Store) -> None:
        sweeps, sweep = SweepStore(store, 60.0), a_sweep()
        sweep.engine = engine
        row = await sweeps.accept(sweep)
        assert [each.id for each in await sweeps.unleased_rows()] == ([] if left else [row.id])
        assert await sweeps.take(row.sequence) is not left

    store = Store(settings_for(tmp_path))
    try:
        asyncio.run(work(store))
    finally:
        store.dispose()


def a_sweep() -> SweepRow:
    return SweepRow(
        engine=1,
        id="s", name="", created=datetime.now(UTC), state="accepted", spec=b"{}", size=3, axes=[],
        quantities=[], optimal=0, feasible=0, infeasible=0, failed=0,
    )  # fmt: skip


def an_item(number: int) -> Done:
    return ItemAnswer(number, "optimal"), []


def test_every_item_once_while_processes_die_and_stand_still(tmp_path: Path) -> None:
    """The one with the lease stands still for longer than that, and wakes; the next is killed."""
    log, ports, gate = tmp_path / "log", (free_port(), free_port()), Gate(tmp_path / "gate")
    names = [*(f"sleep 0.05{' ' * i}" for i in range(ITEMS - 40)), *gate.names(40)]
    with postgres("camwright", "camwright") as database:
        address = f"camwright:{PASSWORD}@127.0.0.1:{database}/camwright"
        services = [
            service(
                folder, port, FAKE_CORE_LOG=str(log), CAMWRIGHT_WORKERS="1",
                CAMWRIGHT_LEASE_S=str(LEASE_S),
                CAMWRIGHT_DATABASE_URL=f"postgresql+psycopg://{address}",
            )
            for folder, port in zip(folders(tmp_path), ports, strict=True)
        ]  # fmt: skip
        first, second = (
            httpx2.Client(base_url=f"http://127.0.0.1:{port}", timeout=180.0) for port in ports
        )
        try:
            answering(first)
            answering(second)
            where = posted(first, sweep_of(names))
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
            gate.open()
            print(f"killed: {goes_on(first, where):.1f} s until the other went on")
            counted(over(first, where), items=ITEMS, done=ITEMS, optimal=ITEMS)
            listed = [item["number"] for item in items_at(first, where)]
            with psycopg.connect(f"postgresql://{address}", autocommit=True) as connection:
                rows = [row[0] for row in connection.execute("select number from sweep_items")]
                leaves_in_order(services[0], first, connection)
        finally:
            for client in (first, second):
                client.close()
            for process in services:
                process.stop()
    lost, twice = set(range(ITEMS)) - set(rows), len(rows) - len(set(rows))
    begun = len(log.read_text().splitlines())
    print(f"items expected {ITEMS}, done {len(rows)}, lost {len(lost)}, duplicated {twice}")
    print(f"begun {begun}: {begun - ITEMS} more than once, as their process was lost with them")
    assert sorted(rows) == sorted(listed) == list(range(ITEMS))
    assert begun - ITEMS <= 60


def leaves_in_order(process: Process, client: httpx2.Client, database: Any) -> None:
    """SIGTERM while somebody watches a sweep: the stream ends, the lease is given back."""
    question = "select state, leased_by is null from sweeps order by sequence desc limit 1"
    where = posted(client, sweep_of([f"look 600{' ' * i}" for i in range(3)]))
    with client.stream("GET", f"{where}/events") as watched:
        assert next(watched.iter_lines())
        until(lambda: database.execute(question).fetchone() == ("running", False))
        process.running.terminate()
        process.running.wait(180.0)
    assert database.execute(question).fetchone() == ("running", True)


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
