"""Range requests (RFC 9110, section 14): an interrupted download can be continued.

A response with `Accept-Ranges: bytes`, a strong ETag and a length can be requested in parts. The
middleware here cuts the part out of any such response.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from fastapi import Request
from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.wire.errors import ProblemType
from service.wire.problem import problem_document, problem_response

IN_PARTS = {"Accept-Ranges": "bytes"}
RANGE = re.compile(r"bytes=(\d{0,18})-(\d{0,18})")


@dataclass(frozen=True)
class ByteRange:
    """Bytes from ``first`` up to ``last``, both included, of ``size``."""

    first: int
    last: int
    size: int

    @classmethod
    def of(cls, wanted: str, size: int) -> ByteRange | None:
        """The range of a header; None where it is not a single one, or beyond the end."""
        match = RANGE.fullmatch(wanted)
        if match is None or match.group(0) == "bytes=-":
            return None
        first, last = match.groups()
        if not first:  # a number of bytes at the end
            span = cls(max(0, size - int(last)), size - 1, size)
        else:
            span = cls(int(first), min(int(last), size - 1) if last else size - 1, size)
        return span if span.first <= span.last else None


class Ranges:
    """Middleware around all that changes bytes: parts are of the uncompressed file."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        headers = Headers(scope=scope) if scope["type"] == "http" else Headers()
        wanted = headers.get("range", "")
        if scope.get("method") != "GET" or not RANGE.fullmatch(wanted):
            await self._app(scope, receive, send)
            return
        plain = [(name, value) for name, value in scope["headers"] if name != b"accept-encoding"]
        scope = {**scope, "headers": plain}
        sender = _RangeSender(wanted, headers.get("if-range"), scope, send)
        await self._app(scope, receive, sender.send)


class _RangeSender:
    """Sends the range of one response, if that can be requested in parts."""

    def __init__(self, wanted: str, only_of: str | None, scope: Scope, send: Send) -> None:
        self._wanted, self._only_of, self._scope, self._send = wanted, only_of, scope, send
        self._span: ByteRange | None = None  # None: send everything
        self._at, self._unsatisfiable = 0, False

    async def send(self, message: Message) -> None:
        if message["type"] == "http.response.start":
            self._begin(message)
            if self._unsatisfiable:
                await self._send_416(message)
        elif self._span is not None:
            body = message.get("body", b"")
            start, end = self._span.first - self._at, self._span.last + 1 - self._at
            self._at += len(body)
            message = {**message, "body": body[max(0, start) : max(0, end)]}
        if not self._unsatisfiable:
            await self._send(message)

    async def _send_416(self, message: Message) -> None:
        size = Headers(raw=message["headers"])["content-length"]
        detail = f"Range: {self._wanted} of a file of {size} bytes. Leave Range out for all of it."
        problem = problem_response(
            Request(self._scope), problem_document(ProblemType.NO_SUCH_BYTES, detail),
            {"Content-Range": f"bytes */{size}"},
        )  # fmt: skip
        await self._send({"type": message["type"], "status": 416, "headers": problem.raw_headers})
        await self._send({"type": "http.response.body", "body": problem.body})

    def _begin(self, message: Message) -> None:
        headers = MutableHeaders(scope=message)
        size, tag = headers.get("content-length"), headers.get("etag", "")
        has_ranges = headers.get("accept-ranges") == "bytes" and tag.startswith('"')
        if message["status"] != 200 or not has_ranges or size is None:
            return
        if self._only_of is not None and self._only_of != tag:
            return  # the file has changed since the caller got a part of it
        self._span = span = ByteRange.of(self._wanted, int(size))
        if span is None:
            self._unsatisfiable = True
            return
        message["status"] = 206
        headers["content-range"] = f"bytes {span.first}-{span.last}/{span.size}"
        headers["content-length"] = str(span.last - span.first + 1)
