"""A part of a file (RFC 9110, section 14): downloads that broke off go on where they were.

Answers say by `Accept-Ranges: bytes`, a strong ETag and their length that they can be had in parts;
cutting them is done here, in one place for all of them.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from fastapi import Request
from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.wire.errors import BY_STATUS
from service.wire.problem import document, respond

IN_PARTS = {"Accept-Ranges": "bytes"}
WANTED = re.compile(r"bytes=(\d{0,18})-(\d{0,18})")


@dataclass(frozen=True)
class Span:
    """Bytes from ``first`` up to ``last``, both included, of ``size``."""

    first: int
    last: int
    size: int

    @classmethod
    def of(cls, wanted: str, size: int) -> Span | None:
        """What a Range asks for; None where it is no single range of bytes, or beyond the end."""
        found = WANTED.fullmatch(wanted)
        if found is None or found.group(0) == "bytes=-":
            return None
        first, last = found.groups()
        if not first:  # so many at the end
            span = cls(max(0, size - int(last)), size - 1, size)
        else:
            span = cls(int(first), min(int(last), size - 1) if last else size - 1, size)
        return span if span.first <= span.last else None


class Ranges:
    """Around everything that changes bytes: what is asked for in parts is not compressed."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        asked = Headers(scope=scope) if scope["type"] == "http" else Headers()
        wanted = asked.get("range", "")
        if scope.get("method") != "GET" or not WANTED.fullmatch(wanted):
            await self._app(scope, receive, send)
            return
        plain = [(name, value) for name, value in scope["headers"] if name != b"accept-encoding"]
        scope = {**scope, "headers": plain}
        cut = _Cut(wanted, asked.get("if-range"), scope, send)
        await self._app(scope, receive, cut.send)


class _Cut:
    """Lets a part of one answer through, if it is an answer that is had in parts."""

    def __init__(self, wanted: str, only_of: str | None, scope: Scope, send: Send) -> None:
        self._wanted, self._only_of, self._scope, self._send = wanted, only_of, scope, send
        self._span: Span | None = None  # None lets everything through
        self._at, self._over = 0, False

    async def send(self, message: Message) -> None:
        if message["type"] == "http.response.start":
            self._begin(message)
            if self._over:
                await self._no_such_bytes(message)
        elif self._span is not None:
            body = message.get("body", b"")
            start, end = self._span.first - self._at, self._span.last + 1 - self._at
            self._at += len(body)
            message = {**message, "body": body[max(0, start) : max(0, end)]}
        if not self._over:
            await self._send(message)

    async def _no_such_bytes(self, message: Message) -> None:
        size = Headers(raw=message["headers"])["content-length"]
        detail = f"Range: {self._wanted} of a file of {size} bytes. Leave Range out for all of it."
        told = respond(
            Request(self._scope), document(BY_STATUS[416], detail),
            {"Content-Range": f"bytes */{size}"},
        )  # fmt: skip
        await self._send({"type": message["type"], "status": 416, "headers": told.raw_headers})
        await self._send({"type": "http.response.body", "body": told.body})

    def _begin(self, message: Message) -> None:
        headers = MutableHeaders(scope=message)
        size, tag = headers.get("content-length"), headers.get("etag", "")
        in_parts = headers.get("accept-ranges") == "bytes" and tag.startswith('"')
        if message["status"] != 200 or not in_parts or size is None:
            return
        if self._only_of is not None and self._only_of != tag:
            return  # another file than the one that the caller has a part of
        self._span = span = Span.of(self._wanted, int(size))
        if span is None:
            self._over = True
            return
        message["status"] = 206
        headers["content-range"] = f"bytes {span.first}-{span.last}/{span.size}"
        headers["content-length"] = str(span.last - span.first + 1)
