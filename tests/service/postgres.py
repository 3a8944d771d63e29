"""A real PostgreSQL on a loopback port, for as long as it is wanted."""

from __future__ import annotations

import os
import pwd
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.lazy import LazyModule
from tests.service.killing import free_port

psycopg = LazyModule("psycopg")

PASSWORD = "letters-and-digits"


def program(name: str) -> str:
    """From the path, or where Debian keeps the newest."""
    known = sorted(Path("/usr/lib/postgresql").glob(f"*/bin/{name}"))
    found = shutil.which(name) or (str(known[-1]) if known else None)
    assert found, f"PostgreSQL's {name} is not installed: apt install postgresql"
    return found


def _account() -> str | None:
    """PostgreSQL refuses to run as root: then as its own account."""
    if os.geteuid() != 0:
        return None
    names = {entry.pw_name for entry in pwd.getpwall()}
    return "postgres" if "postgres" in names else "nobody"


@contextmanager
def postgres(
    user: str, database: str, disk: Path | None = None, *, fsync: bool = False
) -> Iterator[int]:
    """Its port; the user has ``PASSWORD`` and owns the database.

    ``disk``: a folder for all that it keeps; ``fsync``: it waits for the disk.
    """
    folder = Path(tempfile.mkdtemp(prefix="postgres-", dir=disk))
    account, port = _account(), free_port()
    secret = folder / "secret"
    secret.write_text(PASSWORD, encoding="ascii")
    if account is not None:
        for path in (folder, secret):
            shutil.chown(path, account)
    try:
        subprocess.run(
            [program("initdb"), "--pgdata", folder / "data", "--username", user, "--no-sync",
             "--auth=scram-sha-256", "--pwfile", secret, "--encoding=UTF8", "--no-locale"],
            check=True, user=account, cwd=folder, stdout=subprocess.DEVNULL,
        )  # fmt: skip
        settings = {"listen_addresses": "127.0.0.1", "port": port, "unix_socket_directories": "",
                    "fsync": "on" if fsync else "off"}  # fmt: skip
        options = [part for name, value in settings.items() for part in ("-c", f"{name}={value}")]
        with (folder / "log").open("wb") as log:
            running = subprocess.Popen(
                [program("postgres"), "-D", folder / "data", *options],
                user=account, cwd=folder, stdout=log, stderr=log,
            )  # fmt: skip
        try:
            _create(port, user, database, folder / "log")
            yield port
        finally:
            running.send_signal(signal.SIGINT)  # its fast shutdown
            running.wait(180.0)
    finally:
        shutil.rmtree(folder)


def _create(port: int, user: str, database: str, log: Path) -> None:
    address = f"postgresql://{user}:{PASSWORD}@127.0.0.1:{port}/postgres"
    for _ in range(1800):
        try:
            with psycopg.connect(address, autocommit=True) as connection:
                connection.execute(f'create database "{database}"'.encode())
        except psycopg.OperationalError:
            time.sleep(0.1)
        else:
            return
    raise AssertionError(log.read_text(errors="replace"))
