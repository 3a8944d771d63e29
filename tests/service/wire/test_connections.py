"""What a connection may do: each limit is broken once, on a server of its own without a core."""

from __future__ import annotations

import asyncio
import json
import socket
import threading
from collections.abc import Iterator
from typing import Any

import pytest
import uvicorn
from starlette.applications import Starlette
from starlette.requests import ClientDisconnect, Request
from starlette.responses import PlainTextResponse, Response, StreamingResponse
from starlette.routing import Route

from service.server import server_config
from service.settings import Settings, listening_socket
from service.wire.errors import ProblemType, ServiceError
from service.wire.places import Places

HEAD = b"Host: a\r\n"
GET = b"GET / HTTP/1.1\r\n" + HEAD
LIMITS: dict[str, Any] = {
    "port": 0, "max_connections": 8, "max_connections_per_client": 6, "max_head_bytes": 4096,
    "request_timeout_s": 0.3, "keep_alive_s": 1, "unread_s": 1,
}  # fmt: skip


class Server:
    """A server within limits; ``begun`` counts what it has begun to answer, and ``ended`` is set
    when it notices that a caller has gone.
    """

    def __init__(self) -> None:
        self.ended, self.begun = threading.Event(), 0

        async def answer(request: Request) -> Response:
            self.begun += 1
            try:
                return PlainTextResponse(f"{len(await request.body())} bytes")
            except ClientDisconnect:
                self.ended.set()
                raise

        async def flood(request: Request) -> Response:
            async def endless() -> Any:
                try:
                    while True:
                        yield b"x" * 65_536
                        await asyncio.sleep(0)
                finally:
                    self.ended.set()

            return StreamingResponse(endless())

        routes = [Route("/", answer, methods=["GET", "POST"]), Route("/flood", flood)]
        settings = Settings.model_validate(LIMITS)
        self.listener = listening_socket(settings)
        config = server_config(Starlette(routes=routes), settings)  # type: ignore[arg-type]
        config.lifespan = "off"
        self.server = uvicorn.Server(config)
        self.thread = threading.Thread(
            target=lambda: asyncio.run(self.server.serve([self.listener]))
        )

    def connect(self, sent: bytes = b"") -> socket.socket:
        line = socket.create_connection(self.listener.getsockname(), 5.0)
        line.sendall(sent)
        return line

    def exchange(self, sent: bytes) -> bytes:
        """All that comes back until the server closes."""
        with self.connect(sent) as line:
            return everything(line)


def everything(line: socket.socket) -> bytes:
    found = b""
    try:
        while piece := line.recv(65_536):
            found += piece
    except ConnectionResetError:
        pass
    return found


def problem(answer: bytes) -> tuple[int, str]:
    """Status and type of a problem document."""
    head, _, body = answer.partition(b"\r\n\r\n")
    assert b"application/problem+json" in head
    document = json.loads(body)
    assert document["detail"].endswith(".")
    assert int(head.split()[1]) == document["status"]
    return document["status"], document["type"]


@pytest.fixture(scope="module")
def server() -> Iterator[Server]:
    running = Server()
    running.thread.start()
    while not running.server.started:
        running.thread.join(0.01)
    yield running
    running.server.should_exit = True
    running.thread.join(10.0)
    running.listener.close()


def test_a_request_is_answered(server: Server) -> None:
    for version in (b"1.0", b"1.1"):
        sent = b"POST / HTTP/" + version + b"\r\nConnection: close\r\nContent-Length: 3\r\n\r\nabc"
        assert server.exchange(sent).endswith(b"3 bytes")


# As much of a body as is received before somebody reads it, and more than that.
SHORT = b"POST / HTTP/1.1\r\nContent-Length: 9\r\n\r\nab"
LONG = b"POST / HTTP/1.1\r\nContent-Length: 90000\r\n\r\n" + b"a" * 80_000


@pytest.mark.parametrize("sent", [b"", b"\r\n", GET, SHORT, LONG])
def test_a_request_that_does_not_arrive_is_ended(server: Server, sent: bytes) -> None:
    server.ended.clear()
    begun = server.begun
    assert problem(server.exchange(sent)) == (408, "/problems/request-timeout")
    if sent is LONG:  # whoever waited for the rest waits no longer
        assert server.ended.wait(5.0)
    else:
        assert server.begun == begun


def test_one_who_waits_to_be_told_to_go_on_is(server: Server) -> None:
    with server.connect(SHORT[:-4] + b"Connection: close\r\nExpect: 100-continue\r\n\r\n") as line:
        assert line.recv(1000).startswith(b"HTTP/1.1 100 ")
        line.sendall(b"a" * 9)
        assert everything(line).endswith(b"9 bytes")


def test_blank_lines_keep_no_connection_open(server: Server) -> None:
    """Uvicorn ends its own time at each of them."""
    with server.connect(GET + b"\r\n") as line:
        while not line.recv(4096).endswith(b"0 bytes"):
            pass
        line.sendall(b"\r\n")
        assert problem(everything(line))[0] == 408


def test_a_connection_without_a_request_is_closed(server: Server) -> None:
    assert server.exchange(GET + b"\r\n").endswith(b"0 bytes")


@pytest.mark.parametrize(
    "sent",
    [
        GET + b"X: " + b"a" * 5000 + b"\r\n\r\n",  # complete, in one piece
        GET + b"X: " + b"a" * 5000,  # without an end
        GET + b"X: b\r\n" * 1000,
        b"GET /" + b"a" * 5000,
        b"GET /" + b"a" * 5000 + b" HTTP/1.1\r\n\r\n",
    ],
)
def test_a_large_head_is_refused(server: Server, sent: bytes) -> None:
    assert problem(server.exchange(sent)) == (431, "/problems/head-too-large")


def test_a_body_is_no_part_of_the_head(server: Server) -> None:
    sent = b"POST / HTTP/1.1\r\nConnection: close\r\nContent-Length: 9000\r\n\r\n" + b"a" * 9000
    assert server.exchange(sent).endswith(b"9000 bytes")


@pytest.mark.parametrize("sent", [b"\x16\x03\x01\x02\x00", b"GET  / HTTP/9.9\r\n\r\n"])
def test_what_is_no_http_is_said_to_be(server: Server, sent: bytes) -> None:
    answer = server.exchange(sent)
    assert problem(answer) == (400, "/problems/not-http")
    assert b"X-Content-Type-Options: nosniff\r\n" in answer  # it is a response like all others


def test_few_requests_may_wait_for_answers(server: Server) -> None:
    few = server.exchange((GET + b"\r\n") * 9 + GET + b"Connection: close\r\n\r\n")
    assert few.count(b"0 bytes") == 10
    many = server.exchange((GET + b"\r\n") * 1000)
    assert many.count(b"HTTP/1.1 200") < 1000
    assert b"Wait for answers" in many


def test_connections_of_a_client_are_counted(server: Server) -> None:
    held = [server.connect() for _ in range(6)]
    try:
        refused = server.exchange(b"")
        assert problem(refused) == (503, "/problems/too-many-connections")
        assert b"Retry-After: 5" in refused
        assert b"6 connections from 127.0.0.1" in refused
    finally:
        for line in held:
            line.close()
    assert server.exchange(GET + b"\r\n").startswith(b"HTTP/1.1 200")


def test_places_are_counted_in_all_and_by_address() -> None:
    places = Places("seats", ProblemType.BUSY, most=3, each=2)
    for address in "aab":
        places.take(address)
    with pytest.raises(ServiceError, match="3 seats are open"):
        places.take("c")
    places.leave("b")
    with pytest.raises(ServiceError, match="2 seats from a are open"):
        places.take("a")
    places.take("c")


def test_a_peer_that_reads_nothing_is_noticed(server: Server) -> None:
    """By the kernel: it ends the connection when nothing was read for ``unread_s``."""
    if not hasattr(socket, "TCP_USER_TIMEOUT"):
        pytest.skip("the kernel has no such limit")
    server.ended.clear()
    with server.connect(b"GET /flood HTTP/1.1\r\n" + HEAD + b"\r\n"):
        assert server.ended.wait(20.0)
