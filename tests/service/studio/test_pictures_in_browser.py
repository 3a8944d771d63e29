"""Animation and report in a real browser: it moves, the keys work, it prints; also from a file."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from service.contract.examples import examples
from tests.service.browsing import Closed, expect, picture
from tests.service.conftest import Running

if TYPE_CHECKING:
    from playwright.sync_api import Page

pytestmark = pytest.mark.browser
KIND = "conjugate-arms"


@pytest.fixture(scope="module")
def design(real_service: Running) -> dict[str, Any]:
    """Two rollers on arms: every kind of part moves."""
    body = examples()[KIND]["value"] | {"name": "<b>lever</b>", "tolerance": 0.2}
    answer = real_service.client.post("/v1/designs", json=body).json()
    assert {"animation.html", "animation.svg", "report.html"} <= set(answer["links"])
    return answer


def standing(page: Page) -> list[str]:
    """Where all the parts are."""
    found = page.locator("[data-part]").evaluate_all(
        "all => all.map(e => e.getAttribute('transform'))"
    )
    return [str(each) for each in found]


def angle(page: Page) -> float:
    return float(page.locator("#theta").inner_text().replace("\u2212", "-"))


@pytest.mark.parametrize("from_file", [False, True])
def test_the_animation_runs_and_the_keys_work(
    closed: Closed, real_service: Running, design: dict, tmp_path: Path, from_file: bool
) -> None:
    page, address = closed.page, f"{real_service.url}{design['links']['animation.html']}"
    if from_file:
        file = tmp_path / "animation.html"
        file.write_bytes(real_service.client.get(design["links"]["animation.html"]).content)
        address = file.as_uri()
    page.goto(address)
    expect(page.get_by_role("heading")).to_have_text("<b>lever</b>")
    before = standing(page)
    page.wait_for_function("was => document.querySelector('#theta').textContent != was",
                           arg=page.locator("#theta").inner_text())  # fmt: skip
    page.keyboard.press(" ")
    expect(page.locator("#play")).to_have_text("Play")
    after = standing(page)
    assert sum(a != b for a, b in zip(before, after, strict=True)) >= 8
    assert standing(page) == after
    page.keyboard.press("Home")
    assert angle(page) == 0.0
    first = standing(page)
    for key, want in (("ArrowRight", 1.0), ("Shift+ArrowRight", 11.0), ("ArrowLeft", 10.0)):
        page.keyboard.press(key)
        assert angle(page) == want
    assert standing(page) != first
    page.locator("#angle").fill("123")
    assert angle(page) == 123.0
    for _ in range(24):
        page.keyboard.press("Shift+ArrowRight")
    assert angle(page) == 3.0  # round once
    speed = page.locator("#speed")
    was = float(speed.input_value())
    page.keyboard.press("+")
    assert float(speed.input_value()) == was + 2.0
    expect(page.locator("#shown")).to_have_text(f"{was + 2:g}")
    page.locator("#play").focus()
    page.keyboard.press(" ")
    expect(page.locator("#play")).to_have_text("Pause")
    picture(page, tmp_path, "animation")
    assert closed.refused == []


def test_whoever_wants_less_motion_gets_it(
    closed: Closed, real_service: Running, design: dict
) -> None:
    page = closed.page
    for wish, plays in (("reduce", False), ("no-preference", True)):
        page.emulate_media(reduced_motion=wish)
        page.goto(f"{real_service.url}{design['links']['animation.html']}")
        expect(page.locator("#play")).to_have_text("Pause" if plays else "Play")
        page.goto(f"{real_service.url}{design['links']['animation.svg']}")
        running = page.evaluate("document.getAnimations().length")
        assert (running >= 8) == plays
        assert (running == 0) != plays


def test_the_drawing_moves_by_itself(closed: Closed, real_service: Running, design: dict) -> None:
    page = closed.page
    page.goto(f"{real_service.url}{design['links']['animation.svg']}")
    cam = f".cw{design['id'][:8]}-cam"
    reported = f"getComputedStyle(document.querySelector('{cam}')).transform"
    was = page.evaluate(reported)
    page.wait_for_function(f"was => {reported} != was", arg=was)
    closed.page.evaluate(
        "document.getAnimations().forEach(a => { a.pause(); a.currentTime = 2000 })"
    )
    turned = [float(n) for n in re.findall(r"-?[\d.e-]+", page.evaluate(reported))]
    assert turned[:2] == pytest.approx([0.0, 1.0], abs=1e-6)  # a quarter of 8 s, ccw with y upwards


def test_the_report_prints(closed: Closed, real_service: Running, design: dict) -> None:
    page = closed.page
    page.goto(f"{real_service.url}{design['links']['report.html']}")
    expect(page.get_by_role("heading", level=1)).to_have_text("<b>lever</b>")
    sizes = page.locator("img").evaluate_all("all => all.map(e => [e.naturalWidth, e.complete])")
    assert len(sizes) == 3
    assert all(width > 300 and complete for width, complete in sizes)
    for paper, width, height in (("A4", 595, 842), ("Letter", 612, 792)):
        content = page.pdf(format=paper)
        boxes = re.findall(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", content)
        assert 4 <= len(boxes) <= 9
        assert all(abs(float(w) - width) < 1.5 and abs(float(h) - height) < 1.5 for w, h in boxes)
