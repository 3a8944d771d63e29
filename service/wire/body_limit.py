"""Refuse bodies that are too large: by their declared length, or as soon as they exceed it."""

from __future__ import annotations

from fastapi import Request
from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.wire.errors import ProblemType
from service.wire.problem import error_response

READ_ON = 32  # times the limit: so much of a refused body is read, so that clients see the answer


class BodyLimit:
    """Middleware that counts the bytes of a body."""

    def __init__(self, app: ASGIApp, max_bytes: int) -> None:
        self._app, self._max_bytes = app, max_bytes

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        declared = Headers(scope=scope).get("content-length", "")
        if declared.isdecimal() and int(declared) > self._max_bytes:
            await self._refuse(scope, receive, send)
            return
        seen = 0

        async def counted() -> Message:
            nonlocal seen
            message = await receive()
            seen += len(message.get("body", b""))
            if seen > self._max_bytes:
                raise _TooLarge
            return message

        try:
            await self._app(scope, counted, send)
        except _TooLarge:
            await self._refuse(scope, receive, send)

    async def _refuse(self, scope: Scope, receive: Receive, send: Send) -> None:
        left, more = READ_ON * self._max_bytes, True
        while more and left > 0:
            message = await receive()
            left -= len(message.get("body", b""))
            more = message.get("more_body", False)
        error = ProblemType.BODY_TOO_LARGE(
            f"The body is larger than {self._max_bytes} bytes, the limit of this server. "
            "A design with 100 segments needs less than 50 kB."
        )
        await error_response(Request(scope), error)(scope, receive, send)


class _TooLarge(Exception):
    """Passes through the application from ``receive`` to ``BodyLimit``."""
