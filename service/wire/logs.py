"""Logs: one JSON object a line, with the ids of the request and the trace that it belongs to."""

from __future__ import annotations

import json
import logging
from collections.abc import Mapping
from contextvars import ContextVar
from datetime import UTC, datetime
from types import MappingProxyType

# Of what is being done: in the service of a request and the work that it began, in a worker of its
# task. Tasks of asyncio inherit them.
ids: ContextVar[Mapping[str, str]] = ContextVar("ids", default=MappingProxyType({}))


def trace_ids(traceparent: str) -> dict[str, str]:
    """The ids of a trace and a span in it as logs have them, from a header of W3C ("": none)."""
    return dict(zip(("trace_id", "span_id"), traceparent.split("-")[1:3], strict=False))


class JsonLine(logging.Formatter):
    """A record as one JSON object: ids, its ``fields``, event, level, logger, time, exception."""

    def format(self, record: logging.LogRecord) -> str:
        time_utc = datetime.fromtimestamp(record.created, UTC).replace(tzinfo=None)
        line = {
            **ids.get(),
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
    logging.captureWarnings(True)
    logging.getLogger("camwright").setLevel(level.upper())
