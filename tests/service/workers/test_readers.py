"""Long bodies are read in other processes, which are ended where they take too long."""

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
from service.wire.validation import parse_json
from service.workers.readers import Readers
from synthesis.spec.design_spec import DesignSpec
from tests.service.wire.hostile_bodies import CAM


@pytest.fixture
def readers() -> Iterator[Readers]:
    found = Readers(Settings.model_validate({"readers": 1, "reading_s": 0.5, "max_waiting": 2}))
    yield found
    found.close()


def test_what_is_read_elsewhere_is_as_if_read_here(readers: Readers) -> None:
    async def run() -> None:
        assert await readers.run(os.getpid) not in (os.getpid(), None)
        error = ProblemType.NOT_JSON("No.", {"a": "b"}, [{"pointer": ""}])
        assert vars(await readers.run(copy.copy, error)) == vars(error)  # as it was sent
        with pytest.raises(ServiceError, match="empty") as raised:
            await readers.run(parse_json, b"")
        assert raised.value.problem is ProblemType.NOT_JSON

    asyncio.run(run())


def test_reading_that_takes_too_long_is_ended(readers: Readers) -> None:
    async def run() -> None:
        first = await readers.run(os.getpid)
        with pytest.raises(ServiceError, match=r"more than 0\.5 s of processor time") as raised:
            await readers.run(pow, 3, 10**9)
        assert raised.value.problem.status == 413
        assert await readers.run(os.getpid) != first

    asyncio.run(run())


def test_a_reader_that_dies_is_replaced(readers: Readers) -> None:
    async def run() -> None:
        with pytest.raises(ServiceError, match="died") as raised:
            await readers.run(signal.raise_signal, signal.SIGKILL)
        assert raised.value.problem.status == 503
        assert await readers.run(os.getpid)

    asyncio.run(run())


def test_few_bodies_may_wait(readers: Readers) -> None:
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
