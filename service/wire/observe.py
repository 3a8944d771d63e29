"""Metrics for Prometheus, and a log line, ids and headers for every request."""

from __future__ import annotations

import logging
import re
import time
import uuid
from functools import partial

from fastapi import Request
from opentelemetry import trace
from prometheus_client import (
    CollectorRegistry,
    Counter,
    Gauge,
    Histogram,
    ProcessCollector,
    Summary,
    generate_latest,
)
from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import ClientDisconnect
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.wire.logs import ids, trace_ids
from service.wire.problem import error_response
from service.wire.tracing import QUIET, traceparent

VALID_ID = re.compile(r"[\w.:-]{1,64}", re.ASCII)
METHODS = frozenset({"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})
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
        ProcessCollector(registry=registry)
        counter, gauge = partial(Counter, registry=registry), partial(Gauge, registry=registry)
        seconds = partial(Histogram, buckets=SECONDS, registry=registry)
        request = ("method", "route", "status")
        self.requests = counter("camwright_http_requests", "Requests answered.", request)
        self.latency = seconds(
            "camwright_http_request_seconds", "From request to the last byte.", ["route"]
        )
        self.queue = seconds("camwright_queue_seconds", "Wait for a worker.", ["work"])
        self.work = seconds("camwright_worker_seconds", "A task with a worker.", ["work"])
        self.lost = counter("camwright_workers_lost", "Workers that ended with a task.")
        self.solves = seconds(
            "camwright_solve_seconds", "Time in the core, items of sweeps included.", ["status"]
        )
        self.stages = seconds("camwright_stage_seconds", "Stages of the core.", ["stage"])
        self.failures = counter(
            "camwright_failed_designs", "Designs that ended in a problem.", ["problem"]
        )
        self.files = Summary(
            "camwright_file_seconds", "Making a file of an answer.", ["file"], registry=registry
        )
        self.store = seconds("camwright_store_seconds", "A transaction, its wait included.")
        self.store_failures = counter(
            "camwright_store_failures", "Transactions that the store failed at."
        )
        self._store_up = gauge("camwright_store_up", "Whether the store has answered just now.")
        self._designs = gauge("camwright_designs", "Designs in the store.", ["status"])
        self._waiting = gauge("camwright_designs_waiting", "Designs waiting for a worker.")
        self._running = gauge("camwright_designs_running", "Designs on a worker.")
        self._sweeps = gauge("camwright_sweeps_running", "Sweeps that this process works on.")
        self._workers = gauge("camwright_workers", "Workers reachable.")

    def page(
        self, designs: dict[str, int] | None, waiting: int, running: int, sweeps: int, workers: int
    ) -> bytes:
        """The text for Prometheus, with the current state; ``designs`` None: no store answers."""
        self._store_up.set(designs is not None)
        self._designs.clear()
        for status, count in (designs or {}).items():
            self._designs.labels(status).set(count)
        self._waiting.set(waiting)
        self._running.set(running)
        self._sweeps.set(sweeps)
        self._workers.set(workers)
        return generate_latest(self._registry)


class Observe:
    """The outermost middleware: an id for each request, a response to each, logs and metrics."""

    def __init__(self, app: ASGIApp, metrics: Metrics) -> None:
        self._app, self._metrics = app, metrics

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        id = Headers(scope=scope).get("x-request-id", "")
        scope["request_id"] = id = id if VALID_ID.fullmatch(id) else uuid.uuid4().hex
        ids.set({"request_id": id, **trace_ids(traceparent())})
        trace.get_current_span().set_attribute("camwright.request_id", id)
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
            }
            if (caller := scope.get("caller")) is not None and caller.key is not None:
                fields |= {"owner": caller.owner, "key": caller.key}
            level = logging.DEBUG if route in QUIET else logging.INFO
            log.log(level, "request", extra={"fields": fields})
