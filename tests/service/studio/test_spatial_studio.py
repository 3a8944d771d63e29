"""The studio's page of spatial cams: the picture is drawn by a real browser, and looked at."""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from tests.service.browsing import PATIENT, Closed, expect, picture
from tests.service.conftest import Running

if TYPE_CHECKING:
    from playwright.sync_api import Page

pytestmark = pytest.mark.browser


@pytest.fixture
def studio(closed: Closed, real_service: Running) -> Page:
    """The page with the roller gear cam drawn, held."""
    closed.page.emulate_media(reduced_motion="reduce")
    closed.page.goto(f"{real_service.url}/spatial")
    expect(closed.page.locator("#status")).to_have_class("feasible", timeout=PATIENT)
    expect(closed.page.locator("#call-list")).to_contain_text("surfaces.json", timeout=PATIENT)
    return closed.page


def seen(page: Page) -> NDArray[np.int64]:
    """The picture as it is shown: (height, width, 3)."""
    shot = page.locator("#scene").screenshot()
    return np.asarray(Image.open(io.BytesIO(shot)).convert("RGB")).astype(np.int64)


def test_the_cam_is_drawn_and_turns_and_can_be_looked_at_from_elsewhere(
    studio: Page, tmp_path: Path
) -> None:
    expect(studio.locator("#play")).to_have_text("Play")  # motion is not wanted
    expect(studio.locator("#no-picture")).to_be_hidden()
    first = seen(studio)
    ground = np.all(first == first[12, 12], axis=-1)
    assert 0.1 < 1.0 - ground.mean() < 0.8
    assert len(np.unique(first[~ground], axis=0)) > 50  # shaded, not flat
    picture(studio, tmp_path, "spatial")
    studio.locator("#angle").fill("60")
    turned = seen(studio)
    assert np.mean(np.any(np.abs(first - turned) > 12, axis=-1)) > 0.02
    studio.locator("#angle").fill("0")
    assert np.mean(np.any(np.abs(first - seen(studio)) > 12, axis=-1)) < 0.002
    box = studio.locator("#scene").bounding_box()
    assert box is not None
    studio.mouse.move(box["x"] + 200, box["y"] + 200)
    studio.mouse.down()
    studio.mouse.move(box["x"] + 300, box["y"] + 150, steps=4)
    studio.mouse.up()
    assert np.mean(np.any(np.abs(first - seen(studio)) > 12, axis=-1)) > 0.05


def test_a_wrong_size_is_told_at_its_field_and_files_are_offered(studio: Page) -> None:
    rows = studio.locator("#margins tbody tr").all_inner_texts()
    assert any(row.startswith("pressure angle") and "ρ = " in row for row in rows)
    files = studio.locator("#file-name option").all_inner_texts()
    assert any(text.startswith("body.stl") for text in files)
    with studio.expect_download() as taken:
        studio.locator("#file-name").select_option("flanks.csv")
        studio.locator("#option-points").fill("5")
        studio.locator("#file-link").click()
    head = Path(taken.value.path()).read_text(encoding="utf-8").splitlines()[0]
    assert head.startswith("roller,side,theta_deg")
    studio.locator('[data-pointer="/machine/rollers"]').fill("5")
    expect(studio.locator("#status")).to_have_class("problem", timeout=PATIENT)
    expect(studio.locator('[data-error="/program"]')).to_contain_text("between two of 5")
    studio.locator('[data-pointer="/machine/rollers"]').fill("6")
    expect(studio.locator("#status")).to_have_class("feasible", timeout=PATIENT)


def test_it_fits_a_phone(studio: Page, tmp_path: Path) -> None:
    studio.set_viewport_size({"width": 375, "height": 740})
    assert studio.evaluate("document.documentElement.scrollWidth") <= 375
    nameless = studio.evaluate(
        """() => [...document.querySelectorAll('input, select, textarea, button, a')]
            .filter(e => !(e.labels?.length || e.getAttribute('aria-label') || e.textContent.trim()
                           || e.title))
            .map(e => e.outerHTML)"""
    )
    assert nameless == []
    picture(studio, tmp_path, "phone")
