"""A real browser with no way out: pages note what they tried to reach and what went wrong."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

import pytest

if TYPE_CHECKING:  # imported in the functions: collecting tests does without it
    from playwright.sync_api import Browser, ConsoleMessage, Page, Request, Route

PATIENT = 120_000  # [ms]: the machine may be busy
FLAGS = [
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
]  # fmt: skip


def expect(actual: Any) -> Any:
    from playwright import sync_api

    sync_api.expect.set_options(timeout=PATIENT)
    return sync_api.expect(actual)


class Closed:
    """A page in a closed network; notes what it tried to reach outside and what went wrong."""

    def __init__(self, page: Page) -> None:
        self.page = page
        self.outside: list[str] = []
        self.faults: list[str] = []
        self.refused: list[str] = []  # by the page's own policy
        page.route("**/*", self._gate)
        page.on("requestfailed", self._failed)
        page.on("pageerror", lambda error: self.faults.append(str(error)))
        page.on("console", self._said)

    def _gate(self, route: Route) -> None:
        parts = urlsplit(route.request.url)
        if parts.scheme in ("data", "blob", "file") or parts.hostname == "127.0.0.1":
            route.continue_()
            return
        self.outside.append(route.request.url)
        route.abort()

    def _said(self, message: ConsoleMessage) -> None:
        if "Content Security Policy" in message.text:
            self.refused.append(message.text)

    def _failed(self, request: Request) -> None:
        ended = request.failure == "net::ERR_ABORTED"  # by the page itself, or as it closes
        if urlsplit(request.url).hostname == "127.0.0.1" and not ended:
            self.faults.append(f"{request.url}: {request.failure}")


@pytest.fixture
def closed(browser: Browser) -> Iterator[Closed]:
    context = browser.new_context(viewport={"width": 1280, "height": 1000})
    context.set_default_timeout(PATIENT)
    page = Closed(context.new_page())
    yield page
    context.close()
    assert page.outside == []
    assert page.faults == [], page.faults


def picture(page: Page, folder: Path, name: str) -> None:
    page.screenshot(path=folder / f"{name}.png")
