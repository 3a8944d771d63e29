"""Traces, where OTEL_EXPORTER_OTLP_ENDPOINT says where to send them; without it, nothing.

FastAPI configures OpenTelemetry by its standard variables, and makes the span of each request, a
child of the caller's where `traceparent` names one. What is done for a request is a span within it.
Workers make none: what they measure comes back with their answers (`service.workers.measured`).
"""

from __future__ import annotations

import logging
import os
from collections.abc import Iterable, Mapping
from contextlib import AbstractContextManager, nullcontext
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from opentelemetry import trace
from opentelemetry.context import Context

from synthesis.errors import ExtraMissing

if TYPE_CHECKING:
    from fastapi.telemetry import TelemetryConfig

log = logging.getLogger("camwright.traces")
ADDRESSES = ("OTEL_EXPORTER_OTLP_ENDPOINT", "OTEL_EXPORTER_OTLP_TRACES_ENDPOINT")
QUIET = frozenset({"/livez", "/readyz", "/metrics"})  # asked every few seconds
tracer = trace.get_tracer("camwright")


def telemetry() -> TelemetryConfig:
    """What FastAPI does of it: the spans of requests. Metrics and logs are ours."""
    wanted = any(map(os.environ.get, ADDRESSES))
    installed = wanted and find_spec("opentelemetry.exporter") is not None
    if installed:
        os.environ.setdefault("OTEL_SERVICE_NAME", "camwright")
    elif wanted:
        log.warning("%s", ExtraMissing("Sending traces", "traces"))
    return {
        "auto_configure": installed,
        "metrics": False,
        "logs": False,
        "operation_spans": False,
        "exclude": lambda scope: scope.get("path") in QUIET,
    }


def span(name: str, **attributes: Any) -> AbstractContextManager[Any]:
    """A span within the one that is under way; nothing where none is recorded."""
    if not trace.get_current_span().is_recording():
        return nullcontext()
    return tracer.start_as_current_span(name, attributes=attributes, record_exception=False)


def separate_span(name: str) -> AbstractContextManager[Any]:
    """A span of a trace of its own, linked to the one that has led to it.

    For parts of what is long: a trace of 20 000 items is none that anybody reads.
    """
    link = trace.Link(trace.get_current_span().get_span_context())
    return tracer.start_as_current_span(
        name, context=Context(), links=[link], record_exception=False
    )


def traceparent() -> str:
    """The span that is under way, as W3C writes it in a header; empty where there is none."""
    current = trace.get_current_span().get_span_context()
    if not current.is_valid:
        return ""
    return f"00-{current.trace_id:032x}-{current.span_id:016x}-{current.trace_flags:02x}"


def past_span(
    name: str,
    ended_ns: int,
    seconds: float,
    parts: Iterable[tuple[str, float, Mapping[str, Any]]],
    **attributes: Any,
) -> None:
    """A span of what has ended [ns since 1970] within the one that is under way.

    Args:
        parts: name, seconds and attributes of spans in it, end to end: reports have no times.
    """
    if not trace.get_current_span().is_recording():
        return
    at = ended_ns - round(1e9 * seconds)
    whole = tracer.start_span(name, start_time=at, attributes=attributes)
    within = trace.set_span_in_context(whole)
    for part, part_s, known in parts:
        part_span = tracer.start_span(part, within, start_time=at, attributes=known)
        at += round(1e9 * part_s)
        part_span.end(at)
    whole.end(ended_ns)
