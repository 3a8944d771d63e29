"""Connections: how many there may be, how large a head of a request is, how long one may take.

Uvicorn has no such limits where httptools parses. A connection that breaks one is answered with a
problem document, if it waits for an answer, and closed. Peers that have gone, or do not read what
is sent, are noticed by the kernel: see ``listening_socket`` in `service.settings`.

The application begins with a request when it is there, so that one that is cut off before costs a
tenth of one that is answered.
"""

from __future__ import annotations

import asyncio
import json
from typing import Any

from uvicorn.protocols.http.flow_control import HIGH_WATER_LIMIT
from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

from service.settings import Settings
from service.wire.errors import ProblemType, ServiceError
from service.wire.observe import SECURITY
from service.wire.places import Places
from service.wire.problem import MEDIA_TYPE, problem_of

MOST_PIPELINED = 16  # requests sent before the first of them was answered: browsers send none so
# Bytes of a body that are skipped after its request was answered, so that clients see the answer.
MOST_SKIPPED = 1_048_576


class Connection(HttpToolsProtocol):
    """A connection within limits."""

    def __init__(self, *arguments: Any, settings: Settings, places: Places, **named: Any) -> None:
        super().__init__(*arguments, **named)
        self._settings, self._places = settings, places
        self._holder: str | None = None  # address that holds a place for this connection
        self._wrong: ServiceError | None = None  # what the parser is stopped for
        self._deadline: asyncio.TimerHandle | None = None  # of the request that is being received
        self._in_head, self._head_bytes, self._skipped = True, 0, 0
        self._arriving: Any = None  # the request whose body is awaited, and what it is for

    def connection_made(self, transport: Any) -> None:
        super().connection_made(transport)
        address = self.client[0] if self.client else ""
        try:
            self._places.take(address)
        except ServiceError as refusal:
            self._refuse(refusal)
            return
        self._holder = address
        self._expect_request()

    def connection_lost(self, exc: Exception | None) -> None:
        if self._holder is not None:
            self._places.leave(self._holder)
        self._received()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        if self.transport.is_closing():
            return
        self._expect_request()
        super().data_received(data)
        # A head that has not ended: uvicorn is told of none of its parts before they are complete.
        if self._in_head and not self.transport.is_closing():
            self._head_bytes += len(data)
            if self._head_bytes > self._settings.max_head_bytes:
                self._refuse(self._head_too_large())

    def on_message_begin(self) -> None:
        super().on_message_begin()
        self._in_head, self._head_bytes, self._skipped = True, 0, 0
        self._expect_request()
        if len(self.pipeline) >= MOST_PIPELINED:
            self._stop(
                ProblemType.NOT_HTTP(
                    f"More than {MOST_PIPELINED} requests were sent before an answer was read. "
                    "Wait for answers."
                )
            )

    def on_headers_complete(self) -> None:
        self._in_head = False
        head = len(self.url) + sum(len(name) + len(value) for name, value in self.headers)
        if head > self._settings.max_head_bytes:
            self._stop(self._head_too_large())
        super().on_headers_complete()

    def on_body(self, body: bytes) -> None:
        if self.cycle.response_complete:
            self._skipped += len(body)
            if self._skipped > MOST_SKIPPED:
                self.transport.close()
        super().on_body(body)
        self._begin()

    def on_message_complete(self) -> None:
        self._received()
        super().on_message_complete()
        self._begin()

    def _start_asgi_task(self, cycle: Any, app: Any) -> None:
        self._arriving = cycle, app
        self._begin()

    def _begin(self) -> None:
        """Begin with the request that is arriving, when no more of it is received by itself.

        It is complete, or as long as is received before somebody reads it, or its client waits to
        be told to go on.
        """
        if self._arriving is None:
            return
        cycle, app = self._arriving
        waits = cycle.waiting_for_100_continue or len(cycle.body) > HIGH_WATER_LIMIT
        if waits or not cycle.more_body:
            self._arriving = None
            super()._start_asgi_task(cycle, app)

    def send_400_response(self, msg: str) -> None:
        self._refuse(
            self._wrong
            or ProblemType.NOT_HTTP("What was sent is no request of HTTP/1.1. Correct the client.")
        )

    def _head_too_large(self) -> ServiceError:
        most = self._settings.max_head_bytes
        return ProblemType.HEAD_TOO_LARGE(
            f"Path, query and headers have more than {most} bytes, the limit of this server. "
            "Shorten them: a spec belongs into the body."
        )

    def _stop(self, error: ServiceError) -> None:
        """End the parser in the middle of what it parses; uvicorn then answers with an error."""
        self._wrong = error
        raise error

    def _expect_request(self) -> None:
        """Start the time that a request has to arrive in, unless it runs already."""
        if self._deadline is None:
            within_s = self._settings.request_timeout_s
            self._deadline = self.loop.call_later(within_s, self._too_slow)

    def _received(self) -> None:
        """A whole request is there."""
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None

    def _too_slow(self) -> None:
        self._deadline = None
        if self.pipeline:  # it is this server that does not read on, while others are answered
            self._expect_request()
            return
        within_s = self._settings.request_timeout_s
        self._refuse(
            ProblemType.REQUEST_TIMEOUT(
                f"The request did not arrive within {within_s:g} s, the limit of this server. "
                "Send it at once, or over a faster line."
            )
        )

    def _refuse(self, error: ServiceError) -> None:
        """Answer with a problem document, unless an answer is under way, and close."""
        cycle: Any = self.cycle  # None before the first request
        if cycle is None or not cycle.response_started or cycle.response_complete:
            scope: Any = self.scope or {}  # None before the first request
            problem = problem_of(error) | {"instance": scope.get("path", "/")}
            body = json.dumps(problem, ensure_ascii=False).encode("utf-8", "replace")
            headers = {
                "Content-Type": MEDIA_TYPE, "Content-Length": str(len(body)),
                "Connection": "close", **SECURITY, **error.headers,
            }  # fmt: skip
            status = f"HTTP/1.1 {error.problem.status} {error.problem.title}"
            head = "\r\n".join([status, *(f"{name}: {value}" for name, value in headers.items())])
            self.transport.write(f"{head}\r\n\r\n".encode() + body)
        if cycle is not None:  # whoever waits for the rest of a body waits no longer
            cycle.disconnected = True
            cycle.message_event.set()
        self.transport.close()
