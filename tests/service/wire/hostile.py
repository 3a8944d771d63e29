"""Measure how long others wait: hostile bodies and connections, while another process asks /livez.

    python -m tests.service.wire.hostile [part of a name] ...

It starts a service of its own on a free port and prints a line of a table for each: name, status
or failed questions of the other client, time until the answer [ms], longest wait of the other
client [ms], and longest processor time that one step of the event loop took [ms]. The last does not
depend on what else the machine does.
"""

from __future__ import annotations

import asyncio
import contextlib
import http.client
import json
import mmap
import multiprocessing
import os
import resource
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from multiprocessing.sharedctypes import Synchronized
from pathlib import Path
from typing import Any

from tests.service.wire.hostile_bodies import BODIES, SWEEPS, cam, swept

PAUSE_S = 0.005  # from one probe to the next
OTHER = ("127.0.0.2", 0)  # another address than that of the hostile ones
LATE_S = 20.0  # after that a probe has failed
HELD_S = 4.0  # for which hostile connections are held
BODY_S = 120.0  # most that an answer to a body is waited for
SERVE = "serve"  # the word by which this script starts the service
Probe = Callable[[int], None]


def serve_measured(place: str) -> None:
    """The service on asyncio's own loop, the processor time of whose longest step is written."""
    run: Any = asyncio.events.Handle._run
    with Path(place).open("r+b") as file:
        held = mmap.mmap(file.fileno(), 8)

    def measured(step: Any) -> None:
        started = time.thread_time()
        run(step)
        took = time.thread_time() - started
        main = threading.current_thread() is threading.main_thread()
        if main and took > struct.unpack("d", held[:8])[0]:
            held[:8] = struct.pack("d", took)

    asyncio.events.Handle._run = measured  # type: ignore[method-assign]
    sys.modules["uvloop"] = None  # type: ignore[assignment]
    from service.commands.serve import serve

    serve(None, None, None, None)


def free_port() -> int:
    """A port of the loopback that nothing listens on."""
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


def probe(port: int, since: Synchronized[float], worst: Synchronized[float],
          failed: Synchronized[int]) -> None:  # fmt: skip
    """Ask for /livez again and again, each time by a new connection."""
    while True:
        time.sleep(PAUSE_S)
        since.value = time.monotonic()
        try:
            with socket.create_connection(("127.0.0.1", port), LATE_S, OTHER) as line:
                line.sendall(b"GET /livez HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
                answer = line.recv(4096)
            failed.value += not answer.startswith(b"HTTP/1.1 200")
        except OSError:
            failed.value += 1
        worst.value = max(worst.value, time.monotonic() - since.value)
        since.value = 0.0


class Service:
    """A service on a free port, and the process that asks it for /livez."""

    def __init__(self, folder: str, **settings: str) -> None:
        self.port = free_port()
        environment = {
            **os.environ, "CAMWRIGHT_PORT": str(self.port), "CAMWRIGHT_LOG_LEVEL": "error",
            "CAMWRIGHT_DATABASE_URL": f"sqlite:///{folder}/designs.db",
            "CAMWRIGHT_TIME_BUDGET_S": "0.5", **settings,
        }  # fmt: skip
        log = open(f"{folder}/log", "wb")  # noqa: SIM115, PTH123
        Path(f"{folder}/held").write_bytes(bytes(8))
        with Path(f"{folder}/held").open("r+b") as file:
            self.held = mmap.mmap(file.fileno(), 8)
        command = [sys.executable, "-m", "tests.service.wire.hostile", SERVE, f"{folder}/held"]
        self.process = subprocess.Popen(command, env=environment, stdout=log, stderr=log)
        for _ in range(600):
            with contextlib.suppress(OSError):
                if self.ask("GET", "/readyz")[0] == 200:
                    break
            time.sleep(0.1)
        shared: Any = multiprocessing
        self.since, self.worst = shared.Value("d", 0.0), shared.Value("d", 0.0)
        self.failed = shared.Value("i", 0)
        self.prober = multiprocessing.Process(
            target=probe, args=(self.port, self.since, self.worst, self.failed), daemon=True
        )
        self.prober.start()

    def ask(self, method: str, path: str, body: str | bytes | None = None) -> tuple[int, bytes]:
        """Status and body of an answer."""
        line = http.client.HTTPConnection("127.0.0.1", self.port, timeout=BODY_S)
        sent = body.encode() if isinstance(body, str) else body
        try:
            line.request(method, path, sent, {"Content-Type": "application/json"})
            answer = line.getresponse()
            return answer.status, answer.read()
        finally:
            line.close()

    @contextlib.contextmanager
    def measured(self) -> Iterator[list[float]]:
        """The longest wait of the other client [ms], and how many of its questions failed."""
        self.worst.value, self.failed.value, self.held[:8] = 0.0, 0, bytes(8)
        found: list[float] = []
        yield found
        time.sleep(0.05)
        waiting = time.monotonic() - self.since.value if self.since.value else 0.0
        (held_s,) = struct.unpack("d", self.held[:8])
        found += [1e3 * max(self.worst.value, waiting), self.failed.value, 1e3 * held_s]

    def close(self) -> None:
        """Stop both processes."""
        self.prober.kill()
        self.process.terminate()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.process.wait(15.0)
        self.process.kill()


HEAD = b"Host: localhost\r\nContent-Type: application/json\r\n"
POST = b"POST /v1/designs HTTP/1.1\r\n" + HEAD


def lines(port: int, count: int, first: bytes = b"") -> list[socket.socket]:
    """Connections, as many as are let in, with the first bytes sent on each."""
    opened = []
    for _ in range(count):
        with contextlib.suppress(OSError):
            line = socket.create_connection(("127.0.0.1", port), 2.0)
            opened.append(line)
            line.sendall(first)
    return opened


def hold(opened: list[socket.socket], drip: bytes = b"") -> None:
    """Hold connections, sending a little on each twice a second; close them at the end."""
    end = time.monotonic() + HELD_S
    while time.monotonic() < end:
        for line in opened if drip else ():
            with contextlib.suppress(OSError):
                line.send(drip)
        time.sleep(0.5)
    for line in opened:
        line.close()


def flood(port: int, first: bytes, piece: bytes, most: int = 4000) -> None:
    """Send without reading what comes back, as much as is taken in the time."""
    end = time.monotonic() + HELD_S
    with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), 2.0) as line:
        line.settimeout(HELD_S)
        line.sendall(first)
        for _ in range(most):
            if time.monotonic() > end:
                break
            line.sendall(piece)
        time.sleep(max(0.0, end - time.monotonic()))


def resets(port: int) -> None:
    """Connections that are cut in the middle of a request."""
    end = time.monotonic() + HELD_S
    while time.monotonic() < end:
        for line in lines(port, 20, POST + b"Content-Length: 1000\r\n\r\n{"):
            line.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")
            line.close()


def watch(port: int) -> None:
    """Watch a sweep on many connections, and read nothing."""
    axes = [{"kind": "range", "pointer": "/limits/0/rise_deg", "start": 30, "stop": 40,
             "count": 4000}]  # fmt: skip
    line = http.client.HTTPConnection("127.0.0.1", port, timeout=BODY_S)
    body = json.dumps(swept(axes=axes, name=str(time.time()), base=cam()))
    line.request("POST", SWEEPS, body, {"Content-Type": "application/json"})
    path = json.loads(line.getresponse().read())["links"]["self"]
    hold(lines(port, 300, f"GET {path}/events HTTP/1.1\r\n".encode() + HEAD + b"\r\n"))
    line.close()  # the service has ended it, where it stood idle for long
    line.request("DELETE", path)
    line.getresponse().read()


GET = b"GET /livez HTTP/1.1\r\n" + HEAD
ODD = (
    b"GET /livez HTTP/1.0\r\n\r\n", b"GET /livez\r\n\r\n", b"GET  /livez HTTP/9.9\r\n\r\n",
    b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc" * 50,
    POST + b"Content-Length: 5\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n",
    POST + b"Content-Length: -1\r\n\r\n", POST + b"Content-Length: 5\r\nContent-Length: 6\r\n\r\n",
    GET + b"Connection: Upgrade\r\nUpgrade: websocket\r\n\r\n", GET + b" folded\r\n\r\n",
    b"GET /%00%ff%fe HTTP/1.1\r\n" + HEAD + b"\r\n", b"CONNECT a:1 HTTP/1.1\r\n" + HEAD + b"\r\n",
)  # fmt: skip
CONNECTIONS: dict[str, Probe] = {
    "3000 connections, nothing sent": lambda port: hold(lines(port, 3000)),
    "500 connections, slow headers": lambda port: hold(lines(port, 500, GET), b"X-A: b\r\n"),
    "500 connections, slow bodies": lambda port: hold(
        lines(port, 500, POST + b"Content-Length: 1000000\r\n\r\n"), b" "
    ),
    "3000 idle connections after an answer": lambda port: hold(lines(port, 3000, GET + b"\r\n")),
    "a header of 64 kB": lambda port: hold(
        lines(port, 50, GET + b"X-A: " + b"a" * 65_536 + b"\r\n\r\n")
    ),
    "a header without end": lambda port: flood(port, GET + b"X-A: ", b"a" * 65_536),
    "headers without end": lambda port: flood(port, GET, b"X-A: b\r\n" * 8000),
    "a path without end": lambda port: flood(port, b"GET /", b"a" * 65_536),
    "a chunked body without end": lambda port: flood(
        port, POST + b"Transfer-Encoding: chunked\r\n\r\n", b"10000\r\n" + b" " * 65_536 + b"\r\n"
    ),
    "chunks of one byte": lambda port: flood(
        port, POST + b"Transfer-Encoding: chunked\r\n\r\n", b"1\r\n \r\n" * 10_000
    ),
    "many requests at once": lambda port: flood(port, b"", (GET + b"\r\n") * 2000),
    "short requests at once": lambda port: flood(port, b"", b"GET /livez HTTP/1.1\r\n\r\n" * 8000),
    "answers that are not read": lambda port: hold(
        lines(port, 100, (b"GET /openapi.json HTTP/1.1\r\n" + HEAD + b"\r\n") * 20)
    ),
    "a body that was promised": lambda port: hold(
        lines(port, 300, POST + b"Content-Length: 9\r\nExpect: 100-continue\r\n\r\n")
    ),
    "oddities": lambda port: hold([line for odd in ODD * 20 for line in lines(port, 1, odd)]),
    "cut in the middle": resets,
    "300 watchers who read nothing": watch,
}


def report(name: str, answer: str, took: str, found: list[float]) -> None:
    """A line of the table."""
    wait, _, held = found
    sys.stdout.write(f"| {name} | {answer} | {took} | {wait:.0f} | {held:.0f} |\n")
    sys.stdout.flush()


def main() -> None:
    """Measure all, or those whose names hold one of the words given."""
    most = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    usual = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    words = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        service = Service(folder)
        resource.setrlimit(resource.RLIMIT_NOFILE, (max(usual, min(most, 8192)), most))
        try:
            for name, (path, make) in BODIES.items():
                if words and not any(word in name for word in words):
                    continue
                body = make()
                with service.measured() as found:
                    started, status = time.monotonic(), "none"
                    with contextlib.suppress(OSError):
                        number, answer = service.ask("POST", path, body)
                        said = json.loads(answer).get("type", "") if number >= 400 else ""
                        status = f"{number} {said.rpartition('/')[2]}".strip()
                    took = f"{1e3 * (time.monotonic() - started):.0f}"
                report(name, status, took, found)
            for name, attack in CONNECTIONS.items():
                if words and not any(word in name for word in words):
                    continue
                with service.measured() as found:
                    attack(service.port)
                report(name, f"{found[1]} failed", "", found)
                time.sleep(1.0)
        finally:
            service.close()


if __name__ == "__main__":
    if sys.argv[1:2] == [SERVE]:
        serve_measured(sys.argv[2])
    else:
        main()
