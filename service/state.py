"""The parts of the running application, as handlers get them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, cast

from fastapi import Depends, Request

from service.resources.jobs import Jobs
from service.settings import Settings
from service.storage.store import Store
from service.sweeps.sweeps import Sweeps
from service.wire.observe import Metrics
from service.workers.engine import Engine


@dataclass(frozen=True)
class State:
    """The parts of the running application."""

    settings: Settings
    metrics: Metrics
    engine: Engine
    store: Store
    sweeps: Sweeps
    jobs: Mapping[str, Jobs]  # by the resource's path


def _state(request: Request) -> State:
    return cast(State, request.app.state.parts)


Parts = Annotated[State, Depends(_state)]
