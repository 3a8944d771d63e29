"""One browser, and one page of it, for all tests of this folder."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from tests.service.browsing import FLAGS, Closed

HERE = Path(__file__).parent
opened: list[Closed] = []
running = ExitStack()


@pytest.fixture
def closed() -> Iterator[Closed]:
    """The page. The first test that asks for it launches the browser."""
    if not opened:
        from playwright.sync_api import sync_playwright

        chromium = shutil.which("chromium") or shutil.which("chromium-browser")
        if chromium is None:
            pytest.fail("Chromium is missing: `apt-get install chromium` (.ci/run does).")
        playwright = running.enter_context(sync_playwright())
        browser = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        running.callback(browser.close)
        opened.append(Closed(browser.new_page()))
        opened[0].leave()
    page = opened[0]
    page.forget()
    yield page
    page.leave()
    assert page.outside == []
    assert page.faults == [], page.faults


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> None:
    """Close it after the last test of the folder: its event loop would be in others' way."""
    if nextitem is None or HERE not in nextitem.path.parents:
        running.close()
        opened.clear()
