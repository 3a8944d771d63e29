"""Who may ask: the names that the service is addressed by, keys, and how often each may come.

`Guard` stands before every route and lets through what needs no key, which is listed here; whatever
else there is, or comes to be, needs one.
"""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field, replace
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import urlsplit

from fastapi import Request
from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.wire.errors import ProblemType, ServiceError
from service.wire.fair_queue import current_owner
from service.wire.problem import error_response

audit = logging.getLogger("camwright.audit")
COOKIE = "camwright-key"
SESSION = "/session"  # where a browser leaves its key: what it loads by itself brings a cookie
# What holds nobody's data. All else needs a key.
OPEN_PATHS = frozenset(
    {"/", "/spatial", "/linkages", "/docs", "/redoc", "/openapi.json", "/livez", "/readyz", SESSION}
)
OPEN_FOLDERS = ("/studio/", "/assets/", "/guide", "/problems/")
# What watches the service addresses it by whatever name its network gives it; they tell nothing
# that a page elsewhere could use.
UNDER_ANY_NAME = frozenset({"/livez", "/readyz"})
OPERATORS_PATHS = frozenset({"/metrics"})
MINUTE_S = 60.0
REFUSALS = (ProblemType.KEY_NEEDED, ProblemType.NOT_ALLOWED)
CHANGES = {"POST": "create", "DELETE": "delete"}
HOW = "Send it as `Authorization: Bearer <key>`; the operator makes one: camwright keys create."


class KeyRefused(Exception):
    """A key that opens nothing; the text says what it is instead of valid."""


@dataclass(frozen=True)
class Quotas:
    """What a key allows; None: as much as there is.

    Attributes:
        requests_per_minute: with this key. core_seconds_per_day: of its owner, by UTC [s].
        storage_mb: that the owner's answers may take [10^6 bytes]. concurrent: questions of the
            owner that are worked on at the same time.
    """

    requests_per_minute: int | None = None
    core_seconds_per_day: float | None = None
    storage_mb: float | None = None
    concurrent: int | None = None

    @property
    def limited(self) -> bool:
        """Whether they allow less than there is."""
        return self != Quotas()

    def with_own(self, own: Mapping[str, Any]) -> Quotas:
        """With the numbers that a key has of its own."""
        return replace(self, **own)


@dataclass(frozen=True)
class Caller:
    """Who asks: the owner of what comes of it, and the id of the key, where there is one."""

    owner: str
    key: str | None = None
    operator: bool = False
    quotas: Quotas = field(default=Quotas())


@dataclass
class _Window:
    """Requests of a key since the window began."""

    began: float
    count: int = 0


class Guard:
    """Refuses what comes by another name than the service's, or without a key that it needs.

    Args:
        hosts: names by which the service is addressed.
        caller_of: who has a key; raises KeyRefused.
        without_key: as whom those ask who have none; None: they are refused.
    """

    def __init__(
        self,
        app: ASGIApp,
        hosts: frozenset[str],
        caller_of: Callable[[str], Awaitable[Caller]],
        without_key: Caller | None,
    ) -> None:
        self._app, self._hosts, self._caller_of = app, hosts, caller_of
        self._without_key = without_key
        self._windows: dict[str, _Window] = {}  # by key: at most as many as there are keys

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        headers, limits = Headers(scope=scope), dict[str, str]()
        try:
            if scope["path"] not in UNDER_ANY_NAME:
                self._check_host(headers)
            scope["caller"] = caller = await self._caller(scope["path"], headers)
            if caller is not None:
                if caller.key is not None:  # without keys an address is all that tells them apart
                    current_owner.set(caller.owner)
                limits = self._count(caller)
                _check_operator(scope["path"], caller)
        except Exception as error:
            if isinstance(error, ServiceError) and error.problem in REFUSALS:
                _note("refuse", scope, error.problem.status)
            await error_response(Request(scope), error)(scope, receive, send)
            return

        async def send_and_note(message: Message) -> None:
            if message["type"] == "http.response.start":
                own = MutableHeaders(scope=message)
                for name, value in limits.items():
                    own.append(name, value)
                if caller is not None and caller.key is not None:
                    own.setdefault("Cache-Control", "private")
                action = CHANGES.get(scope["method"])
                if action and caller is not None and message["status"] < 400:
                    made = own.get("location") or own.get("content-location")
                    _note(action, scope, message["status"], made)
            await send(message)

        await self._app(scope, receive, send_and_note)

    def _check_host(self, headers: Headers) -> None:
        """Refuse other names: a page elsewhere that gives its own name this address is not let in.

        Starlette's TrustedHostMiddleware does the same, but answers in plain text.
        """
        host = headers.get("host", "")
        try:
            name = urlsplit(f"//{host}").hostname or ""
        except ValueError:
            name = ""
        if name not in self._hosts:
            raise ProblemType.MISDIRECTED(
                f"Host is {host[:100]!r}, which is no name of this service. Address it as "
                f"{', '.join(sorted(self._hosts))}; its operator adds names by "
                "CAMWRIGHT_ALLOWED_HOSTS."
            )

    async def _caller(self, path: str, headers: Headers) -> Caller | None:
        """Who asks; None where nobody needs to be known. ServiceError where no key opens this."""
        if path in OPEN_PATHS or path.startswith(OPEN_FOLDERS):
            return None
        key = key_of(headers)
        if key is None:
            if self._without_key is not None:
                return self._without_key
            raise refusal(f"{path} needs a key. {HOW}", "")
        try:
            caller = await self._caller_of(key)
        except KeyRefused as error:
            # A browser's cookie may be of another service on this machine: hosts have no ports.
            if self._without_key is not None and "authorization" not in headers:
                return self._without_key
            raise refusal(f"The key {error}. {HOW}", ', error="invalid_token"') from None
        return caller

    def _count(self, caller: Caller) -> dict[str, str]:
        """Count a request; the headers that say how many are left. ServiceError: none was left.

        Headers as in draft-ietf-httpapi-ratelimit-headers-10, sections 3 and 4.
        """
        most = caller.quotas.requests_per_minute
        if most is None or caller.key is None:
            return {}
        now = time.monotonic()
        window = self._windows.setdefault(caller.key, _Window(now))
        if now - window.began >= MINUTE_S:
            window.began, window.count = now, 0
        window.count += 1
        left = math.ceil(window.began + MINUTE_S - now)
        limits = limit_headers("requests", most, MINUTE_S, max(0, most - window.count), left)
        if window.count > most:
            raise ProblemType.QUOTA_USED_UP(
                f"This key allows {most} requests a minute. Ask again in {left} s.",
                {**limits, "Retry-After": str(left)},
            )
        return limits


def _check_operator(path: str, caller: Caller) -> None:
    if path in OPERATORS_PATHS and not caller.operator:
        raise ProblemType.NOT_ALLOWED(
            f"{path} counts the work of all owners: it needs an operator's key, as "
            "`camwright keys create --operator` makes it."
        )


def limit_headers(
    name: str, most: float, window_s: float | None, left: float, until_s: float | None
) -> dict[str, str]:
    """How much a quota allows, in which window, and how much of it is left until when."""
    window = "" if window_s is None else f";w={window_s:.0f}"
    until = "" if until_s is None else f";t={until_s:.0f}"
    return {
        "RateLimit-Policy": f'"{name}";q={math.floor(most)}{window}',
        "RateLimit": f'"{name}";r={math.floor(left)}{until}',
    }


def key_of(headers: Headers) -> str | None:
    """The key that a request brings: in Authorization, or in a browser's cookie."""
    if "authorization" in headers:
        scheme, _, key = headers["authorization"].partition(" ")
        return key.strip() if scheme.lower() == "bearer" else ""
    try:
        cookie = SimpleCookie(headers.get("cookie", "")).get(COOKIE)
    except CookieError:
        return None
    return cookie.value if cookie else None


def refusal(detail: str, error: str) -> Exception:
    """401 with what RFC 6750 wants to be said in the header."""
    return ProblemType.KEY_NEEDED(detail, {"WWW-Authenticate": f'Bearer realm="camwright"{error}'})


def _note(action: str, scope: Scope, status: int, made: str | None = None) -> None:
    """A line of the audit log: who did what by which key. Keys themselves are in no log."""
    caller, client = scope.get("caller"), scope.get("client")
    fields = {
        "action": action,
        "method": scope["method"],
        "path": scope["path"],
        "made": made,
        "owner": caller and caller.owner,
        "key": caller and caller.key,
        "client": client and client[0],
        "status": status,
    }
    audit.info("audit", extra={"fields": fields})
