"""Logs and metrics for Prometheus: requests, solve times, designs by status, the queue."""

from __future__ import annotations

import json
import logging
import re
import time
import uuid
from datetime import UTC, datetime
from functools import partial

from fastapi import Request
from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram, generate_latest
from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import ClientDisconnect
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.wire.problem import error_response

VALID_ID = re.compile(r"[\w.:-]{1,64}", re.ASCII)
METHODS = frozenset({"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})
QUIET = frozenset({"/livez", "/readyz", "/metrics"})
NOT_MODIFIED = 304  # status of an answer without a body: the caller has it
CLIENT_GONE = 499  # in logs and metrics, as of proxies: there is no such answer
# Bounds of the buckets of times [s]: from a kept answer to the default time budget and beyond.
SECONDS = (0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 60.0)
# Of every response that says nothing else: it is what it says it is, no page elsewhere may show or
# load it, opened by itself it loads and runs nothing, and where it leads is not told whence.
SECURITY = {
    "X-Content-Type-Options": "nosniff",
    "Content-Security-Policy": "default-src 'none'; style-src 'unsafe-inline'; "
    "frame-ancestors 'self'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
}
log = logging.getLogger("camwright.request")


class Metrics:
    """The metrics of one application; where something happens, it is counted."""

    def __init__(self) -> None:
        self._registry = registry = CollectorRegistry()
        counter, gauge = partial(Counter, registry=registry), partial(Gauge, registry=registry)
        seconds = partial(Histogram, buckets=SECONDS, registry=registry)
        request = ("method", "route", "status")
        self.requests = counter("camwright_http_requests", "Requests answered.", request)
        self.latency = seconds(
            "camwright_http_request_seconds", "From request to the last byte.", ["route"]
        )
        self.solves = seconds("camwright_solve_seconds", "Time in the core.", ["status"])
        self.failures = counter(
            "camwright_failed_designs", "Designs that ended in a problem.", ["problem"]
        )
        self._designs = gauge("camwright_designs", "Designs in the store.", ["status"])
        self._waiting = gauge("camwright_designs_waiting", "Designs waiting for a worker.")
        self._running = gauge("camwright_designs_running", "Designs on a worker.")
        self._workers = gauge("camwright_workers", "Workers reachable.")

    def page(self, designs: dict[str, int], waiting: int, running: int, workers: int) -> bytes:
        """The text for Prometheus, with the current state."""
        self._designs.clear()
        for status, count in designs.items():
            self._designs.labels(status).set(count)
        self._waiting.set(waiting)
        self._running.set(running)
        self._workers.set(workers)
        return generate_latest(self._registry)


class JsonLine(logging.Formatter):
    """A record as one JSON object: its ``fields``, event, level, logger, time and exception."""

    def format(self, record: logging.LogRecord) -> str:
        time_utc = datetime.fromtimestamp(record.created, UTC).replace(tzinfo=None)
        line = {
            **getattr(record, "fields", {}),
            "event": record.getMessage(),
            "level": record.levelname.lower(),
            "logger": record.name,
            "timestamp": f"{time_utc.isoformat()}Z",
        }
        if record.exc_info:
            line["exception"] = self.formatException(record.exc_info)
        return json.dumps(line)


def configure_logs(level: str) -> None:
    """One JSON object a line on standard error: the service's own logs, and others' warnings."""
    handler = logging.StreamHandler()
    handler.setFormatter(JsonLine())
    logging.basicConfig(level=logging.WARNING, handlers=[handler], force=True)
    logging.getLogger("camwright").setLevel(level.upper())


class Observe:
    """The outermost middleware: an id for each request, a response to each, logs and metrics."""

    def __init__(self, app: ASGIApp, metrics: Metrics) -> None:
        self._app, self._metrics = app, metrics

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        id = Headers(scope=scope).get("x-request-id", "")
        scope["request_id"] = id if VALID_ID.fullmatch(id) else uuid.uuid4().hex
        started, status = time.perf_counter(), 0

        async def send_with_headers(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
                headers = MutableHeaders(scope=message)
                headers["X-Request-ID"] = scope["request_id"]
                # A browser puts the headers of a 304 over those of the page that it keeps.
                for name, value in SECURITY.items() if status != NOT_MODIFIED else ():
                    headers.setdefault(name, value)
            await send(message)

        try:
            await self._app(scope, receive, send_with_headers)
        except ClientDisconnect:  # in the middle of its body: nobody waits for an answer
            status = status or CLIENT_GONE
        except Exception as error:
            if status:
                raise  # the response has begun
            await error_response(Request(scope), error)(scope, receive, send_with_headers)
        finally:
            seconds = time.perf_counter() - started
            route = getattr(scope.get("route"), "path", "unmatched")
            method = scope["method"] if scope["method"] in METHODS else "other"
            self._metrics.requests.labels(method, route, str(status)).inc()
            self._metrics.latency.labels(route).observe(seconds)
            fields = {
                "method": method,
                "path": scope["path"],
                "status": status,
                "ms": round(1e3 * seconds, 1),
                "request_id": scope["request_id"],
            }
            if (caller := scope.get("caller")) is not None and caller.key is not None:
                fields |= {"owner": caller.owner, "key": caller.key}
            level = logging.DEBUG if route in QUIET else logging.INFO
            log.log(level, "request", extra={"fields": fields})
