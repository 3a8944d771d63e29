"""A scheduler elsewhere: who has not the certificate of the cluster runs nothing there."""

from __future__ import annotations

import asyncio
import os
import socket
import ssl
from pathlib import Path
from typing import Any

import pytest
from distributed import Client, KilledWorker, Security

from service.settings import Settings
from service.wire.errors import ServiceError
from service.workers.remote import RemoteWorkers
from service.workers.scheduler import make_certificate
from tests.service.fake_core import prepare
from tests.service.killing import Process, free_port

ALERT = b"\x15"  # what a record of TLS begins with that ends a connection


@pytest.mark.parametrize("address", ["tcp://10.0.0.5:8786", "10.0.0.5:8786"])
def test_a_scheduler_without_encryption_is_refused(address: str) -> None:
    with pytest.raises(ValueError, match="must ask for certificates"):
        Settings(scheduler=address)


def cluster_of(file: Path) -> dict[str, str]:
    """Dask's settings, as docker-compose.yml has them."""
    roles = ("CLIENT", "SCHEDULER", "WORKER")
    prefix = "DASK_DISTRIBUTED__COMM__TLS__"
    return {f"{prefix}{role}__CERT": str(file) for role in roles} | {f"{prefix}CA_FILE": str(file)}


def test_a_stranger_runs_nothing_on_the_scheduler(tmp_path: Path) -> None:
    port, own, strange = free_port(), tmp_path / "own.pem", tmp_path / "strange.pem"
    make_certificate(strange)
    scheduler = Process(
        "-m", "service.workers.scheduler", "--host=127.0.0.1", f"--port={port}", "--no-dashboard",
        "--dashboard-address=127.0.0.1:0", **cluster_of(own),
    )  # fmt: skip
    try:
        connect: Any = Client

        async def identity(file: Path) -> Any:
            security = Security(
                tls_ca_file=str(file), tls_client_cert=str(file), require_encryption=True
            )
            address = f"tls://127.0.0.1:{port}"
            async with connect(address, asynchronous=True, security=security) as client:
                return await client.scheduler.identity()

        reachable(port)
        assert own.stat().st_mode & 0o077 == 0
        assert asyncio.run(identity(own))["type"] == "Scheduler"
        kept = own.read_bytes()
        make_certificate(own)
        assert own.read_bytes() == kept
        assert answer_to(port, None)[:1] in (b"", ALERT)  # without TLS
        for certificate in ("", str(strange)):
            context = ssl.create_default_context(cafile=str(own))
            context.check_hostname = False
            if certificate:
                context.load_cert_chain(certificate)
            assert answer_to(port, context) == b""
    finally:
        scheduler.stop()


def reachable(port: int) -> None:
    """Until it listens."""
    for _ in range(1200):
        try:
            socket.create_connection(("127.0.0.1", port)).close()
        except ConnectionRefusedError:
            os.sched_yield()
            asyncio.run(asyncio.sleep(0.1))
        else:
            return
    raise AssertionError("the scheduler did not come")


def answer_to(port: int, context: ssl.SSLContext | None) -> bytes:
    """What a caller gets who says hello; nothing where the connection is ended."""
    with socket.create_connection(("127.0.0.1", port), 30.0) as plain:
        try:
            with plain if context is None else context.wrap_socket(plain) as connection:
                connection.sendall(b"\0" * 64)
                return connection.recv(100)
        except OSError:
            return b""


class Future:
    """A task of a made-up client: it ends as it is told to."""

    def __init__(self, key: str) -> None:
        self.key, self.ended = key, asyncio.get_running_loop().create_future()

    async def result(self) -> Any:
        return await self.ended

    def release(self) -> None:
        """Nothing is kept."""


class MadeUp:
    """A client of a scheduler whose single worker has all tasks."""

    status = "running"

    def __init__(self) -> None:
        self.sent: list[Future] = []
        self.scheduler = self

    async def identity(self, n_workers: int) -> dict[str, int]:
        return {"n_workers": 1}

    def submit(self, *_: Any, key: str, pure: bool) -> Future:
        self.sent.append(Future(key))
        return self.sent[-1]

    async def processing(self) -> dict[str, list[str]]:
        return {"worker": [future.key for future in self.sent]}

    async def restart_workers(self, workers: list[str], **_: Any) -> None:
        assert workers == ["worker"]
        for future in list(self.sent):
            future.ended.set_exception(KilledWorker(future.key, "worker", 0))

    async def cancel(self, *_: Any, **__: Any) -> None:
        """All have ended."""

    async def wait_for_workers(self, *_: Any, **__: Any) -> None:
        """It is there."""


def test_what_a_restarted_worker_had_besides_is_done_again() -> None:
    async def story() -> None:
        workers, client = RemoteWorkers("tls://nowhere", 2, prepare), MadeUp()
        workers._client = client
        overrun, other = (asyncio.ensure_future(workers.run(key, len, "x")) for key in "ab")
        await asyncio.sleep(0)
        await workers.stop("a")
        with pytest.raises(ServiceError, match="died"):
            await overrun
        while len(client.sent) < 3:  # noqa: ASYNC110 (of a client made up)
            await asyncio.sleep(0)
        client.sent[-1].ended.set_result(7)
        assert await other == 7

    asyncio.run(story())
