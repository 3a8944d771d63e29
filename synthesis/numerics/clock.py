"""The clock of all deadlines; reading it also raises where the task was cancelled.

A deadline says when to stop with the best so far, a cancellation to stop with nothing. Both are
looked for in the same places: stages look between their steps, solvers between their iterations.

Where an answer must not depend on the machine's speed, solved programs are counted instead.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from math import inf
from threading import Event

from synthesis.errors import Cancelled

_cancelling: ContextVar[Event | None] = ContextVar("cancelling", default=None)


class _Solved(threading.local):
    programs = 0


_solved = _Solved()


@contextmanager
def cancellation_scope(event: Event) -> Iterator[None]:
    """What runs inside, in this thread, ends with Cancelled soon after the event is set."""
    token = _cancelling.set(event)
    try:
        yield
    finally:
        _cancelling.reset(token)


def now() -> float:
    """``time.monotonic()`` [s], which deadlines are given in.

    Raises:
        Cancelled: nobody waits for what is being done.
    """
    event = _cancelling.get()
    if event is not None and event.is_set():
        raise Cancelled
    return time.monotonic()


def count_program(count: int = 1) -> None:
    """Count more programs that a solver has ended; linear ones of one matrix count as one."""
    _solved.programs += count


def programs_solved() -> int:
    """Programs that solvers have ended in this thread so far."""
    return _solved.programs


def seconds_left(budget_s: float | None, deadline: float | None) -> float:
    """The shorter of a budget and the time to a deadline [s]; inf without either."""
    left = inf if deadline is None else deadline - now()
    return left if budget_s is None else min(budget_s, left)


def stop_callback() -> Callable[[], bool] | None:
    """What a solver, which cannot raise, asks between its iterations; None where nobody can stop.

    After a solver that was stopped in this way look at the clock: it raises.
    """
    event = _cancelling.get()
    return None if event is None else event.is_set
