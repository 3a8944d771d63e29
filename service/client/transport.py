"""HTTP for the client: one interface, blocking or asynchronous.

The calls are written once, as coroutines over a `Transport`. `AsyncTransport` awaits.
`BlockingTransport` blocks and never suspends, so that a coroutine over it ends in one step: `run`.
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
class Request:
    """A request.

    Attributes:
        method, path, query, body, headers: of the request; ``path`` below the service's address.
        repeatable: whether it may be sent again when the response was lost: sending it twice has
            the same effect as once.
    """

    method: str
    path: str
    query: Mapping[str, Any] = field(default_factory=dict)
    body: bytes | None = None
    headers: Mapping[str, str] = field(default_factory=dict)
    repeatable: bool = True


@dataclass(frozen=True)
class Answer:
    """A response that has been read."""

    status: int
    headers: httpx2.Headers
    body: bytes


class ResponseStream(ABC):
    """A response of which only the headers have been read."""

    def __init__(self, response: httpx2.Response) -> None:
        self._response = response
        self.status, self.headers = response.status_code, response.headers

    @abstractmethod
    async def read(self) -> Answer:
        """The whole body."""

    @abstractmethod
    def chunks(self) -> AsyncIterator[bytes]:
        """The body in pieces, as sent."""

    @abstractmethod
    def events(self) -> AsyncGenerator[httpx2.ServerSentEvent, None]:
        """The body as server-sent events."""


class Transport(ABC):
    """Sends requests. Raises httpx2.TransportError where the service cannot be reached.

    Attributes:
        address: of the service.
    """

    address: str

    async def send(self, request: Request) -> Answer:
        """The response, whatever its status."""
        async with self.stream(request) as response:
            return await response.read()

    @abstractmethod
    def stream(self, request: Request) -> AbstractAsyncContextManager[ResponseStream]:
        """The response; its body is read, or not, within the context."""

    @abstractmethod
    async def pause(self, seconds: float) -> None:
        """Wait."""


class _AsyncResponse(ResponseStream):
    async def read(self) -> Answer:
        return Answer(self.status, self.headers, await self._response.aread())

    def chunks(self) -> AsyncIterator[bytes]:
        return self._response.aiter_raw()

    async def events(self) -> AsyncGenerator[httpx2.ServerSentEvent, None]:
        async for event in httpx2.EventSource(self._response):
            yield event


class AsyncTransport(Transport):
    """For asyncio."""

    def __init__(self, http: httpx2.AsyncClient) -> None:
        self._http, self.address = http, str(http.base_url)

    @asynccontextmanager
    async def stream(self, request: Request) -> AsyncIterator[ResponseStream]:
        async with self._http.stream(**_arguments(request)) as response:
            yield _AsyncResponse(response)

    async def pause(self, seconds: float) -> None:
        await asyncio.sleep(seconds)


class _BlockingResponse(ResponseStream):
    async def read(self) -> Answer:
        return Answer(self.status, self.headers, self._response.read())

    async def chunks(self) -> AsyncIterator[bytes]:
        for chunk in self._response.iter_raw():
            yield chunk

    async def events(self) -> AsyncGenerator[httpx2.ServerSentEvent, None]:
        for event in httpx2.EventSource(self._response):
            yield event


class BlockingTransport(Transport):
    """For callers without an event loop: its coroutines block and never suspend."""

    def __init__(self, http: httpx2.Client) -> None:
        self._http, self.address = http, str(http.base_url)

    @asynccontextmanager
    async def stream(self, request: Request) -> AsyncIterator[ResponseStream]:
        with self._http.stream(**_arguments(request)) as response:
            yield _BlockingResponse(response)

    async def pause(self, seconds: float) -> None:
        time.sleep(seconds)  # noqa: ASYNC251 (no event loop waits for this)


def run(coroutine: Coroutine[Any, Any, T]) -> T:
    """The result of a coroutine over a `BlockingTransport`."""
    try:
        coroutine.send(None)
    except StopIteration as ended:
        result: T = ended.value
        return result
    coroutine.close()
    raise RuntimeError(
        "The coroutine awaits an event loop: its transport is not a BlockingTransport."
    )


def _arguments(request: Request) -> dict[str, Any]:
    return {
        "method": request.method,
        "url": request.path,
        "params": dict(request.query) or None,
        "content": request.body,
        "headers": dict(request.headers),
    }
