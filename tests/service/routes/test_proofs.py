"""Proofs wait in the queue as designs do."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace
from typing import Any

import pytest

from service.resources.jobs import Jobs
from service.resources.records import PROOFS
from service.routes import proofs
from service.wire.errors import ServiceError
from service.wire.fair_queue import FairQueue


class Room:
    async def __aenter__(self) -> None: ...
    async def __aexit__(self, *_: object) -> None: ...


@pytest.mark.parametrize("wait", [True, False])
def test_a_full_queue_refuses_a_proof_and_keeps_nothing_of_it(wait: bool) -> None:
    async def story() -> None:
        queue = FairQueue(lambda: 1, 1, "questions")
        await queue.acquire()
        waiting = asyncio.create_task(queue.acquire())
        await asyncio.sleep(0)

        async def find(*_: Any) -> None:
            return None

        jobs: Any = SimpleNamespace(
            answers=SimpleNamespace(find=find), _attempts={}, engine=SimpleNamespace(queue=queue),
            room=lambda id: Jobs.room(jobs, id),
        )  # fmt: skip
        quotas = SimpleNamespace(room=lambda *_: Room())
        parts: Any = SimpleNamespace(jobs={PROOFS.path: jobs}, owner="ada", quotas=quotas, caller=0)
        row: Any = SimpleNamespace(name="a cam")
        with pytest.raises(ServiceError, match="waiting already"):
            await proofs._proof(None, parts, row, b"{}", wait=wait)  # type: ignore[arg-type]
        waiting.cancel()

    asyncio.run(story())
