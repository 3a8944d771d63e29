"""The contract is made once, by whoever asks first; a service that was started has it at hand."""

from __future__ import annotations

import asyncio
import gc
from typing import Any
from unittest.mock import MagicMock

import pytest
import uvicorn
from fastapi import FastAPI

from service import pages, server


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[FastAPI]:
    """The applications that a contract has been made for."""
    found: list[FastAPI] = []

    def contract_of(app: FastAPI) -> tuple[bytes, str]:
        found.append(app)
        return b"{}", "tag"

    monkeypatch.setattr(pages, "_contract", contract_of)
    return found


def test_who_leaves_does_not_end_it_for_the_others(made: list[FastAPI]) -> None:
    async def asked() -> None:
        app = FastAPI()
        app.state.preparing = asyncio.create_task(asyncio.sleep(0.0))
        first, second = (asyncio.create_task(pages.contract(app)) for _ in range(2))
        await asyncio.sleep(0.0)
        first.cancel()
        assert await second == await pages.contract(app) == (b"{}", "tag")
        assert made == [app]

    asyncio.run(asked())


def test_it_is_made_after_the_greeting(
    made: list[FastAPI], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Before, nobody has an address to open; and making it would hold the greeting up."""

    async def checked(_: Any) -> str:
        assert not made
        return "Self-check left out."

    async def started() -> None:
        app = FastAPI()
        app.state.preparing = asyncio.create_task(asyncio.sleep(0.0))
        app.state.parts = MagicMock()
        await server._Server(uvicorn.Config(app), app, "http://127.0.0.1:8000")._greet()
        assert made == [app]

    monkeypatch.setattr(server, "self_check", checked)
    frozen = gc.get_freeze_count()
    try:
        asyncio.run(started())
        assert gc.get_freeze_count() > frozen  # no later collection goes through it
    finally:
        gc.unfreeze()
    assert "http://127.0.0.1:8000/docs" in capsys.readouterr().out
