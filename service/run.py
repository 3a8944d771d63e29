"""Start the service, let it synthesise one cam as a self-check, and print the addresses."""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import socket
import sys
import time
from typing import Any

import uvicorn
from fastapi import FastAPI
from sqlalchemy.exc import SQLAlchemyError

from service.app import create_app
from service.contract.examples import SELF_CHECK, examples
from service.settings import Settings
from service.state import State
from service.storage.store import Store
from service.wire.observe import configure_logs
from synthesis.spec import DesignSpec

ENDS_S = 3  # that answers under way get to end in when the service is told to stop


def serve(settings: Settings, listening: socket.socket) -> None:
    """Run until told to stop; ends the process with one sentence where that cannot be."""
    configure_logs(settings.log_level)
    _usable(settings)
    app = create_app(settings)
    config = web(app)
    logging.getLogger("uvicorn").setLevel(logging.WARNING)
    sys.stdout.write("Camwright is starting its workers ...\n")
    sys.stdout.flush()
    port = listening.getsockname()[1]
    with contextlib.suppress(KeyboardInterrupt):  # it has shut down in order by then
        _Server(config, app, f"http://{_reachable(settings.host)}:{port}").run([listening])


def web(app: FastAPI) -> uvicorn.Config:
    """How the service is served; told to stop, it does not wait for whoever watches a sweep."""
    return uvicorn.Config(
        app,
        log_config=None,
        access_log=False,
        server_header=False,
        timeout_graceful_shutdown=ENDS_S,
    )


def _usable(settings: Settings) -> None:
    """Try the store; one sentence and exit 1 where it is not to be had."""
    try:
        Store(settings).dispose()
    except (SQLAlchemyError, OSError, ImportError) as error:
        reason = str(getattr(error, "orig", error)).partition("\n")[0]
        address = settings.database.render_as_string(hide_password=True)
        sys.exit(f"The database {address} cannot be used: {reason}. See CAMWRIGHT_DATABASE_URL.")


class _Server(uvicorn.Server):
    """Says what it can do once it listens."""

    def __init__(self, config: uvicorn.Config, app: FastAPI, address: str) -> None:
        super().__init__(config)
        self._app, self._address = app, address

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        if self.started:
            self._greeting = asyncio.create_task(self._greet())

    async def _greet(self) -> None:
        parts: State = self._app.state.parts
        lines = [await self_check(parts)]
        paths = {"start": "/", "try it": "/docs", "reference": "/redoc", "API": "/v1/designs"}
        lines += [f"{name:>10}  {self._address}{path}" for name, path in paths.items()]
        lines.append(f"{'designs in':>10}  {parts.settings.database.render_as_string()}")
        sys.stdout.write("\n".join(lines) + "\nStop with Ctrl-C.\n")
        sys.stdout.flush()


async def self_check(parts: State) -> str:
    """One line on the first worked example, synthesised now."""
    example = examples().get(SELF_CHECK)
    if example is None:
        return "Self-check left out: no worked examples are installed."
    spec = DesignSpec.model_validate(example["value"])
    started = time.perf_counter()
    try:
        answer = await parts.engine.solve(spec.model_dump_json().encode(), 30.0)
    except Exception as error:  # whatever it is, the service itself has started
        return f"Self-check FAILED: {error}"
    return _in_words(json.loads(answer.design), answer.seconds, time.perf_counter() - started)


def _in_words(design: dict[str, Any], core_s: float, whole_s: float) -> str:
    proven, sizes = design["certificate"], design["dimensions"]
    gap = "?" if proven["gap"] is None else f"{100.0 * proven['gap']:.2f} %"
    return (
        f"Self-check, {design['name']}: base radius {sizes['base_radius_mm']:.3f} mm, "
        f"offset {sizes['offset_mm']:.3f} mm, gap {gap}, "
        f"{'certified' if proven['certified'] else 'NOT CERTIFIED'}, "
        f"{1e3 * core_s:.0f} ms in the core, {1e3 * whole_s:.0f} ms with the way there."
    )


def _reachable(host: str) -> str:
    """The host as a browser on this machine can use it."""
    return {"0.0.0.0": "127.0.0.1", "::": "[::1]"}.get(host, f"[{host}]" if ":" in host else host)
