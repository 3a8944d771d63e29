"""Metrics for Prometheus: requests by route, solve times, designs by status, the queue."""

from __future__ import annotations

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram, generate_latest

SECONDS = (0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 60.0)


class Metrics:
    """The metrics of one application."""

    def __init__(self) -> None:
        self._registry = registry = CollectorRegistry()
        self._requests = Counter(
            "camwright_http_requests", "Requests answered.", ["method", "route", "status"],
            registry=registry,
        )  # fmt: skip
        self._latency = Histogram(
            "camwright_http_request_seconds", "From request to the last byte.", ["route"],
            buckets=SECONDS, registry=registry,
        )  # fmt: skip
        self._solves = Histogram(
            "camwright_solve_seconds", "Time in the core.", ["status"],
            buckets=SECONDS, registry=registry,
        )  # fmt: skip
        self._failures = Counter(
            "camwright_failed_designs", "Designs that ended in a problem.", ["problem"],
            registry=registry,
        )  # fmt: skip
        self._designs = Gauge(
            "camwright_designs", "Designs in the store.", ["status"], registry=registry
        )
        self._waiting = Gauge(
            "camwright_designs_waiting", "Designs waiting for a worker.", registry=registry
        )
        self._running = Gauge(
            "camwright_designs_running", "Designs on a worker.", registry=registry
        )
        self._workers = Gauge("camwright_workers", "Workers reachable.", registry=registry)

    def count_request(self, method: str, route: str, status: int, seconds: float) -> None:
        """Count a request."""
        self._requests.labels(method, route, str(status)).inc()
        self._latency.labels(route).observe(seconds)

    def count_solve(self, status: str, seconds: float) -> None:
        """Count an answer."""
        self._solves.labels(status).observe(seconds)

    def count_failure(self, problem: str) -> None:
        """Count a question that ended in a problem."""
        self._failures.labels(problem).inc()

    def page(self, designs: dict[str, int], waiting: int, running: int, workers: int) -> bytes:
        """The text for Prometheus, with the current state."""
        self._designs.clear()
        for status, count in designs.items():
            self._designs.labels(status).set(count)
        self._waiting.set(waiting)
        self._running.set(running)
        self._workers.set(workers)
        return generate_latest(self._registry)
