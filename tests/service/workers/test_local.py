"""Workers at the end of a pipe: nothing listens, what ends is replaced, and no work is lost."""

from __future__ import annotations

import asyncio
import gc
import os
import pickle
import signal
import sys
import threading
from collections.abc import Awaitable, Callable
from pathlib import Path

import httpx2
import numpy as np
import pytest

from benchmarks import processes
from service.wire.errors import ProblemType, ServiceError
from service.workers import local, memory
from service.workers.local import LocalWorkers, local_workers
from service.workers.memory import MIB, share_of_memory
from service.workers.prefork import ENVIRONMENT, start_fork_server
from synthesis.errors import Cancelled
from synthesis.numerics import clock
from tests.service.fake_core import prepare
from tests.service.killing import answering, free_port, service

LISTENING = "0A"  # TCP state of /proc/net/tcp
Story = Callable[[LocalWorkers], Awaitable[None]]


def with_one_worker(story: Story) -> None:
    """Tell a story on a single worker."""

    async def told() -> None:
        async with local_workers(1, prepare) as workers:
            await story(workers)

    asyncio.run(told())


def ports(family: list[int]) -> set[int]:
    """TCP ports on which these processes listen, and UDP ports that they have, as Linux says."""
    inodes = set()
    for process in family:
        for descriptor in Path(f"/proc/{process}/fd").iterdir():
            try:
                target = str(descriptor.readlink())
            except FileNotFoundError:  # closed since it was listed
                continue
            if target.startswith("socket:"):
                inodes.add(target.removeprefix("socket:[").removesuffix("]"))
    found = set()
    for table in ("tcp", "tcp6", "udp", "udp6"):
        for line in Path(f"/proc/net/{table}").read_text().splitlines()[1:]:
            fields = line.split()
            if fields[9] in inodes and (table.startswith("udp") or fields[3] == LISTENING):
                found.add(int(fields[1].rpartition(":")[2], 16))
    return found


def test_nothing_listens_that_was_not_asked_for(tmp_path: Path) -> None:
    port = free_port()
    running = service(tmp_path, port)
    try:
        with httpx2.Client(base_url=f"http://127.0.0.1:{port}", timeout=180.0) as client:
            answering(client)
        family = processes.family(running.running.pid)
        assert len(processes.workers(family)) == 2
        assert ports(family) == {port}
    finally:
        running.stop()


def at_work(done: Path) -> int:
    """Its process, once a file says so; the first of those who ask leaves its own there."""
    begun = done.with_suffix(".begun")
    with begun.open("a") as log:
        log.write(f"{os.getpid()}\n")
    while not done.exists():
        clock.now()
        os.sched_yield()
    return os.getpid()


async def begun(done: Path, times: int = 1) -> list[int]:
    """The processes that have begun to wait for a file."""
    while True:
        await asyncio.sleep(0.01)
        log = done.with_suffix(".begun")
        lines = log.read_text().split() if log.exists() else []
        if len(lines) >= times:
            return [int(line) for line in lines]


def test_a_worker_that_died_idle_costs_nothing() -> None:
    async def story(workers: LocalWorkers) -> None:
        first = await workers.run("a", os.getpid)
        os.kill(first, signal.SIGKILL)
        assert await workers.run("b", os.getpid) != first
        sent = os.urandom(3_000_017)
        assert await workers.run("c", bytes, sent) == sent
        with pytest.raises(ZeroDivisionError, match="division") as raised:
            await workers.run("d", divmod, 7, 0)
        assert "in reply_of" in raised.value.__notes__[0]

    with_one_worker(story)


def test_what_is_cancelled_before_it_begins_does_not_run_on() -> None:
    """The pipe that says so may be quicker than the one with the task."""
    early = threading.Event()
    early.set()
    events = {"a": early}
    succeeded, error = pickle.loads(local._reply(local.dumps(("a", clock.now)), events))
    assert (succeeded, type(error), events) == (False, Cancelled, {})
    assert pickle.loads(local._reply(local.dumps(("a", os.getpid)), events)) == (True, os.getpid())


def test_a_worker_killed_at_work_is_told_and_replaced(tmp_path: Path) -> None:
    async def story(workers: LocalWorkers) -> None:
        task = asyncio.ensure_future(workers.run("a", at_work, tmp_path / "a"))
        (first,) = await begun(tmp_path / "a")
        os.kill(first, signal.SIGKILL)
        with pytest.raises(ServiceError, match="signal 9"):
            await task
        assert await workers.run("b", os.getpid) != first

    with_one_worker(story)


def test_work_is_done_again_where_its_worker_went_with_another_process(tmp_path: Path) -> None:
    """The one that forks: a fork has one thread, and none of its locks is held for ever."""

    async def story(workers: LocalWorkers) -> None:
        forking = await workers.run("a", os.getppid)
        assert await asyncio.to_thread(threads, forking) == 1
        assert await workers.run("b", held_back) > 100_000
        task = asyncio.ensure_future(workers.run("c", at_work, tmp_path / "c"))
        (first,) = await begun(tmp_path / "c")
        os.kill(forking, signal.SIGKILL)
        _, second = await begun(tmp_path / "c", 2)
        (tmp_path / "c").touch()
        assert await task == second != first
        assert await workers.run("d", os.getppid) != forking

    with_one_worker(story)


def threads(process: int) -> int:
    return len([*Path(f"/proc/{process}/task").iterdir()])


def held_back() -> int:
    """In a worker: objects that its garbage collector leaves alone, and so shares."""
    assert "synthesis.pipeline.synthesise" in sys.modules
    assert "distributed" not in sys.modules
    assert gc.isenabled()
    return gc.get_freeze_count()


def test_one_that_is_stopped_takes_nobody_else_s_work_with_it(tmp_path: Path) -> None:
    async def told() -> None:
        async with local_workers(2, prepare) as workers:
            own, others = (
                asyncio.ensure_future(workers.run(key, at_work, tmp_path / key)) for key in "ab"
            )
            await begun(tmp_path / "a")
            (process,) = await begun(tmp_path / "b")
            await workers.stop("a")
            assert await asyncio.wait_for(workers.run("c", os.getpid), 60.0) != process
            (tmp_path / "b").touch()
            assert await others == process
            await asyncio.wait({own})

    asyncio.run(told())


def test_a_cancelled_one_ends_and_its_worker_stays(tmp_path: Path) -> None:
    async def story(workers: LocalWorkers) -> None:
        task = asyncio.ensure_future(workers.run("a", at_work, tmp_path / "a"))
        (process,) = await begun(tmp_path / "a")
        await workers.cancel(["a", "never sent"])
        with pytest.raises(Cancelled):
            await task
        assert await workers.run("b", os.getpid) == process

    with_one_worker(story)


def test_more_than_its_memory_is_told() -> None:
    """By the kernel, so that what grows faster than anybody looks does not take the machine."""

    async def told() -> None:
        async with local_workers(1, prepare, MIB) as workers:  # the least there is
            with pytest.raises(ServiceError, match="needed more than 1 MiB of memory") as raised:
                await workers.run("a", np.ones, 2**28)  # 2 GiB
            assert raised.value.problem is ProblemType.WORKER_LOST
            assert await workers.run("b", len, "goes on") == 7

    asyncio.run(told())


def test_its_share_of_the_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    """No core has more than another, however few workers there are."""
    monkeypatch.setattr(memory, "memory_of_this_machine", lambda: 2**32)
    monkeypatch.setattr(os, "cpu_count", lambda: 4)
    assert [share_of_memory(workers) * workers / 2**32 for workers in (2, 4, 8)] == pytest.approx(
        [0.475, 0.95, 0.95]
    )


def test_what_cannot_be_sent_back_is_an_error_of_its_own() -> None:
    async def story(workers: LocalWorkers) -> None:
        with pytest.raises(RuntimeError, match="NotReadable"):
            await workers.run("a", raise_what_cannot_be_read)
        assert await workers.run("b", len, "goes on") == 7

    with_one_worker(story)


class NotReadable(Exception):
    def __init__(self, one: int, other: int) -> None:
        super().__init__("one argument")


def raise_what_cannot_be_read() -> None:
    raise NotReadable(1, 2)


def test_forks_have_one_thread_of_the_linear_algebra() -> None:
    start_fork_server()
    assert os.environ.keys() >= ENVIRONMENT.keys()
