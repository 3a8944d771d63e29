"""Exchange of a request for its response: when it is sent again, and after what pause."""

from __future__ import annotations

import asyncio
import random
from collections.abc import AsyncGenerator, Callable, Mapping
from contextlib import aclosing
from dataclasses import dataclass, field
from datetime import UTC, datetime
from email.utils import parsedate_to_datetime
from typing import Any, TypeVar

import httpx2

T = TypeVar("T")
BUSY = frozenset({429, 503})  # from the service, with Retry-After
PROXY = frozenset({502, 503, 504})  # from a proxy before the service
PROBLEM = "application/problem+json"


class ClientError(Exception):
    """Base class of the client's errors."""


class Unreachable(ClientError):
    """No response, or a broken one, after all tries."""


class Refused(ClientError):
    """The service answered with a problem document; ``str`` of it is the problem's detail.

    Attributes:
        problem: the document (RFC 9457) as sent; for another response, such as a proxy's, one made
            from its status.
        status: the HTTP status.
        retry_after_s: Retry-After of the response [s]; None where there is none.
    """

    def __init__(
        self, problem: dict[str, Any], status: int, retry_after_s: float | None = None
    ) -> None:
        super().__init__(problem.get("detail") or problem.get("title") or f"HTTP status {status}")
        self.problem, self.status, self.retry_after_s = problem, status, retry_after_s

    @property
    def kind(self) -> str:
        """The kind of problem, such as ``invalid-request``: the end of its type."""
        return str(self.problem.get("type", "")).rpartition("/")[2]

    @property
    def errors(self) -> list[dict[str, Any]]:
        """Each wrong field: where, value, rule, way out."""
        return list(self.problem.get("errors", ()))

    @property
    def best(self) -> dict[str, Any] | None:
        """With status 504: the best answer found in time."""
        return self.problem.get("best")


@dataclass(frozen=True)
class Retries:
    """How often and how long a client tries.

    Attributes:
        tries: how often a request is sent at most.
        first_s: pause [s] after the first try where the service names none; doubled every time, up
            to ``most_s``, and shortened at random so that clients do not retry together.
        patience_s: longest Retry-After [s] that is waited for; a longer one is an error.
    """

    tries: int = 5
    first_s: float = 0.5
    most_s: float = 20.0
    patience_s: float = 120.0

    def pause_s(self, tried: int) -> float:
        """The pause [s] after so many tries, where the service names none."""
        return random.uniform(0.5, 1.0) * min(self.first_s * 2.0 ** (tried - 1), self.most_s)


@dataclass(frozen=True)
class Request:
    """A request; ``path`` is below the service's address.

    ``repeatable``: sending it twice has the same effect as once, so that it may be sent again when
    the response was lost.
    """

    method: str
    path: str
    query: Mapping[str, Any] = field(default_factory=dict)
    body: bytes | None = None
    headers: Mapping[str, str] = field(default_factory=dict)
    repeatable: bool = True


@dataclass(frozen=True)
class Exchange:
    """Sends requests with ``http``, again as ``retries`` says."""

    http: httpx2.AsyncClient
    retries: Retries

    async def send(self, request: Request) -> httpx2.Response:
        """The response with its body; see ``receive`` for errors."""

        async def read(response: httpx2.Response) -> AsyncGenerator[httpx2.Response, None]:
            await response.aread()
            yield response

        async with aclosing(self.receive(lambda: request, read)) as responses:
            return await anext(responses)

    async def receive(
        self,
        next_request: Callable[[], Request],
        read: Callable[[httpx2.Response], AsyncGenerator[T, None]],
        accepts: Callable[[httpx2.Response], bool] = lambda response: response.status_code < 400,
    ) -> AsyncGenerator[T, None]:
        """What ``read`` yields of the response; every item resets the number of tries.

        Args:
            next_request: the request of the next try, which may continue where the last one ended.
            read: makes items of an accepted response, of which only the headers have been read.

        Raises:
            Refused: a response that is not accepted. Unreachable: no response.
        """
        tried = 0
        while True:
            tried, request = tried + 1, next_request()
            try:
                async with self.http.stream(
                    request.method, request.path, params=dict(request.query) or None,
                    content=request.body, headers=dict(request.headers),
                ) as response:  # fmt: skip
                    if accepts(response):
                        async with aclosing(read(response)) as items:
                            async for item in items:
                                tried = 0
                                yield item
                        return
                    await response.aread()
            except httpx2.TransportError as error:
                if tried >= self.retries.tries or not request.repeatable:
                    raise _unreachable(request, error, tried) from error
                pause: float | None = self.retries.pause_s(max(tried, 1))
            else:
                pause = self._pause_after_refusal(response, tried)
            if pause is None:
                raise _refused(response)
            await asyncio.sleep(pause)

    def _pause_after_refusal(self, response: httpx2.Response, tried: int) -> float | None:
        """Seconds until a refused request is sent again; None where it is not."""
        if tried >= self.retries.tries:
            return None
        wait, status = _retry_after_s(response.headers), response.status_code
        if status in BUSY and wait is not None:
            return wait if wait <= self.retries.patience_s else None
        from_proxy = status in PROXY and PROBLEM not in response.headers.get("content-type", "")
        return self.retries.pause_s(tried) if from_proxy else None


def _retry_after_s(headers: httpx2.Headers) -> float | None:
    """Retry-After in seconds from now, given as a number or as a date; None without one."""
    text = headers.get("retry-after", "").strip()
    if text.isascii() and text.isdecimal():
        return float(text)
    try:
        until = parsedate_to_datetime(text)
    except ValueError:
        return None
    if until.tzinfo is None:
        until = until.replace(tzinfo=UTC)
    return max(0.0, (until - datetime.now(UTC)).total_seconds())


def _refused(response: httpx2.Response) -> Refused:
    """The exception for a response with a status from 400 on."""
    status, problem = response.status_code, None
    if PROBLEM in response.headers.get("content-type", ""):
        problem = response.json()
    if not isinstance(problem, dict):
        text = response.content[:200].decode("utf-8", "replace").strip()
        detail = f"HTTP status {status} without a problem document: {text or 'empty'}"
        problem = {"title": "No problem document", "status": status, "detail": detail}
    return Refused(problem, status, _retry_after_s(response.headers))


def _unreachable(request: Request, error: Exception, tried: int) -> Unreachable:
    """The exception for a request without a response."""
    again = "" if request.repeatable else " It was not sent again, as that might repeat its effect."
    times = "once" if tried == 1 else f"{tried} times"
    why = str(error) or type(error).__name__
    return Unreachable(f"{request.method} {request.path}, tried {times}: {why}.{again}")
