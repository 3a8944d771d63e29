"""The studio's page of linkages: a shaper slid and sized, an arm whose target is dragged."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from service.contract.examples import examples
from tests.service.browsing import PATIENT, Closed, expect, picture
from tests.service.conftest import Running

if TYPE_CHECKING:
    from playwright.sync_api import Page

pytestmark = pytest.mark.browser
SHAPERS, ARMS = "six-bar-shapers", "palletising-arms"
DRAWN = {SHAPERS: "#centres tbody tr", ARMS: "#side .way"}  # once all is shown


def opened(closed: Closed, service: Running, kind: str) -> Page:
    """The page with the first example of a kind answered, held."""
    closed.page.emulate_media(reduced_motion="reduce")
    closed.page.goto(f"{service.url}/linkages#kind={kind}")
    expect(closed.page.locator("#status")).to_have_class("feasible", timeout=PATIENT)
    expect(closed.page.locator(DRAWN[kind])).not_to_have_count(0, timeout=PATIENT)
    return closed.page


def figure(page: Page, name: str, where: str = "#sizes") -> float:
    term = page.locator(f"{where} dt", has_text=name).first
    text = term.locator("xpath=following-sibling::dd[1]").inner_text()
    return float(text.split(" ")[0].replace("\u202f", "").replace("\u2212", "-"))


def faults(page: Page) -> list[str]:
    return [text for text in page.locator(".error").all_inner_texts() if text]


def test_a_shaper_turns_and_follows_its_sliders(
    closed: Closed, real_service: Running, tmp_path: Path
) -> None:
    page = opened(closed, real_service, SHAPERS)
    assert figure(page, "stroke") == pytest.approx(2.0 * 600.0 * 125.0 / 275.0, abs=1e-3)
    expect(page.locator("#charts figure")).to_have_count(4)
    expect(page.locator("#centres tbody tr")).to_have_count(2)
    page.locator("#angle").fill("90")
    guide = page.locator('#cam [data-part="guide"]').get_attribute("transform")
    assert guide is not None
    assert float(guide.removeprefix("rotate(").removesuffix(")")) == pytest.approx(90.0, abs=1e-3)
    ram = page.locator("#charts .now").first.inner_text().replace("\u2212", "-")
    assert float(ram) == pytest.approx(-math.sqrt(150.0**2 - 25.0**2), abs=0.01)
    picture(page, tmp_path, "shaper")
    page.get_by_label("crank [mm], value, slider").focus()
    page.keyboard.press("PageUp")
    longer = float(page.locator("#field-crank_mm-value").input_value())
    assert longer > 125.0
    expect(page.locator("#sizes")).to_contain_text(f"{longer:g} mm", timeout=PATIENT)
    assert figure(page, "stroke") == pytest.approx(2.0 * 600.0 * longer / 275.0, rel=1e-5)


def test_its_rams_motion_becomes_a_cam(closed: Closed, real_service: Running) -> None:
    page = opened(closed, real_service, SHAPERS)
    before = page.url
    page.locator("#to-cam").click()
    expect(page.locator("#status")).to_have_class("optimal", timeout=PATIENT)
    assert page.locator('[data-pointer="/name"]').input_value() == "shaper: motion of the ram"
    page.go_back()
    expect(page.locator("#sizes")).to_contain_text("545.455 mm", timeout=PATIENT)
    assert page.url == before
    page.locator("#example").select_option("turning-guide")
    expect(page.locator("#to-cam")).to_be_disabled(timeout=PATIENT)


def test_a_shaper_is_sized_and_what_is_in_the_way_is_told(
    closed: Closed, real_service: Running
) -> None:
    page = opened(closed, real_service, SHAPERS)
    crank = page.locator("#field-crank_mm-value")
    crank.fill("275")
    expect(page.locator("#status")).to_have_class("problem", timeout=PATIENT)
    assert len(faults(page)) == 1
    assert "passes through the guide's pivot" in faults(page)[0]
    crank.fill("120")
    expect(page.locator("#status")).to_have_class("feasible", timeout=PATIENT)
    assert faults(page) == []
    page.get_by_role("button", name="Leave every length free").click()
    expect(page.locator("#status")).to_have_class("optimal", timeout=PATIENT)
    assert figure(page, "stroke") == pytest.approx(2.0 * 600.0 * 120.0 / 275.0, rel=1e-5)
    page.get_by_role("button", name="Take the lengths that came out").click()
    expect(page.locator("#status")).to_have_class("feasible", timeout=PATIENT)
    assert float(crank.input_value()) == pytest.approx(figure(page, "crank"), rel=1e-5)
    page.locator("#example").select_option("impossible-on-purpose")
    expect(page.locator("#status")).to_have_class("infeasible", timeout=PATIENT)
    expect(page.locator("#shaper")).to_be_hidden()
    page.get_by_role("button", name="apply coupler 83.4").click()
    expect(page.locator("#status")).to_have_class("optimal", timeout=PATIENT)
    assert figure(page, "least transmission angle") >= 70.0 - 1e-3


def test_an_arms_target_is_dragged(closed: Closed, real_service: Running, tmp_path: Path) -> None:
    """By pointer and by keys; what it takes to be there is what the service says."""
    page = opened(closed, real_service, ARMS)
    page.locator("#side .target .reach").scroll_into_view_if_needed()  # and until it stands still
    handle = page.locator("#side .target .reach").bounding_box()
    assert handle is not None
    x, y = handle["x"] + handle["width"] / 2.0, handle["y"] + handle["height"] / 2.0
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x - 60.0, y - 40.0, steps=6)
    page.mouse.up()
    page.locator("#side").press("Shift+ArrowUp")
    expect(page.locator("#target")).not_to_contain_text("700 mm", timeout=PATIENT)
    page.locator('[data-pointer="/poses/1/z_mm"]').fill("900")
    expect(page.locator("#target")).to_contain_text("900 mm", timeout=PATIENT)
    there = {name: figure(page, name, "#target") for name in ("x", "y", "z")}
    assert math.hypot(there["x"], there["y"]) < 2450.0
    assert there["y"] / there["x"] == pytest.approx(-7.0 / 24.0, rel=1e-4)  # in the same plane
    pose = {"kind": "point", **{f"{name}_mm": value for name, value in there.items()}}
    body = examples(f"linkages/{ARMS}")["irb-660"]["value"] | {"poses": [pose]}
    answer = real_service.client.post(f"/v1/linkages/{ARMS}", json=body).json()
    ways = answer["poses"][0]["solutions"]
    best = ways[0]
    other = next(way for way in ways if (way["base"], way["elbow"]) == ("front", "down"))
    rows = page.locator("#ways tbody tr")
    expect(rows).to_have_count(len(ways))
    shown = rows.first.locator("td").nth(3).inner_text().removesuffix("°")
    assert float(shown) == pytest.approx(best["upper_arm_deg"], abs=0.01)
    arm = page.locator("#side .way:not(.ghost) [data-part=upper]")
    assert _turn(arm.get_attribute("transform")) == pytest.approx(90.0 - float(shown), abs=0.01)
    page.get_by_label("show front down").press(" ")
    assert _turn(arm.get_attribute("transform")) == pytest.approx(
        90.0 - other["upper_arm_deg"], abs=0.02
    )
    picture(page, tmp_path, "arm")


def _turn(transform: str | None) -> float:
    assert transform is not None
    return float(transform.removeprefix("rotate(").removesuffix(")"))


def test_out_of_reach_and_out_of_sense(closed: Closed, real_service: Running) -> None:
    page = opened(closed, real_service, ARMS)
    page.locator('[data-pointer="/poses/1/x_mm"]').fill("4000")
    expect(page.locator("#status")).to_have_class("infeasible", timeout=PATIENT)
    expect(page.locator("#pose-note")).to_contain_text("mm nearer")
    expect(page.locator("#side .way")).to_have_count(0)
    page.locator('[data-pointer="/poses/1/x_mm"]').fill("2000")
    expect(page.locator("#side .way")).to_have_count(2, timeout=PATIENT)
    expect(page.locator("#singular")).to_contain_text("Nowhere")
    page.locator('[data-pointer="/opening_deg/max"]').fill("130")
    expect(page.locator("#singular")).to_contain_text("90°", timeout=PATIENT)
    expect(page.locator("#side .limit")).to_have_count(1)
    page.locator('[data-pointer="/forearm_deg/min"]').fill("150")
    expect(page.locator('[data-error="/forearm_deg"]')).to_contain_text("Exchange the two")
    page.locator("#pose").select_option("0")
    expect(page.locator("#form")).to_contain_text("upper arm [°]")


@pytest.mark.parametrize(("kind", "scheme"), [(SHAPERS, "dark"), (ARMS, "light")])
def test_it_fits_a_phone(
    closed: Closed, real_service: Running, tmp_path: Path, kind: str, scheme: str
) -> None:
    closed.page.set_viewport_size({"width": 375, "height": 740})
    closed.page.emulate_media(color_scheme=scheme)
    page = opened(closed, real_service, kind)
    assert page.evaluate("document.documentElement.scrollWidth") <= 375
    nameless = page.evaluate(
        """() => [...document.querySelectorAll('input, select, textarea, button, a, svg[tabindex]')]
            .filter(e => !(e.labels?.length || e.getAttribute('aria-label') || e.textContent.trim()
                           || e.title))
            .map(e => e.outerHTML)"""
    )
    assert nameless == []
    picture(page, tmp_path, f"phone-{kind}")


def test_each_page_is_whole_and_leads_to_the_others(real_service: Running) -> None:
    pages = ("/", "/spatial", "/linkages")
    for page in pages:
        text = real_service.client.get(page).text
        assert [f'href="{other}"' in text for other in pages] == [other != page for other in pages]
        once = ("</html>", 'id="call-list"', 'id="files"', 'name="viewport"', 'href="/redoc"')
        assert [text.count(part) for part in (*once, "include:")] == [1, 1, 1, 1, 1, 0]
