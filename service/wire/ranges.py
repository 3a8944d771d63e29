"""Range requests (RFC 9110, section 14): an interrupted download can be continued.

A response with `Accept-Ranges: bytes`, a strong ETag and a length can be requested in parts. The
middleware here cuts the part out of any such response.
"""

from __future__ import annotations

import re

from fastapi import Request
from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.wire.errors import ProblemType
from service.wire.problem import problem_document, problem_response

IN_PARTS = {"Accept-Ranges": "bytes"}
RANGE = re.compile(r"bytes=(\d{0,18})-(\d{0,18})")


def span_of(wanted: str, size: int) -> tuple[int, int] | None:
    """First and last byte of a Range header, of ``size``; None where they are beyond the end."""
    match = RANGE.fullmatch(wanted)
    first, last = match.groups() if match else ("", "")
    if not first:  # a number of bytes at the end
        span = max(0, size - int(last or 0)), size - 1
    else:
        span = int(first), min(int(last), size - 1) if last else size - 1
    return span if span[0] <= span[1] else None


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
        self._span: tuple[int, int] | None = None  # None: send everything
        self._at, self._unsatisfiable = 0, False

    async def send(self, message: Message) -> None:
        if self._unsatisfiable:
            return
        if message["type"] == "http.response.start":
            message = self._start(message)
        elif self._span is not None:
            body = message.get("body", b"")
            start, end = self._span[0] - self._at, self._span[1] + 1 - self._at
            self._at += len(body)
            message = {**message, "body": body[max(0, start) : max(0, end)]}
        await self._send(message)
        if self._unsatisfiable:
            await self._send({"type": "http.response.body", "body": self._problem.body})

    def _start(self, message: Message) -> Message:
        """The start of the response: 206, 416, or as it is where there are no parts of it."""
        headers = MutableHeaders(scope=message)
        size, tag = headers.get("content-length"), headers.get("etag", "")
        has_ranges = headers.get("accept-ranges") == "bytes" and tag.startswith('"')
        if message["status"] != 200 or not has_ranges or size is None:
            return message
        if self._only_of is not None and self._only_of != tag:
            return message  # the file has changed since the caller got a part of it
        self._span = span_of(self._wanted, int(size))
        if self._span is None:
            self._unsatisfiable = True
            detail = f"Range: {self._wanted} of a file of {size} bytes. Leave Range out for all."
            self._problem = problem_response(
                Request(self._scope), problem_document(ProblemType.NO_SUCH_BYTES, detail),
                {"Content-Range": f"bytes */{size}"},
            )  # fmt: skip
            return {**message, "status": 416, "headers": self._problem.raw_headers}
        first, last = self._span
        headers["content-range"] = f"bytes {first}-{last}/{size}"
        headers["content-length"] = str(last - first + 1)
        return {**message, "status": 206}
