"""What a client needs of HTTP: one interface, for callers who wait and for callers who await.

The calls are written once, as coroutines over a `Wire`. `AwaitingWire` really awaits. `WaitingWire`
blocks instead and never suspends, so that a coroutine over it runs to its end in one step: `run`.
"""

from __future__ import annotations

import asyncio
import time
from abc import ABC, abstractmethod
from collections.abc import AsyncGenerator, AsyncIterator, Coroutine, Mapping
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from dataclasses import dataclass, field
from typing import Any, TypeVar

import httpx2

T = TypeVar("T")


@dataclass(frozen=True)
class Asked:
    """A request.

    Attributes:
        method, path, query, body, headers: of the request; ``path`` below the service's address.
        repeatable: asking twice does no more than asking once, so that it may be asked again where
            the answer to the first time was lost.
    """

    method: str
    path: str
    query: Mapping[str, Any] = field(default_factory=dict)
    body: bytes | None = None
    headers: Mapping[str, str] = field(default_factory=dict)
    repeatable: bool = True


@dataclass(frozen=True)
class Answer:
    """An answer that has been read."""

    status: int
    headers: httpx2.Headers
    body: bytes


class Opened(ABC):
    """An answer of which only the head has been read."""

    def __init__(self, response: httpx2.Response) -> None:
        self._response = response
        self.status, self.headers = response.status_code, response.headers

    @abstractmethod
    async def read(self) -> Answer:
        """The rest at once."""

    @abstractmethod
    def chunks(self) -> AsyncIterator[bytes]:
        """The rest piece by piece, as it was sent."""

    @abstractmethod
    def events(self) -> AsyncGenerator[httpx2.ServerSentEvent, None]:
        """The rest as server-sent events."""


class Wire(ABC):
    """Sends requests. Raises httpx2.TransportError where the service is not there.

    Attributes:
        address: of the service.
    """

    address: str

    async def send(self, asked: Asked) -> Answer:
        """The answer, whatever its status."""
        async with self.opened(asked) as opened:
            return await opened.read()

    @abstractmethod
    def opened(self, asked: Asked) -> AbstractAsyncContextManager[Opened]:
        """The answer's head; the rest is read or left within the context."""

    @abstractmethod
    async def pause(self, seconds: float) -> None:
        """Some time goes by."""


class _Awaited(Opened):
    async def read(self) -> Answer:
        return Answer(self.status, self.headers, await self._response.aread())

    def chunks(self) -> AsyncIterator[bytes]:
        return self._response.aiter_raw()

    async def events(self) -> AsyncGenerator[httpx2.ServerSentEvent, None]:
        async for event in httpx2.EventSource(self._response):
            yield event


class AwaitingWire(Wire):
    """For asyncio."""

    def __init__(self, http: httpx2.AsyncClient) -> None:
        self._http, self.address = http, str(http.base_url)

    @asynccontextmanager
    async def opened(self, asked: Asked) -> AsyncIterator[Opened]:
        async with self._http.stream(**_arguments(asked)) as response:
            yield _Awaited(response)

    async def pause(self, seconds: float) -> None:
        await asyncio.sleep(seconds)


class _Read(Opened):
    async def read(self) -> Answer:
        return Answer(self.status, self.headers, self._response.read())

    async def chunks(self) -> AsyncIterator[bytes]:
        for chunk in self._response.iter_raw():
            yield chunk

    async def events(self) -> AsyncGenerator[httpx2.ServerSentEvent, None]:
        for event in httpx2.EventSource(self._response):
            yield event


class WaitingWire(Wire):
    """For callers without an event loop: its coroutines block, and never suspend."""

    def __init__(self, http: httpx2.Client) -> None:
        self._http, self.address = http, str(http.base_url)

    @asynccontextmanager
    async def opened(self, asked: Asked) -> AsyncIterator[Opened]:
        with self._http.stream(**_arguments(asked)) as response:
            yield _Read(response)

    async def pause(self, seconds: float) -> None:
        time.sleep(seconds)  # noqa: ASYNC251 (no event loop waits for this)


def run(coroutine: Coroutine[Any, Any, T]) -> T:
    """What a coroutine over a `WaitingWire` returns."""
    try:
        coroutine.send(None)
    except StopIteration as ended:
        result: T = ended.value
        return result
    coroutine.close()
    raise RuntimeError("It waits for an event loop: its wire is not a WaitingWire.")


def _arguments(asked: Asked) -> dict[str, Any]:
    return {
        "method": asked.method,
        "url": asked.path,
        "params": dict(asked.query) or None,
        "content": asked.body,
        "headers": dict(asked.headers),
    }
