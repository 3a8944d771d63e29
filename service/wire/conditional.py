"""Conditional and range requests (RFC 9110, sections 13 and 14): ETags, and files in parts.

An ETag here is strong: one for each sequence of bytes, compressed or not. A response with a strong
ETag, a length and `Accept-Ranges: bytes` can be requested in parts, so that an interrupted download
is continued.
"""

from __future__ import annotations

import hashlib
import re

from fastapi import Request, Response
from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.wire.errors import ProblemType
from service.wire.problem import error_response
from synthesis.design.identity import ENGINE_NUMBER

IN_PARTS = {"Accept-Ranges": "bytes"}
RANGE = re.compile(r"bytes=(\d{0,18})-(\d{0,18})")
TAG = re.compile(r'(?:W/)?"([^"]*)"')
ENCODED = re.compile(r"-gzip$")


def tag_of(*parts: str) -> str:
    """A tag for what this engine makes from these parts alone."""
    text = str(ENGINE_NUMBER) + "".join(f"{part}\0" for part in parts)
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def not_modified(request: Request, tag: str) -> Response | None:
    """304 where the caller has these bytes already, otherwise None."""
    wanted = request.headers.get("if-none-match")
    if wanted is None:
        return None
    for known in TAG.findall(wanted):
        if ENCODED.sub("", known) == tag:
            return Response(status_code=304, headers={"ETag": f'"{known}"'})
    return Response(status_code=304, headers={"ETag": f'"{tag}"'}) if wanted == "*" else None


class TagEncodings:
    """Middleware around compression: compressed bytes have a tag of their own."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        async def tagged(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                encoding, tag = headers.get("content-encoding"), headers.get("etag")
                if encoding and tag:
                    headers["etag"] = f'{tag[:-1]}-{encoding}"'
            await send(message)

        await self._app(scope, receive, tagged)


class _HeadSent(Exception):
    """Passes through the application from ``send`` to ``Heads``: nothing more is wanted of it."""


class Heads:
    """Middleware that answers HEAD as GET, without a body.

    The application ends as soon as it has said how its answer begins: a stream is not begun.
    Handlers that would work for long look at ``only_head`` and answer sooner.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope.get("method") != "HEAD":
            await self._app(scope, receive, send)
            return

        async def send_head(message: Message) -> None:
            await send(message)
            await send({"type": "http.response.body"})
            raise _HeadSent

        asked = {**scope, "method": "GET", "only_head": True}
        try:
            await self._app(asked, receive, send_head)
        except* _HeadSent:  # in a group, where a stream has tasks of its own
            pass


def only_head(request: Request) -> bool:
    """Whether only the head of the answer is wanted."""
    return bool(request.scope.get("only_head"))


class _BeyondEnd(Exception):
    """Passes through the application from ``send`` to ``Ranges``; holds the size of the file."""


class Ranges:
    """Middleware around all that changes bytes: parts are of the uncompressed file."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        headers = Headers(scope=scope) if scope["type"] == "http" else Headers()
        wanted = RANGE.fullmatch(headers.get("range", ""))
        if scope.get("method") != "GET" or wanted is None:
            await self._app(scope, receive, send)
            return
        plain = [(name, value) for name, value in scope["headers"] if name != b"accept-encoding"]
        span: tuple[int, int] | None = None  # first and last byte to send; None: send everything
        at = 0

        async def send_part(message: Message) -> None:
            nonlocal span, at
            if message["type"] == "http.response.start":
                answer = MutableHeaders(scope=message)
                size, tag = answer.get("content-length"), answer.get("etag", "")
                has_parts = answer.get("accept-ranges") == "bytes" and tag.startswith('"')
                # Where the file has changed since the caller got a part, all of it is sent.
                unchanged = headers.get("if-range", tag) == tag
                if message["status"] == 200 and has_parts and unchanged and size is not None:
                    span = _span(wanted[1], wanted[2], int(size))
                    answer["content-range"] = f"bytes {span[0]}-{span[1]}/{size}"
                    answer["content-length"] = str(span[1] - span[0] + 1)
                    message["status"] = 206
            elif span is not None:
                body = message.get("body", b"")
                start, end = span[0] - at, span[1] + 1 - at
                at += len(body)
                message = {**message, "body": body[max(0, start) : max(0, end)]}
            await send(message)

        try:
            await self._app({**scope, "headers": plain}, receive, send_part)
        except _BeyondEnd as error:
            detail = f"Range: {wanted[0]} of a file of {error} bytes. Leave Range out for all."
            problem = ProblemType.NO_SUCH_BYTES(detail, {"Content-Range": f"bytes */{error}"})
            await error_response(Request(scope), problem)(scope, receive, send)


def _span(first: str, last: str, size: int) -> tuple[int, int]:
    """First and last byte of a range of a file of ``size`` bytes; without a first, at its end."""
    if first:
        span = int(first), min(int(last), size - 1) if last else size - 1
    else:
        span = max(0, size - int(last or 0)), size - 1
    if span[0] > span[1]:
        raise _BeyondEnd(size)
    return span
