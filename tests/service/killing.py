"""The service as a process of its own, to be killed without warning."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import httpx2

from benchmarks import processes

ROOT = Path(__file__).resolve().parents[2]
SERVE = """
if __name__ == "__main__":
    import gc
    gc.disable()  # while modules are imported, of which nothing is let go
    from service.workers import prefork
    prefork.start_fork_server()
    from service.app import create_app
    from service.wire.logs import configure_logs
    from service.settings import Settings, listening_socket
    from service.server import server_config
    from tests.service import fake_core
    import uvicorn
    gc.freeze()
    gc.enable()
    configure_logs("error")
    settings = Settings()
    server = uvicorn.Server(server_config(create_app(settings, fake_core.engine), settings))
    server.run([listening_socket(settings)])
"""


def free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        port: int = found.getsockname()[1]
        return port


class Process:
    """One process that can be killed and started again, with the same arguments."""

    def __init__(self, *arguments: str, **environment: str) -> None:
        self._command = [sys.executable, *arguments]
        path = f"{ROOT}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"
        self._environment = {**os.environ, "PYTHONPATH": path, **environment}
        self.start()

    def start(self) -> None:
        self.running = subprocess.Popen(
            self._command, env=self._environment, cwd=ROOT, start_new_session=True
        )

    def kill(self) -> None:
        """As kill -9 does: no goodbye."""
        self.running.send_signal(signal.SIGKILL)
        self.running.wait()

    def stop(self) -> None:
        self.running.terminate()
        try:
            self.running.wait(15.0)
        except subprocess.TimeoutExpired:
            self.kill()


def service(folder: Path, port: int, *, real: bool = False, **more: str) -> Process:
    """The service with the fake core, or the real one, on its own workers."""
    script = folder / "serve.py"
    script.write_text(SERVE, encoding="utf-8")
    environment = {
        "CAMWRIGHT_PORT": str(port),
        "CAMWRIGHT_DATABASE_URL": f"sqlite:///{folder}/designs.db",
        "CAMWRIGHT_WORKERS": "2",
        "CAMWRIGHT_LEASE_S": "1.5",
        **more,
    }
    return Process(*(("-m", "service") if real else (str(script),)), **environment)


def answering(client: httpx2.Client) -> None:
    """Until the service is there."""
    for _ in range(3000):
        try:
            if client.get("/livez").status_code == 200:
                return
        except httpx2.TransportError:
            pass
        time.sleep(0.1)
    raise AssertionError("the service did not come")


def children(process: int) -> list[int]:
    """Processes of its workers."""
    return processes.workers(processes.family(process))
