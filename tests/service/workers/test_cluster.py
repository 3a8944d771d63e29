"""The engine's own workers come back whatever ends them, and nobody starts one twice."""

from __future__ import annotations

import asyncio
import gc
import os
import signal
import sys
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import dask
import pytest
from distributed import Client

from service.workers.engine import CONFIGURATION, _own_cluster
from service.workers.prefork import ENVIRONMENT, start_fork_server
from tests.service.conftest import settings_for

HASTY = {"distributed.deploy.lost-worker-timeout": "10ms"}  # shorter than any restart


def with_one_worker(folder: Path, story: Callable[[Any, Any], Awaitable[None]]) -> None:
    """Tell a story on a cluster of one worker."""

    async def reported() -> None:
        connect: Any = Client
        with dask.config.set({**CONFIGURATION, **HASTY}):
            async with (
                _own_cluster(settings_for(folder, workers=1)) as cluster,
                connect(await cluster.in_process_address(), asynchronous=True) as client,
            ):
                await client.wait_for_workers(1)
                await story(cluster, client)

    asyncio.run(reported())


async def process_of(client: Any) -> int:
    number: int = await client.submit(os.getpid, pure=False)
    return number


async def killed(cluster: Any, client: Any, process: int | None = None) -> int:
    """Kill the worker, or another process, and wait until the scheduler has lost the worker."""
    (address,) = cluster.scheduler.workers
    process = process or await process_of(client)
    os.kill(process, signal.SIGKILL)
    while address in cluster.scheduler.workers:  # noqa: ASYNC110 (Dask has no event for it)
        await asyncio.sleep(0.01)
    return process


def test_no_socket_lies_between_the_service_and_its_scheduler(tmp_path: Path) -> None:
    async def story(cluster: Any, client: Any) -> None:
        own = os.getpid()
        assert await process_of(client) != own
        assert client.scheduler.address.startswith("inproc://")
        addresses = [*cluster.scheduler.workers, cluster.scheduler_address]
        assert all(address.startswith("tcp://127.0.0.1:") for address in addresses)
        with pytest.raises(ZeroDivisionError, match="division"):
            await client.submit(divmod, 7, 0, pure=False)
        sent = os.urandom(3_000_017)
        assert await client.submit(bytes, sent, pure=False) == sent

    with_one_worker(tmp_path, story)


def test_a_killed_worker_comes_back_under_the_same_keeper(tmp_path: Path) -> None:
    async def story(cluster: Any, client: Any) -> None:
        (keeper,) = cluster.workers.values()
        for _ in range(2):  # the second restart is where two keepers used to meet
            first = await killed(cluster, client)
            assert await process_of(client) != first
            assert list(cluster.workers.values()) == [keeper]
            assert keeper.status.name == "running"

    with_one_worker(tmp_path, story)


def test_a_keeper_that_has_ended_is_replaced(tmp_path: Path) -> None:
    async def story(cluster: Any, client: Any) -> None:
        first = await process_of(client)
        (keeper,) = cluster.workers.values()
        cluster.replace_lost_workers()
        assert list(cluster.workers.values()) == [keeper]
        await keeper.close()
        cluster.replace_lost_workers()
        cluster.replace_lost_workers()
        assert await process_of(client) != first
        while not cluster.workers:  # noqa: ASYNC110 (filled when the worker is known to be up)
            await asyncio.sleep(0.01)
        (another,) = cluster.workers.values()
        assert another is not keeper

    with_one_worker(tmp_path, story)


def test_workers_are_forks_of_one_process_without_threads(tmp_path: Path) -> None:
    """A fork has the forking thread only: what another one holds then is never let go of."""

    async def story(cluster: Any, client: Any) -> None:
        forking: int = await client.submit(os.getppid, pure=False)
        assert threads(forking) == 1
        assert await client.submit(held_back, pure=False) > 100_000
        first = await process_of(client)
        await killed(cluster, client, forking)  # its keeper takes the worker for lost then
        assert await process_of(client) != first
        assert await client.submit(os.getppid, pure=False) != forking
        assert await client.submit(held_back, pure=False) > 100_000

    with_one_worker(tmp_path, story)


def test_forks_have_the_environment_that_dask_gives_to_workers() -> None:
    """And their number of threads by it, which NumPy reads where it is imported."""
    question = dask.config.get("distributed.nanny.pre-spawn-environ")
    assert {name: str(value) for name, value in question.items()}.items() <= ENVIRONMENT.items()
    start_fork_server()
    assert os.environ.keys() >= ENVIRONMENT.keys()


def threads(process: int) -> int:
    return len([*Path(f"/proc/{process}/task").iterdir()])


def held_back() -> int:
    """In a worker: objects that its garbage collector leaves alone, and so shares."""
    assert "synthesis.pipeline.synthesise" in sys.modules
    assert gc.isenabled()
    return gc.get_freeze_count()


def test_an_unknown_worker_that_leaves_does_not_end_the_watch(tmp_path: Path) -> None:
    async def story(cluster: Any, client: Any) -> None:
        cluster._update_worker_status("remove", "tcp://127.0.0.1:1")
        await killed(cluster, client)
        await process_of(client)
        assert not cluster._watch_worker_status_task.done()

    with_one_worker(tmp_path, story)
