"""The studio as its user has it: in a browser, with a service behind it and no way out."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

import pytest

from service.contract.examples import examples
from synthesis.pipeline import boundary, conflict
from tests.pipeline.advice.bad_cams import FIRST
from tests.service.browsing import PATIENT, Closed, expect, picture
from tests.service.conftest import Running

if TYPE_CHECKING:
    from playwright.sync_api import Locator, Page

pytestmark = pytest.mark.browser
ROOT = Path(__file__).resolve().parents[3]
SIZED = examples()["p2-sized"]["value"]


@pytest.fixture
def turning(closed: Closed, real_service: Running) -> Page:
    """The page with its first example designed, and turning."""
    closed.page.goto(real_service.url)
    expect(closed.page.locator("#status")).to_have_class("optimal", timeout=PATIENT)
    return closed.page


@pytest.fixture
def studio(closed: Closed, request: pytest.FixtureRequest) -> Page:
    """The same, held: to draw what turns takes most of a processor."""
    closed.page.emulate_media(reduced_motion="reduce")
    page: Page = request.getfixturevalue("turning")
    return page


def size(page: Page, name: str = "base radius") -> float:
    row = page.locator("#sizes dt", has_text=name).first.locator("xpath=following-sibling::dd[1]")
    return float(row.inner_text().split()[0])


def changed(page: Page, name: str, before: float) -> float:
    """The size, once it is another."""
    page.wait_for_function(
        """([name, before]) => {
            const names = [...document.querySelectorAll('#sizes dt')];
            const row = names.find(each => each.textContent === name);
            return row && Math.abs(parseFloat(row.nextElementSibling.textContent) - before) > 1e-3;
        }""",
        arg=[name, before], timeout=PATIENT,
    )  # fmt: skip
    return size(page, name)


def faults(page: Page) -> list[str]:
    return [text for text in page.locator(".error").all_inner_texts() if text]


def choose(select: Locator, value: str) -> None:
    select.select_option(value)


def test_it_designs_the_parabolic_harmonic_cam(
    studio: Page, real_service: Running, tmp_path: Path
) -> None:
    design = real_service.client.post("/v1/designs", json=SIZED).json()
    assert size(studio) == pytest.approx(design["dimensions"]["base_radius_mm"], abs=1e-4)
    assert size(studio, "offset") == pytest.approx(design["dimensions"]["offset_mm"], abs=1e-4)
    rows = studio.locator("#margins tbody tr").all_inner_texts()
    assert any(row.startswith("pressure angle rise") and "30 deg" in row for row in rows)
    expect(studio.locator("#charts canvas").first).to_be_visible()
    assert studio.locator("#charts figure").count() == 6
    studio.locator("#summary summary").click()
    peaks = studio.locator("#peaks tbody tr").all_inner_texts()
    assert peaks[0].split("\t")[:4] == ["velocity, turn", "mm/s", "68.755", "50°"]
    moves = studio.locator("#coefficients tbody tr").all_inner_texts()
    assert moves[0].split("\t") == ["rise 0–100°", "2", "4", "infinite", "8", "16", "infinite"]
    assert moves[1].startswith("reference: modified sine, R-R")
    figures = studio.locator("#body-figures tbody tr").all_inner_texts()
    perimeter = design["geometry"]["flanks"][0]["perimeter_mm"]
    assert any(row.split("\t")[:2] == ["perimeter", f"{perimeter:.3f} mm"] for row in figures)
    picture(studio, tmp_path, "studio")


def test_the_cam_turns_and_can_be_held(turning: Page) -> None:
    studio = turning
    cam, angle = studio.locator('#cam [data-part="cam"]'), studio.locator("#angle")
    first = cam.get_attribute("transform")
    studio.wait_for_function(
        """before =>
            document.querySelector('#cam [data-part=cam]').getAttribute('transform') !== before""",
        arg=first,
        timeout=PATIENT,
    )
    studio.locator("#cam").focus()
    studio.keyboard.press(" ")
    expect(studio.locator("#play")).to_have_text("Play")
    held = float(angle.input_value())
    studio.keyboard.press("Shift+ArrowRight")
    studio.keyboard.press("ArrowLeft")
    assert float(angle.input_value()) == pytest.approx((round(held) + 9.0) % 360.0, abs=0.6)
    angle.fill("50")
    turned = cam.get_attribute("transform")
    assert turned is not None
    assert float(turned.removeprefix("rotate(").removesuffix(")")) % 360.0 == pytest.approx(50.0)
    shown = studio.locator("#charts .now").first.inner_text()
    assert float(shown.replace("\u202f", "")) == pytest.approx(30.0, abs=0.5)  # half of the lift


def test_a_limit_that_is_dragged_takes_the_design_along(studio: Page) -> None:
    before = size(studio)
    slider = studio.get_by_label("rise [°], slider")
    slider.focus()
    for _ in range(12):
        studio.keyboard.press("ArrowRight")
    after = changed(studio, "base radius", before)
    assert after < before
    assert float(studio.locator('[data-pointer="/limits/0/rise_deg"]').input_value()) > 30.0


def test_a_load_and_what_it_does_are_shown(studio: Page) -> None:
    """Its fields come with the schema; forces stand among sizes, their limits among the margins."""
    choose(studio.locator("#example"), "hertz-limited")
    expect(studio.locator("#margins")).to_contain_text("hertz pressure", timeout=PATIENT)
    expect(studio.locator("#margins")).to_contain_text("contact force min")
    assert 650.0 < size(studio, "hertz pressure at most") <= 700.0
    mass = studio.locator('[data-pointer="/load/moving_mass_kg"]')
    assert mass.input_value() == "2"
    before = size(studio, "camshaft torque rms")
    mass.fill("3")
    assert changed(studio, "camshaft torque rms", before) > before


def test_what_is_wrong_is_told_at_its_field(studio: Page) -> None:
    angle = studio.locator('[data-pointer="/program/0/angle_deg"]')
    angle.fill("-5")
    expect(studio.locator("#status")).to_have_class("problem", timeout=PATIENT)
    assert "must be greater than 0 and at most 360. Write 5: it has no sign." in faults(studio)[0]
    assert angle.get_attribute("aria-invalid") == "true"
    angle.fill("90")
    expect(studio.locator("#program-sum")).to_have_text("Angles sum to 350° of 360°.")
    expect(studio.locator('[data-error="/program"]')).to_contain_text("Add 10°", timeout=PATIENT)
    studio.get_by_role("button", name="segment 4: take what is left of 360°").click()
    expect(studio.locator("#status")).to_have_class("optimal", timeout=PATIENT)
    assert faults(studio) == []
    studio.get_by_role("tab", name="JSON").click()
    studio.locator("#json").fill('{"program": [')
    expect(studio.locator("#json-error")).to_contain_text("not JSON yet")
    studio.locator("#json").fill(json.dumps(examples()["flat-face"]["value"]))
    expect(studio.locator("#sizes")).not_to_contain_text("roller", timeout=PATIENT)
    assert faults(studio) == []
    # a cam that keeps its limits and yet cannot work
    studio.locator("#json").fill(json.dumps(FIRST["float"][2]))
    expect(studio.locator("#status")).to_have_class("stop", timeout=PATIENT)
    expect(studio.locator("#status")).to_contain_text("STOP, this cam cannot work. Optimal")
    expect(studio.locator("#warnings li").first).to_contain_text("The follower leaves its cam")


def test_a_conflict_is_mended_by_the_change_that_it_names(studio: Page) -> None:
    choose(studio.locator("#example"), "infeasible-on-purpose")
    expect(studio.locator("#status")).to_have_class("infeasible", timeout=PATIENT)
    expect(studio.locator("#views")).to_be_hidden()
    studio.locator("#conflict").get_by_role("button").first.click()
    expect(studio.locator("#status")).to_have_class("optimal", timeout=PATIENT)
    expect(studio.locator("#views")).to_be_visible()


def test_like_limits_are_changed_together(studio: Page) -> None:
    """One button for both jerk limits."""
    short = examples()["infeasible-on-purpose"]["value"]
    limits = [*short["limits"], {"kind": "jerk", "max_mm_per_s3": 590_000.0}]
    studio.get_by_role("tab", name="JSON").click()
    studio.locator("#json").fill(json.dumps({**short, "limits": limits}))
    expect(studio.locator("#status")).to_have_class("infeasible", timeout=PATIENT)
    changes = studio.locator("#conflict li", has=studio.get_by_role("button"))
    expect(changes).to_have_count(1)
    expect(changes).to_contain_text(re.compile("jerk: 6.*→.* and 5.*→.*proven impossible"))
    changes.get_by_role("button").click()
    expect(studio.locator("#status")).to_have_class("optimal", timeout=PATIENT)
    limits = json.loads(studio.locator("#json").input_value())["limits"]
    assert limits[-2]["max_mm_per_s3"] == limits[-1]["max_mm_per_s3"] > 600_000.0


def test_the_page_knows_the_notes_that_the_core_writes() -> None:
    page = (ROOT / "service/studio/result.js").read_text()
    for name, note in (("TOGETHER", conflict.TOGETHER), ("DEVIATION", boundary.DEVIATION)):
        known = re.search(rf'\b{name} = "([^"]+)"', page)
        assert known is not None
        assert note.startswith(known[1])


def test_two_designs_are_compared(studio: Page) -> None:
    before = size(studio)
    studio.locator("#keep").click()
    studio.locator('[data-pointer="/limits/0/rise_deg"]').fill("36.5")
    after = changed(studio, "base radius", before)
    row = studio.locator("#differences tr", has_text="base radius [mm]").first
    a, b, difference = (cell.inner_text() for cell in row.locator("td").all()[:3])
    assert float(a) == pytest.approx(before, abs=1e-3)
    assert float(b) == pytest.approx(after, abs=1e-3)
    assert float(difference.replace("−", "-")) == pytest.approx(after - before, abs=2e-3)
    expect(studio.locator("#cam .kept")).to_have_count(1)
    studio.locator("#drop").click()
    expect(studio.locator("#cam .kept")).to_have_count(0)


def test_a_sweep_is_run_and_one_of_its_designs_taken(studio: Page, tmp_path: Path) -> None:
    choose(studio.locator("#sweep-axis-1"), "/limits/0/rise_deg")
    for name, value in (("from", "31"), ("to", "47"), ("count", "5")):
        studio.locator(f"#sweep-{name}-1").fill(value)
    choose(studio.locator("#sweep-quantity"), "peak_pressure_angle")
    studio.locator("#sweep-start").click()
    expect(studio.locator("#sweep-message")).to_contain_text("5 of 5 designs", timeout=PATIENT)
    expect(studio.locator("#trade-off .dot")).to_have_count(5)
    expect(studio.locator("#trade-off .front")).to_have_count(1)
    studio.locator("#trade-off").scroll_into_view_if_needed()
    picture(studio, tmp_path, "sweep")
    wanted = studio.locator("#trade-off .dot", has_text="rise [°] 43").first
    wanted.focus()
    studio.keyboard.press("Enter")
    limit = studio.locator('[data-pointer="/limits/0/rise_deg"]')
    expect(limit).to_have_value("43")
    expect(studio.locator("#margins")).to_contain_text("43 deg", timeout=PATIENT)


def test_files_come_down_and_refusals_are_told(studio: Page) -> None:
    choose(studio.locator("#file-name"), "profile.txt")
    studio.locator("#option-points_per_degree").fill("2")
    with studio.expect_download() as taken:
        studio.locator("#file-link").click()
    lines = Path(taken.value.path()).read_text(encoding="utf-8").splitlines()
    assert len(lines) >= 720
    assert all(len(line.split()) == 3 for line in lines)
    studio.locator("#option-points_per_degree").fill("-3")
    studio.locator("#file-link").click()
    expect(studio.locator("#file-error")).to_contain_text("greater than 0", timeout=PATIENT)


def test_a_call_copied_as_curl_does_the_same(studio: Page, real_service: Running) -> None:
    calls = studio.locator("#call-list li", has_text="POST")
    calls.first.locator("summary").click()
    command = calls.first.locator("pre").inner_text()
    answer = subprocess.run(
        ["bash", "-c", command], capture_output=True, check=True, text=True, timeout=60
    )
    design = json.loads(answer.stdout)
    assert design["id"] in studio.locator("#call-list").inner_text()
    assert design["status"] == "optimal"


def test_the_address_carries_the_spec(studio: Page, real_service: Running) -> None:
    before = size(studio)
    studio.locator('[data-pointer="/follower/roller_radius_mm"]').fill("12.5")
    changed(studio, "roller radius", 10.0)
    address = studio.url
    assert urlsplit(address).fragment.startswith("spec=")
    studio.goto("about:blank")
    studio.goto(address)
    expect(studio.locator("#sizes")).to_contain_text("12.5 mm", timeout=PATIENT)
    assert size(studio) < before


def test_by_keyboard_alone(studio: Page) -> None:
    """Tab reaches the slider of the first limit; what has the focus is seen to have it."""
    studio.locator(".skip").focus()
    for _ in range(80):
        studio.keyboard.press("Tab")
        label = studio.evaluate("document.activeElement.getAttribute('aria-label')")
        if label == "rise [°], slider":
            break
    else:
        pytest.fail("the slider was not reached")
    outline = studio.evaluate("getComputedStyle(document.activeElement).outlineStyle")
    assert outline == "solid"
    before = size(studio)
    studio.keyboard.press("PageUp")
    assert changed(studio, "base radius", before) < before


def test_every_input_has_a_name(studio: Page) -> None:
    choose(studio.locator("#example"), "windows-and-points")
    expect(studio.locator("#form-program tbody tr").first).to_be_visible()
    nameless = studio.evaluate(
        """() => [...document.querySelectorAll('input, select, textarea, button, a, meter')]
            .filter(e => !(e.labels?.length || e.getAttribute('aria-label') || e.textContent.trim()
                           || e.title))
            .map(e => e.outerHTML)"""
    )
    assert nameless == []


def test_it_fits_a_phone(closed: Closed, real_service: Running, tmp_path: Path) -> None:
    page = closed.page
    page.set_viewport_size({"width": 375, "height": 740})
    page.emulate_media(reduced_motion="reduce")
    page.goto(real_service.url)
    expect(page.locator("#status")).to_have_class("optimal", timeout=PATIENT)
    for scheme in ("light", "dark"):
        page.emulate_media(color_scheme=scheme)
        assert page.evaluate("document.documentElement.scrollWidth") <= 375
        picture(page, tmp_path, f"phone-{scheme}")
