"""A worker that is restarted takes nothing with it but the work that it is restarted for."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path
from typing import Any

import pytest

from service.workers.engine import running_engine
from synthesis.errors import TimeBudgetExceeded
from tests.service import fake_core
from tests.service.conftest import settings_for
from tests.service.specs import spec

ENOUGH_S = 20.0


def body(word: str) -> bytes:
    return json.dumps(spec(word)).encode()


def test_designs_sent_while_a_worker_is_restarted_are_solved_by_the_other(tmp_path: Path) -> None:
    """Between the decision to restart a worker and its end the scheduler still knows it."""
    solved = []

    async def story() -> None:
        settings = settings_for(tmp_path, grace_s=0.1)
        async with running_engine(settings, fake_core.task, fake_core.prepare) as engine:
            restart_workers = engine._client.restart_workers

            async def restart_after_others(*given: Any, **named: Any) -> Any:
                for _ in range(4):
                    solved.append(await engine.solve(body("quick"), ENOUGH_S))
                return await restart_workers(*given, **named)

            engine._client.restart_workers = restart_after_others
            with pytest.raises(TimeBudgetExceeded):
                await engine.solve(body("sleep 3600"), 0.1)
            await asyncio.gather(*engine._repairs)
            assert await engine.workers() == 2
            solved.append(await engine.solve(body("quick"), ENOUGH_S))

    asyncio.run(story())
    assert len(solved) == 5
