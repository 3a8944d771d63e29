"""Run the service: check the database, start the workers, synthesise a cam as a self-check."""

from __future__ import annotations

import asyncio
import contextlib
import gc
import json
import logging
import socket
import sys
import time
from functools import partial
from typing import Any

import uvicorn
from fastapi import FastAPI
from sqlalchemy.exc import SQLAlchemyError

from service.app import create_app
from service.contract.examples import SELF_CHECK, examples
from service.pages import contract
from service.settings import BACKLOG, Settings
from service.state import State
from service.storage.keys import ApiKeys, is_valid
from service.storage.migrations import ForeignDatabase
from service.storage.store import Store
from service.wire.access import audit
from service.wire.connection import Connection
from service.wire.errors import ProblemType
from service.wire.logs import configure_logs
from service.wire.places import Places
from synthesis.spec.design_spec import DesignSpec

OTHER_FILES = 256  # open besides connections: of the store, of workers, of libraries
AT_ONCE = 32  # connections that are accepted in one step of the event loop, in about 2 ms
SHUTDOWN_S = 3  # that requests under way have to end in at shutdown


def serve(settings: Settings, listener: socket.socket) -> None:
    """Run until Ctrl-C or a signal; one sentence and exit 1 where the database cannot be used."""
    configure_logs(settings.log_level)
    audit.setLevel(logging.INFO)  # who did what is told at any level
    app = create_app(settings, keys_needed=keys_needed(settings))
    allow_files(settings)
    config = server_config(app, settings)
    logging.getLogger("uvicorn").setLevel(logging.WARNING)
    sys.stdout.write("Camwright is starting its workers ...\n")
    sys.stdout.flush()
    # The host as a browser on this machine addresses it.
    host = f"[{settings.host}]" if ":" in settings.host else settings.host
    host = {"0.0.0.0": "127.0.0.1", "[::]": "[::1]"}.get(host, host)
    with contextlib.suppress(KeyboardInterrupt):  # it has shut down by then
        _Server(config, app, f"http://{host}:{listener.getsockname()[1]}").run([listener])


def server_config(app: FastAPI, settings: Settings) -> uvicorn.Config:
    """Settings of uvicorn; at shutdown it does not wait for those who watch a sweep."""
    most, each = settings.max_connections, settings.max_connections_per_client
    places = Places("connections", ProblemType.TOO_MANY_CONNECTIONS, most, each)
    connection: Any = partial(Connection, settings=settings, places=places)
    return uvicorn.Config(
        app,
        http=connection,
        ws="none",
        backlog=AT_ONCE,
        timeout_keep_alive=settings.keep_alive_s,
        log_config=None,
        access_log=False,
        server_header=False,
        timeout_graceful_shutdown=SHUTDOWN_S,
    )


def allow_files(settings: Settings) -> None:
    """Allow this process a file for every connection, and some for all else."""
    try:
        import resource
    except ImportError:  # Windows has no such limit
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = settings.max_connections + OTHER_FILES
    if soft != resource.RLIM_INFINITY and soft < wanted:
        most = wanted if hard == resource.RLIM_INFINITY else min(wanted, hard)
        resource.setrlimit(resource.RLIMIT_NOFILE, (most, hard))
        if most < wanted:
            sys.exit(
                f"CAMWRIGHT_MAX_CONNECTIONS is {settings.max_connections}, and this process may "
                f"open {hard} files: at most {max(0, hard - OTHER_FILES)} connections fit. Set "
                "it lower, or raise the limit (ulimit -Hn)."
            )


def open_database(settings: Settings) -> Store:
    """The store; one sentence and exit 1 where it cannot be used."""
    try:
        return Store(settings)
    except (SQLAlchemyError, OSError, ImportError, ForeignDatabase) as error:
        reason = str(getattr(error, "orig", error)).partition("\n")[0]
        address = settings.database.render_as_string(hide_password=True)
        sys.exit(f"The database {address} cannot be used: {reason}. See CAMWRIGHT_DATABASE_URL.")


def keys_needed(settings: Settings) -> bool:
    """Whether those without a key are refused: as the settings say; else where there are keys.

    One sentence and exit 1 where the database cannot be used, and where other machines reach the
    service, and neither a key nor a setting says who may use it.
    """
    store = open_database(settings)
    try:
        keys = asyncio.run(ApiKeys(store, settings).all())
    finally:
        store.dispose()
    if settings.access == "open-to-anyone":
        return False
    if settings.reaches_others and not any(map(is_valid, keys)):
        where = ", ".join((settings.host, *settings.allowed_hosts))
        sys.exit(
            f"Other machines may reach the service ({where}), and it has no valid key. Make one: "
            "camwright keys create NAME, with the same CAMWRIGHT_DATABASE_URL. Or say that it is "
            "to be open: with CAMWRIGHT_ACCESS=open-to-anyone whoever reaches it may read, delete "
            "and compute."
        )
    return settings.access == "keys" or settings.reaches_others or bool(keys)


class _Server(uvicorn.Server):
    """Prints its addresses once it listens; then makes the contract."""

    def __init__(self, config: uvicorn.Config, app: FastAPI, address: str) -> None:
        super().__init__(config)
        self._app, self._address = app, address

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        for listener in sockets or ():
            listener.listen(BACKLOG)  # its queue has become as short as what is accepted at once
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
        await contract(self._app)  # so that whoever now opens /docs need not wait for it
        # What is there by now stays: collections, which hold everybody up, need not go through it.
        gc.collect()
        gc.freeze()


async def self_check(parts: State) -> str:
    """One line on the first worked example, synthesised now."""
    example = examples().get(SELF_CHECK)
    if example is None:
        return "Self-check left out: no worked examples are installed."
    spec = DesignSpec.model_validate(example["value"])
    started = time.perf_counter()
    try:
        answer = await parts.engine.solve(spec.model_dump_json().encode(), 30.0)
    except Exception as error:  # the service itself has started
        return f"Self-check FAILED: {error}"
    design, whole_s = json.loads(answer.body), time.perf_counter() - started
    certificate, sizes = design["certificate"], design["dimensions"]
    gap = "?" if certificate["gap"] is None else f"{100.0 * certificate['gap']:.2f} %"
    return (
        f"Self-check, {design['name']}: base radius {sizes['base_radius_mm']:.3f} mm, "
        f"offset {sizes['offset_mm']:.3f} mm, gap {gap}, "
        f"{'certified' if certificate['certified'] else 'NOT CERTIFIED'}, "
        f"{1e3 * answer.seconds:.0f} ms in the core, {1e3 * whole_s:.0f} ms with transfer."
    )
