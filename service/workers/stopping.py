"""How work on a worker is stopped: by a word to its process, which the work hears at its clock."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from threading import Event
from typing import Any, TypeVar

from synthesis import clock

T = TypeVar("T")
_at_work: dict[str, Event] = {}


def stoppable(name: str, work: Callable[..., T], *given: Any) -> T:
    """Some work that ends with Cancelled once it is told to; runs in a worker process."""
    event = _at_work[name] = Event()
    try:
        with clock.cancelled_by(event):
            return work(*given)
    finally:
        del _at_work[name]


def stop(names: Sequence[str]) -> None:
    """Tell what goes by these names in this process to end; nothing where it is not there."""
    for name in names:
        event = _at_work.get(name)
        if event is not None:
            event.set()
