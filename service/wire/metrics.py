"""Metrics for Prometheus: requests by route, solve times, designs by status, the queue."""

from __future__ import annotations

from functools import partial

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram, generate_latest

SECONDS = (0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 60.0)


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
