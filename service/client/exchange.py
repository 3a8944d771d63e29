"""Exchange of a request for its response: when it is sent again, and after what pause.

Downloads continue after a lost connection, in this process or in a later one.
"""

from __future__ import annotations

import asyncio
import json
import random
from collections.abc import AsyncGenerator, Callable, Mapping
from contextlib import aclosing
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from email.utils import parsedate_to_datetime
from pathlib import Path
from typing import Any, TypeVar

import httpx2

T = TypeVar("T")
ProgressCallback = Callable[[int, int | None], None]  # bytes received, and in all if known
BUSY = frozenset({429, 503})  # from the service, with Retry-After
PROXY = frozenset({502, 503, 504})  # from a proxy before the service
PROBLEM = "application/problem+json"


class ClientError(Exception):
    """Base class of the client's errors."""


class Unreachable(ClientError):
    """No response, or a broken one, after all tries."""


class Refused(ClientError):
    """The service answered with a problem document; ``str`` of it is its detail, and each error.

    Attributes:
        problem: the document (RFC 9457) as sent; for another response, such as a proxy's, one made
            from its status.
        retry_after_s: Retry-After of the response [s]; None where there is none.
    """

    def __init__(
        self, problem: dict[str, Any], status: int, retry_after_s: float | None = None
    ) -> None:
        detail = problem.get("detail") or problem.get("title") or f"HTTP status {status}"
        several = problem.get("errors") or ()
        lines = [
            f"{each.get('pointer') or each.get('parameter') or 'the body'}: {sentences(each)}"
            for each in (several if len(several) > 1 else ())
        ]
        super().__init__("\n".join([detail, *lines]))
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


def sentences(violation: Mapping[str, Any]) -> str:
    """Rule and remedy of an entry of ``errors``, in two sentences."""
    return f"{violation['rule'].rstrip('.')}. {violation['remedy']}".strip()


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
                    times = "once" if tried == 1 else f"{tried} times"
                    why = str(error) or type(error).__name__
                    text = f"{request.method} {request.path}, tried {times}: {why}."
                    if not request.repeatable:
                        text += " It was not sent again, as that might repeat its effect."
                    raise Unreachable(text) from error
                pause: float | None = self.retries.pause_s(max(tried, 1))
            else:
                pause = self._pause_after_refusal(response, tried)
            if pause is None:
                raise _refusal(response)
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


def _refusal(response: httpx2.Response) -> Refused:
    """The exception for a response with a status from 400 on."""
    status, problem = response.status_code, None
    if PROBLEM in response.headers.get("content-type", ""):
        problem = response.json()
    if not isinstance(problem, dict):
        text = response.content[:200].decode("utf-8", "replace").strip()
        detail = f"HTTP status {status} without a problem document: {text or 'empty'}"
        problem = {"title": "No problem document", "status": status, "detail": detail}
    return Refused(problem, status, _retry_after_s(response.headers))


class Part:
    """The beginning of a file, next to the target, and a note on which file it is a part of."""

    def __init__(self, target: Path, request: str) -> None:
        self.request = request
        self.file = target.with_name(f"{target.name}.part")  # the bytes received so far
        self.note = target.with_name(f"{target.name}.part.json")

    def received(self) -> tuple[str, int]:
        """Strong ETag and number of the bytes received; ("", 0) where they cannot be used."""
        try:
            note = json.loads(self.note.read_text(encoding="utf-8"))
            size = self.file.stat().st_size
        except (OSError, ValueError):
            return "", 0
        same = note.get("request") == self.request
        return (note["etag"], size) if same and size else ("", 0)

    def begin(self, etag: str) -> None:
        """Begin with the first byte; without a strong ETag it cannot be continued later."""
        self.file.parent.mkdir(parents=True, exist_ok=True)
        self.note.unlink(missing_ok=True)
        self.file.write_bytes(b"")
        if etag.startswith('"'):
            note = {"request": self.request, "etag": etag}
            self.note.write_text(json.dumps(note), encoding="utf-8")

    def is_whole(self, response: httpx2.Response) -> bool:
        """Whether a response says that nothing is left of the file to be sent."""
        span = response.headers.get("content-range")
        return response.status_code == 416 and span == f"bytes */{self.received()[1]}"

    async def receive(
        self, response: httpx2.Response
    ) -> AsyncGenerator[tuple[int, int | None], None]:
        """Append the bytes of a response; after each chunk, the bytes so far and in all."""
        if self.is_whole(response):
            return
        (etag, have), headers = self.received(), response.headers
        encoding = headers.get("content-encoding", "identity")
        if encoding != "identity":
            raise ClientError(
                f"{self.request} was sent as {encoding}, though requested without encoding."
            )
        if response.status_code != 206:
            self.begin(headers.get("etag", ""))
            have = 0
        else:  # the bytes have to be those that were requested
            span = headers.get("content-range", "")
            if not (headers.get("etag") == etag and span.startswith(f"bytes {have}-")):
                self.note.unlink(missing_ok=True)
                raise httpx2.RemoteProtocolError(f"another range ({span}) than requested")
        length = headers.get("content-length")
        total = None if length is None else have + int(length)
        async for chunk in response.aiter_raw():
            with self.file.open("ab") as file:
                file.write(chunk)
            have += len(chunk)
            yield have, total


async def download(
    exchange: Exchange, request: Request, target: Path, progress: ProgressCallback | None = None
) -> Path:
    """Download a file to ``target``, which appears when it is complete.

    Until then the bytes are in ``target``.part; called again, it continues with them if the service
    still has the same file (its strong ETag), and begins anew if not.

    ``progress`` is called with the bytes received, and the total (None: unknown). Every byte resets
    the number of tries; OSError where the file cannot be written.
    """
    query = sorted(request.query.items())
    part = Part(target, f"{exchange.http.base_url}{request.path}?{query}")

    def next_request() -> Request:
        etag, have = part.received()
        resuming = {"Range": f"bytes={have}-", "If-Range": etag} if have else {}
        # Ranges count bytes of the uncompressed file.
        return replace(request, headers={"Accept-Encoding": "identity", **resuming})

    async for have, total in exchange.receive(
        next_request, part.receive, lambda r: r.status_code < 400 or part.is_whole(r)
    ):
        if progress is not None:
            progress(have, total)
    part.file.replace(target)
    part.note.unlink(missing_ok=True)
    return target
