"""Cancel work on a worker, by an event that the work looks at whenever it reads the clock."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from threading import Event
from typing import Any, TypeVar

from synthesis.numerics import clock

T = TypeVar("T")
_events: dict[str, Event] = {}


def run_cancellable(name: str, work: Callable[..., T], *arguments: Any) -> T:
    """Run some work in a worker process; it ends with ``Cancelled`` after ``cancel``."""
    event = _events[name] = Event()
    try:
        with clock.cancellation_scope(event):
            return work(*arguments)
    finally:
        del _events[name]


def cancel(names: Sequence[str]) -> None:
    """Cancel the work of these names that runs in this process."""
    for name in names:
        event = _events.get(name)
        if event is not None:
            event.set()
