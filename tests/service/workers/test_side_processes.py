"""What is done beside the event loop: its processes are ended where they take too much."""

from __future__ import annotations

import asyncio
import copy
import json
import os
import signal
import time
from collections.abc import Iterator
from typing import Any

import pytest
from fastapi import Request
from starlette.types import Message

from service.resources.records import DESIGNS
from service.settings import Settings
from service.wire.body import SHORT, read_body
from service.wire.errors import ProblemType, ServiceError
from service.wire.fair_queue import current_owner
from service.wire.validation import parse_json
from service.workers.memory import MIB
from service.workers.side_processes import SideProcesses, readers_of, writers_of
from synthesis.errors import TimeBudgetExceeded
from synthesis.spec.design_spec import DesignSpec
from tests.service.wire.hostile_bodies import CAM


@pytest.fixture
def readers() -> Iterator[SideProcesses]:
    found = readers_of(Settings.model_validate({"readers": 1, "reading_s": 0.5, "max_waiting": 2}))
    yield found
    found.close()


def test_what_is_read_elsewhere_is_as_if_read_here(readers: SideProcesses) -> None:
    async def run() -> None:
        assert await readers.run(os.getpid) not in (os.getpid(), None)
        error = ProblemType.NOT_JSON("No.", {"a": "b"}, [{"pointer": ""}])
        assert vars(await readers.run(copy.copy, error)) == vars(error)  # as it was sent
        with pytest.raises(ServiceError, match="empty") as raised:
            await readers.run(parse_json, b"")
        assert raised.value.problem is ProblemType.NOT_JSON

    asyncio.run(run())


def test_reading_that_takes_too_long_is_ended(readers: SideProcesses) -> None:
    async def run() -> None:
        first = await readers.run(os.getpid)
        with pytest.raises(ServiceError, match=r"more than 0\.5 s of processor time") as raised:
            await readers.run(pow, 3, 10**9)
        assert raised.value.problem.status == 413
        assert await readers.run(os.getpid) != first

    asyncio.run(run())


def test_a_reader_that_dies_is_replaced(readers: SideProcesses) -> None:
    async def run() -> None:
        with pytest.raises(ServiceError, match="died") as raised:
            await readers.run(signal.raise_signal, signal.SIGKILL)
        assert raised.value.problem.status == 503
        assert await readers.run(os.getpid)

    asyncio.run(run())


def test_a_file_that_takes_too_long_is_ended() -> None:
    writers = writers_of(Settings.model_validate({"readers": 1, "time_budget_s": 0.3}))

    async def run() -> None:
        with pytest.raises(TimeBudgetExceeded):
            await writers.run(pow, 3, 10**9)
        assert await writers.run(len, "goes on") == 7

    try:
        asyncio.run(run())
    finally:
        writers.close()


def test_what_takes_too_much_memory_is_ended() -> None:
    """By the kernel, however fast it grows; what has less goes on."""
    helpers = SideProcesses(1, 1, 5.0, "works", AssertionError, memory=MIB)  # the least there is

    async def run() -> None:
        with pytest.raises(ServiceError, match="needed more than 1 MiB of memory") as raised:
            await helpers.run(bytearray, 2**31)
        assert raised.value.problem is ProblemType.WORKER_LOST
        assert await helpers.run(bytes, 5) == bytes(5)

    try:
        asyncio.run(run())
    finally:
        helpers.close()


def test_owners_are_served_in_turn(readers: SideProcesses) -> None:
    """However many one asks, another waits for what is under way alone, even if he has left."""
    ended: list[str] = []

    async def ask(owner: str) -> None:
        current_owner.set(owner)
        await readers.run(time.sleep, 0.1)
        ended.append(owner)

    async def run() -> None:
        await readers.run(len, "started")
        gone = asyncio.create_task(ask("loud"))
        loud = [asyncio.create_task(ask("loud")) for _ in range(2)]
        await asyncio.sleep(0.02)
        gone.cancel()
        await asyncio.gather(*loud, asyncio.create_task(ask("quiet")))
        assert ended == ["quiet", "loud", "loud"]

    asyncio.run(run())


def test_few_bodies_may_wait(readers: SideProcesses) -> None:
    async def run() -> None:
        waiting = [asyncio.create_task(readers.run(time.sleep, 0.2)) for _ in range(3)]
        await asyncio.sleep(0.01)
        with pytest.raises(ServiceError, match="2 long bodies are waiting") as raised:
            await readers.run(os.getpid)
        assert raised.value.problem.status == 429
        await asyncio.gather(*waiting)

    asyncio.run(run())


@pytest.mark.parametrize(("size", "elsewhere"), [(SHORT, 0), (SHORT + 1, 1)])
def test_short_bodies_are_read_at_once(size: int, elsewhere: int) -> None:
    body = json.dumps(CAM).encode().ljust(size)
    read: list[int] = []

    class Counting:
        async def run(self, work: Any, *arguments: Any) -> Any:
            read.append(len(arguments[0]))
            return work(*arguments)

    async def receive() -> Message:
        return {"type": "http.request", "body": body}

    scope = {"type": "http", "headers": [(b"content-type", b"application/json")]}
    readers: Any = Counting()
    question, same = asyncio.run(
        read_body(Request(scope, receive), readers, DesignSpec, max_bytes=10_000)
    )
    spec = DesignSpec.model_validate_json(body)
    assert same == body
    assert DESIGNS.id_of(question) == DESIGNS.id_of(spec)
    assert len(read) == elsewhere
