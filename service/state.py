"""The parts of the running application, as handlers get them."""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping
from dataclasses import dataclass, replace
from typing import Annotated, cast

from fastapi import Depends, Request

from service.resources.jobs import Jobs
from service.resources.quotas import UsedQuotas
from service.settings import Settings
from service.storage.keys import ApiKeys
from service.storage.store import Store
from service.sweeps.sweeps import Sweeps
from service.wire.access import Caller
from service.wire.observe import Metrics
from service.wire.places import Places
from service.workers.engine import Engine
from service.workers.side_processes import SideProcesses

NOBODY = Caller("")  # who has nothing: no owner is called so


@dataclass(frozen=True)
class State:
    """The parts of the running application; a handler gets them with the ``caller`` who asks."""

    settings: Settings
    metrics: Metrics
    engine: Engine
    store: Store
    sweeps: Sweeps
    readers: SideProcesses
    writers: SideProcesses
    streams: Places
    jobs: Mapping[str, Jobs]  # by the resource's path
    keys: ApiKeys
    quotas: UsedQuotas
    caller: Caller = NOBODY

    @property
    def owner(self) -> str:
        """Whose answers and sweeps the caller sees."""
        return self.caller.owner


async def _state(request: Request) -> State:  # a plain function would be sent to a thread
    """The parts, for whoever asks; on paths that are open to all for nobody."""
    parts = cast(State, request.app.state.parts)
    return replace(parts, caller=request.scope.get("caller") or NOBODY)


Parts = Annotated[State, Depends(_state)]


async def hold_stream(request: Request, parts: Parts) -> AsyncIterator[None]:
    """A place among those who watch, for as long as the response takes."""
    address = request.client.host if request.client else ""
    parts.streams.take(address)
    try:
        yield
    finally:
        parts.streams.leave(address)
