"""Strangers at every port of a scheduler and its worker: they run nothing.

    python -m tests.service.checks.cluster

It starts both as docker-compose.yml does, finds all ports on which their processes listen, and asks
each of them to run a command: by Dask's own protocol without TLS, with TLS and no certificate, and
with a certificate that a stranger has made; and with the messages of `web`. To see that such a call
would run, the one who has the cluster's certificate makes it too. The exit code is 1 where a
stranger ran anything, or the owner did not.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from distributed.core import rpc
from distributed.protocol.pickle import dumps
from distributed.security import Security

from benchmarks import processes
from service.workers.scheduler import make_certificate
from tests.service.checks.web import messages, said
from tests.service.killing import Process, free_port
from tests.service.workers.test_local import ports
from tests.service.workers.test_remote import cluster_of, reachable

LISTENING = 5  # of scheduler, nanny and worker, and two for health
HANDLERS = ("run", "run_function")  # of workers and nannies, and of the scheduler
HTTP = b"HTTP/1."


async def run(port: int, handler: str, file: Path, certificate: Path | None, tls: bool) -> None:
    """Ask a port to write a file, by Dask's protocol."""
    given = (
        {} if certificate is None else {"tls_ca_file": certificate, "tls_client_cert": certificate}
    )
    security = Security(require_encryption=tls, **{key: str(value) for key, value in given.items()})
    arguments: dict[str, Any] = security.get_connection_args("client")
    if tls and certificate is None:  # Dask itself refuses to speak TLS without one
        import ssl

        arguments["ssl_context"] = ssl._create_unverified_context()
    make: Any = rpc
    async with make(
        f"{'tls' if tls else 'tcp'}://127.0.0.1:{port}", connection_args=arguments
    ) as it:
        call = getattr(it, handler)
        await asyncio.wait_for(
            call(function=dumps(os.system), args=dumps((f"touch {file}",)), kwargs=dumps({})), 5.0
        )


def main() -> int:
    """0 where the owner alone runs something."""
    with contextlib.ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        own, strange, scheduler = folder / "own.pem", folder / "strange.pem", free_port()
        make_certificate(strange)
        health = "--dashboard-address=127.0.0.1:0"
        started = [Process("-m", "service.workers.scheduler", "--host=127.0.0.1", health,
                           f"--port={scheduler}", "--no-dashboard", **cluster_of(own))]  # fmt: skip
        stack.callback(started[0].stop)
        reachable(scheduler)
        started.append(Process("-m", "dask", "worker", f"tls://127.0.0.1:{scheduler}", health,
                               "--nworkers=1", "--nthreads=1", "--no-dashboard",
                               f"--local-directory={folder}", **cluster_of(own)))  # fmt: skip
        stack.callback(started[1].stop)
        listening, until = set[int](), time.monotonic() + 120.0
        while len(listening) < LISTENING and time.monotonic() < until:
            time.sleep(0.5)
            listening = {port for each in started
                         for port in ports(processes.family(each.running.pid))}  # fmt: skip
        ran, file, wrong, answers = folder / "ran", folder / "owner", 0, 0
        for port in sorted(listening):
            http = said(port, b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n").startswith(HTTP)
            for name, message in messages(ran).items():
                answer = said(port, message)
                wrong += bool(answer) and not answer.startswith((HTTP, b"\x15"))
                answers += 1
                if ran.exists():
                    print(f"{port}: a stranger ran something by {name}")
                    wrong += 1
            for handler in HANDLERS:
                for certificate, tls in ((None, False), (None, True), (strange, True)):
                    with contextlib.suppress(Exception):
                        asyncio.run(run(port, handler, ran, certificate, tls))
                    answers += 1
                    if ran.exists():
                        print(f"{port}: a stranger ran {handler}, TLS {tls}, {certificate}")
                        wrong += 1
                if not http:
                    with contextlib.suppress(Exception):
                        asyncio.run(run(port, handler, file, own, True))
            print(f"{port}: {'HTTP, for health' if http else 'TLS'}, "
                  f"its owner ran {'something' if file.exists() else 'nothing'}")  # fmt: skip
            wrong += not http and not file.exists()
            file.unlink(missing_ok=True)
        print(f"{len(listening)} ports, {answers} calls of strangers, {wrong} wrong")
    return min(wrong, 1)


if __name__ == "__main__":
    sys.exit(main())
