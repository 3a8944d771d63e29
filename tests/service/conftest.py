"""One service for all tests: a real server on a loopback port, with a fake core behind it."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Coroutine, Iterator
from pathlib import Path
from typing import Any

import httpx2
import pytest
import uvicorn

from service.app import create_app
from service.server import server_config
from service.settings import Settings, listening_socket
from service.wire.logs import configure_logs
from service.workers.engine import running_engine
from tests.service import fake_core


class Running:
    """A service that listens."""

    def __init__(self, settings: Settings, real: bool, *, keys_needed: bool = False) -> None:
        configure_logs("warning")
        engine = running_engine if real else fake_core.engine
        self.app = create_app(settings, engine, keys_needed=keys_needed)
        self._socket = listening_socket(settings)
        self.url = f"http://127.0.0.1:{self._socket.getsockname()[1]}"
        self.server = uvicorn.Server(server_config(self.app, settings))
        # The server ends a connection on which nothing is asked for a while: each has its own.
        anew = httpx2.Limits(max_keepalive_connections=0)
        self.client = httpx2.Client(base_url=self.url, timeout=180.0, limits=anew)
        self._thread = threading.Thread(target=self._run)

    def _run(self) -> None:
        asyncio.run(self._serve())

    async def _serve(self) -> None:
        self._loop = asyncio.get_running_loop()
        await self.server.serve([self._socket])

    def __enter__(self) -> Running:
        self._thread.start()
        while not self.server.started:
            assert self._thread.is_alive(), "the service did not start"
            self._thread.join(0.02)
        return self

    def new_key(self, owner: str, **more: Any) -> str:
        """The text of a new key of an owner; made in the service's loop, as its store is that's."""
        return str(self.run(self.app.state.parts.keys.create(f"of {owner}", owner, **more))[1])

    def run(self, work: Coroutine[Any, Any, Any]) -> Any:
        """What some work in the service's event loop comes to."""
        return asyncio.run_coroutine_threadsafe(work, self._loop).result()

    def __exit__(self, *_: object) -> None:
        self.client.close()
        self.server.should_exit = True
        self._thread.join(180.0)
        self._socket.close()
        assert not self._thread.is_alive(), "the service did not stop"


def settings_for(folder: Path, **given: object) -> Settings:
    fields = {"port": 0, "database_url": f"sqlite:///{folder}/designs.db", "workers": 2, **given}
    return Settings.model_validate(fields)


def wait_until(client: httpx2.Client, **numbers: int) -> None:
    """Until the metrics show these numbers: designs ``running``, ``waiting``, or ``workers``."""
    lines = [
        f"camwright_{name if name == 'workers' else f'designs_{name}'} {number}.0"
        for name, number in numbers.items()
    ]
    for _ in range(2400):
        page = client.get("/metrics").text.splitlines()
        if all(line in page for line in lines):
            return
        time.sleep(0.1)
    raise AssertionError(page)


def wait_until_idle(client: httpx2.Client) -> None:
    """Until nothing runs and the workers that other tests have killed are back."""
    wait_until(client, running=0, workers=2)


@pytest.fixture(scope="session")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    """The service with the fake core."""
    settings = settings_for(
        tmp_path_factory.mktemp("service"), grace_s=0.5, max_waiting=4, max_sweep_items=600
    )
    with Running(settings, real=False) as running:
        yield running


@pytest.fixture(scope="session")
def real_service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    """The service with the real core; a busy machine has time enough for every answer."""
    settings = settings_for(tmp_path_factory.mktemp("real"), time_budget_s=300.0)
    with Running(settings, real=True) as running:
        yield running


@pytest.fixture
def client(service: Running) -> httpx2.Client:
    return service.client
