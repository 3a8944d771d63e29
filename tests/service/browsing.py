"""A real browser with no way out: pages note what they tried to reach and what went wrong."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

if TYPE_CHECKING:  # imported in the functions: collecting tests does without it
    from playwright.sync_api import ConsoleMessage, Page, Request

PATIENT = 120_000  # [ms]: the machine may be busy
FLAGS = [
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
]  # fmt: skip


def expect(actual: Any) -> Any:
    from playwright import sync_api

    sync_api.expect.set_options(timeout=PATIENT)
    return sync_api.expect(actual)


class Closed:
    """A page in a closed network; notes what it tried to reach outside and what went wrong.

    One page serves test after test: a second visit takes a third of the first one's processor
    time. What a test sets of it is set back before the next one.
    """

    def __init__(self, page: Page) -> None:
        page.context.set_default_timeout(PATIENT)
        self.page = page
        self.outside: list[str] = []
        self.faults: list[str] = []
        self.refused: list[str] = []  # by the page's own policy
        page.on("request", self._asked)
        page.on("requestfailed", self._failed)
        page.on("pageerror", lambda error: self.faults.append(str(error)))
        page.on("console", self._said)

    def leave(self) -> None:
        """Leave what is shown, and set back what a test may have set."""
        self.page.unroute_all()
        self.page.goto("about:blank")
        self.page.set_viewport_size({"width": 1280, "height": 1000})
        self.page.emulate_media(media="null", color_scheme="null", reduced_motion="null")

    def forget(self) -> None:
        """Forget what earlier tests have noted."""
        for noted in (self.outside, self.faults, self.refused):
            noted.clear()

    def _asked(self, request: Request) -> None:
        parts = urlsplit(request.url)
        if parts.scheme not in ("data", "blob", "file") and parts.hostname != "127.0.0.1":
            self.outside.append(request.url)

    def _said(self, message: ConsoleMessage) -> None:
        if "Content Security Policy" in message.text:
            self.refused.append(message.text)

    def _failed(self, request: Request) -> None:
        if request.failure == "csp":  # the page's own policy has not let it go
            self.outside.remove(request.url)
            return
        ended = request.failure == "net::ERR_ABORTED"  # by the page itself, or as it closes
        if urlsplit(request.url).hostname == "127.0.0.1" and not ended:
            self.faults.append(f"{request.url}: {request.failure}")


def picture(page: Page, folder: Path, name: str) -> None:
    page.screenshot(path=folder / f"{name}.png")
