"""One browser for all tests of this folder."""

from __future__ import annotations

import shutil
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tests.service.browsing import FLAGS, closed

if TYPE_CHECKING:  # imported in the functions: collecting tests does without it
    from playwright.sync_api import Browser

__all__ = ["closed"]

HERE = Path(__file__).parent
launched: list[Browser] = []
running = ExitStack()


@pytest.fixture
def browser() -> Browser:
    """Launched by the first test that asks for it."""
    if not launched:
        from playwright.sync_api import sync_playwright

        chromium = shutil.which("chromium") or shutil.which("chromium-browser")
        if chromium is None:
            pytest.fail("Chromium is missing: `apt-get install chromium` (.ci/run does).")
        playwright = running.enter_context(sync_playwright())
        launched.append(playwright.chromium.launch(executable_path=chromium, args=FLAGS))
        running.callback(launched[0].close)
    return launched[0]


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> None:
    """Close it after the last test of the folder: its event loop would be in others' way."""
    if nextitem is None or HERE not in nextitem.path.parents:
        running.close()
        launched.clear()
