"""Logs and metrics for Prometheus: requests, solve times, designs by status, the queue."""

from __future__ import annotations

import logging
import re
import time
import uuid
from functools import partial

import structlog
from fastapi import Request
from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram, generate_latest
from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.wire.problem import error_response

VALID_ID = re.compile(r"[\w.:-]{1,64}", re.ASCII)
METHODS = frozenset({"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})
QUIET = frozenset({"/livez", "/readyz", "/metrics"})
# Bounds of the buckets of times [s]: from a kept answer to the default time budget and beyond.
SECONDS = (0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 60.0)
log = structlog.get_logger("camwright.request")


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


def configure_logs(level: str) -> None:
    """One JSON object a line on standard error: the service's own logs, and others' warnings."""
    steps: list[structlog.typing.Processor] = [
        structlog.stdlib.add_log_level,
        structlog.stdlib.add_logger_name,
        structlog.processors.TimeStamper(fmt="iso", utc=True),
    ]
    handler = logging.StreamHandler()
    handler.setFormatter(
        structlog.stdlib.ProcessorFormatter(
            foreign_pre_chain=steps,
            processors=[
                structlog.stdlib.ProcessorFormatter.remove_processors_meta,
                structlog.processors.format_exc_info,
                structlog.processors.JSONRenderer(),
            ],
        )
    )
    structlog.configure(
        processors=[*steps, structlog.stdlib.ProcessorFormatter.wrap_for_formatter],
        logger_factory=structlog.stdlib.LoggerFactory(),
        wrapper_class=structlog.stdlib.BoundLogger,
        cache_logger_on_first_use=True,
    )
    root = logging.getLogger()
    root.handlers[:] = [handler]
    root.setLevel(logging.WARNING)
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
                headers["X-Content-Type-Options"] = "nosniff"
            await send(message)

        try:
            await self._app(scope, receive, send_with_headers)
        except Exception as error:
            if status:
                raise  # the response has begun
            await error_response(Request(scope), error)(scope, receive, send_with_headers)
        finally:
            self._log(scope, status, time.perf_counter() - started)

    def _log(self, scope: Scope, status: int, seconds: float) -> None:
        route = getattr(scope.get("route"), "path", "unmatched")
        method = scope["method"] if scope["method"] in METHODS else "other"
        self._metrics.requests.labels(method, route, str(status)).inc()
        self._metrics.latency.labels(route).observe(seconds)
        level = logging.DEBUG if route in QUIET else logging.INFO
        log.log(
            level,
            "request",
            method=method,
            path=scope["path"],
            status=status,
            ms=round(1e3 * seconds, 1),
            request_id=scope["request_id"],
        )
