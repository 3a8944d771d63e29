"""The settings, from the environment; and the listening socket, opened before all else."""

from __future__ import annotations

import errno
import socket
import sys
from functools import cached_property
from ipaddress import ip_address
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError, field_validator
from pydantic_settings import BaseSettings, NoDecode, SettingsConfigDict
from sqlalchemy import URL, make_url
from sqlalchemy.exc import ArgumentError

# As which a browser on the same machine addresses a service there.
LOOPBACK_NAMES = ("localhost", "127.0.0.1", "::1")
# Connections that may wait to be accepted: beyond these the kernel drops them, and their peers try
# again after a second. Not more, as whoever comes waits for all who came before: with 1024 of them
# a flood of connections kept others waiting for 2 s and more, with 256 for 0.1 to 0.6 s.
BACKLOG = 256


class Settings(BaseSettings):
    """The settings of an operator; each field is CAMWRIGHT_<NAME> in the environment."""

    model_config = SettingsConfigDict(env_prefix="CAMWRIGHT_", frozen=True, extra="forbid")

    host: str = "127.0.0.1"
    port: int = Field(8000, ge=0, le=65535)
    database_url: str = "sqlite:///camwright.db"  # SQLAlchemy URL: SQLite, or PostgreSQL
    scheduler: str | None = None  # tls:// address of Dask's; None: workers of the service's own
    workers: int = Field(2, ge=1, le=1024)  # processes of the service's own
    # That each of them may have [2^20 bytes]; None: its share of the machine's, or the container's.
    worker_memory_mib: int | None = Field(None, ge=256)
    time_budget_s: float = Field(30.0, gt=0.0)  # of a design that requests none [s]
    max_time_budget_s: float = Field(300.0, gt=0.0)  # that a design may request [s]
    grace_s: float = Field(2.0, gt=0.0)  # after the time budget, until the worker is stopped [s]
    max_body_bytes: int = Field(1_048_576, ge=1024)
    # Bytes of path, query and headers: browsers send at most 16 kB of cookies and the like.
    max_head_bytes: int = Field(32_768, ge=1024)
    # In which a whole request has to arrive, from the connection or its first byte on [s]: a body
    # of 1 MiB by a line of 0.5 Mbit/s.
    request_timeout_s: float = Field(20.0, gt=0.0)
    keep_alive_s: int = Field(5, ge=1)  # that a connection stays open without a request [s]
    # That a peer may take to acknowledge, or to read, what it is sent [s]; then it is taken for
    # gone. A stream of events has a sign of life every 15 s.
    unread_s: int = Field(60, ge=1)
    max_connections: int = Field(1024, ge=1)  # at the same time
    # By address: 40 browsers, each with 6. A proxy before the service is one client: set it to
    # max_connections then, and have the proxy limit its own clients.
    max_connections_per_client: int = Field(256, ge=1)
    # Of events, at the same time: each asks the store once a second.
    max_streams: int = Field(64, ge=1)
    max_streams_per_client: int = Field(32, ge=1)  # by address
    readers: int = Field(2, ge=1, le=64)  # that read long bodies, and as many that make files
    # Of processor time, that reading a body may take [s]. The longest sensible ones, tables of
    # 20 000 rows, take 0.2 s.
    reading_s: float = Field(10.0, gt=0.0)
    max_waiting: int = Field(64, ge=0)  # designs that may wait for a worker
    max_sweep_items: int = Field(20_000, ge=1)  # that a sweep may have
    # After so long without renewal of its lease, another process that shares the database
    # continues a question or a sweep [s].
    lease_s: float = Field(5.0, ge=0.5, le=3600.0)
    max_sweeps: int = Field(16, ge=1)  # that may run at the same time
    idempotency_hours: float = Field(24.0, gt=0.0)
    # Who may use it. None: on the loopback anyone until there is a key, elsewhere those with a key.
    access: Literal["keys", "open-to-anyone"] | None = None
    # Names by which the service is addressed, with commas; those of the loopback always are.
    allowed_hosts: Annotated[tuple[str, ...], NoDecode] = ()
    cors_origins: list[str] = []
    # What a key allows that was made without numbers of its own; None: as much as there is.
    quota_requests_per_minute: int | None = Field(None, ge=1)
    quota_core_seconds_per_day: float | None = Field(None, gt=0.0)  # of the key's owner [s]
    quota_storage_mb: float | None = Field(None, gt=0.0)  # of the key's owner [10^6 bytes]
    quota_concurrent: int | None = Field(None, ge=1)  # questions of the owner that are worked on
    log_level: str = Field("info", pattern="^(debug|info|warning|error)$")

    @field_validator("database_url")
    @classmethod
    def _is_an_address(cls, value: str) -> str:
        try:
            make_url(value)
        except ArgumentError as error:
            raise ValueError("not a database address such as sqlite:///camwright.db") from error
        return value

    @field_validator("allowed_hosts", mode="before")
    @classmethod
    def _are_names(cls, value: Any) -> Any:
        names = value.split(",") if isinstance(value, str) else value
        return tuple(name.strip().strip("[]").lower() for name in names if name.strip())

    @property
    def hosts(self) -> frozenset[str]:
        """Names by which it may be addressed, without ports."""
        own = () if self.host in ("0.0.0.0", "::") else (self.host.lower(),)
        return frozenset((*LOOPBACK_NAMES, *own, *self.allowed_hosts))

    @property
    def reaches_others(self) -> bool:
        """Whether other machines reach it: it listens wider, or has a name beyond the loopback."""
        return not all(map(_is_loopback, (self.host, *self.allowed_hosts)))

    @field_validator("scheduler")
    @classmethod
    def _is_encrypted(cls, value: str | None) -> str | None:
        if value is not None and not value.startswith("tls://"):
            raise ValueError(
                "a scheduler runs whatever code it is sent, so it must ask for certificates: name "
                "an address such as tls://10.0.0.5:8786, see docs/deployment.md"
            )
        return value

    @cached_property
    def database(self) -> URL:
        """The parsed address of the database."""
        return make_url(self.database_url)

    @property
    def worker_memory(self) -> int:
        """Memory that a worker may have [bytes]; 0: its share."""
        return 2**20 * (self.worker_memory_mib or 0)

    def budget_s(self, requested: float | None) -> float:
        """Time budget [s] of a question: what it asks for, or the default, at most the maximum."""
        return min(requested or self.time_budget_s, self.max_time_budget_s)


def _is_loopback(host: str) -> bool:
    if host == "localhost":
        return True
    try:
        return ip_address(host).is_loopback
    except ValueError:  # a name
        return False


def settings_from(**given: Any) -> Settings:
    """Settings from arguments, the environment and defaults; one sentence and exit 1 if invalid."""
    try:
        return Settings(**given)
    except ValidationError as error:
        first = error.errors()[0]
        name = str(first["loc"][0]) if first["loc"] else ""
        sys.exit(
            f"CAMWRIGHT_{name.upper()} (or --{name.replace('_', '-')}) is {first['input']!r}: "
            f"{first['msg']}."
        )


def listening_socket(settings: Settings) -> socket.socket:
    """A socket that listens at the configured address; one sentence and exit 1 where it cannot.

    It is opened before anything slow is imported, so that a port in use is reported at once.
    """
    family = socket.AF_INET6 if ":" in settings.host else socket.AF_INET
    # asyncio disables Nagle's algorithm only on sockets whose protocol is given.
    listener = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        _notice_absent_peers(listener, settings.unread_s)
        listener.bind((settings.host, settings.port))
        listener.listen(BACKLOG)
    except OSError as error:
        listener.close()
        in_use = error.errno == errno.EADDRINUSE
        reason = "is in use by another program" if in_use else f"cannot be used ({error.strerror})"
        sys.exit(
            f"Port {settings.port} on {settings.host} {reason}: choose another one with "
            "--port or CAMWRIGHT_PORT."
        )
    listener.set_inheritable(True)
    return listener


def _notice_absent_peers(listener: socket.socket, unread_s: int) -> None:
    """Have the kernel end connections whose peer is gone or reads nothing; they inherit that."""
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    # Not every system has them: without, its own times hold, which are hours.
    for name, value in (
        ("TCP_KEEPIDLE", unread_s),  # of silence before the first probe [s]
        ("TCP_KEEPINTVL", max(1, unread_s // 4)),  # between probes [s]
        ("TCP_KEEPCNT", 4),
        ("TCP_USER_TIMEOUT", 1000 * unread_s),  # what was sent, and a window of nothing [ms]
    ):
        if hasattr(socket, name):
            listener.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)
