"""What a worker measures of its task, and hands back with the result: metrics and spans come of it.

The core's report says what each of its stages took; nothing is measured twice.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Any, TypeVar

from service.wire import logs
from synthesis.design.design import Effort

T = TypeVar("T")
# What is told of a stage beside its name and seconds: of the fields of `Effort`.
TOLD = ("model", "solver", "iterations", "nodes", "status", "exit")


@dataclass(frozen=True)
class Stage:
    """A stage of the core: ``kind`` is its name without a number; ``told`` what else is known."""

    name: str
    seconds: float
    attributes: Mapping[str, Any]

    @property
    def kind(self) -> str:
        """Its name without the number of a mesh: there are few kinds."""
        return self.name.rstrip("0123456789 ")


@dataclass(frozen=True)
class Solve:
    """What the core did for one question: how it ended, when [ns since 1970], and its stages."""

    status: str
    seconds: float
    ended_ns: int
    stages: Sequence[Stage]


_solves: ContextVar[list[Solve] | None] = ContextVar("solves", default=None)


def measured(
    ids: Mapping[str, str], traceparent: str, work: Callable[..., T], *arguments: Any
) -> tuple[T, list[Solve]]:
    """In a worker: the result of some work, and what the core did for it.

    Args:
        ids: of the request that it is for; lines of logs have them, and those of ``traceparent``,
            the span that waits for it, as W3C writes it.
    """
    solves: list[Solve] = []
    noting = _solves.set(solves)
    naming = logs.ids.set({**ids, **logs.trace_ids(traceparent)})
    try:
        return work(*arguments), solves
    finally:
        logs.ids.reset(naming)
        _solves.reset(noting)


def note(status: str, seconds: float, efforts: Sequence[Effort] = ()) -> None:
    """Note that the core has just ended work on a question; nothing outside of a worker's task."""
    solves = _solves.get()
    if solves is not None:
        stages = [
            Stage(each.stage, each.seconds, {name: getattr(each, name) for name in TOLD})
            for each in efforts
        ]
        solves.append(Solve(status, seconds, time.time_ns(), stages))
