"""Pictures of the studio in a running service: ``python docs/images/studio.py [URL]``."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from playwright.sync_api import expect, sync_playwright

HERE = Path(__file__).parent
ANGLE, SPATIAL_ANGLE = "58", "219"  # cam angles that are shown [deg]


def main(url: str = "http://127.0.0.1:8000") -> None:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"),
            args=["--no-sandbox", "--use-gl=swiftshader", "--enable-unsafe-swiftshader"],
        )
        page = browser.new_page(viewport={"width": 1440, "height": 1000}, color_scheme="light")
        page.goto(url)
        expect(page.locator("#status")).to_have_class("optimal", timeout=60_000)
        page.locator("#keep").click()
        page.locator('[data-pointer="/limits/0/rise_deg"]').fill("36")
        expect(page.locator("#margins")).to_contain_text("36 deg", timeout=60_000)
        page.locator("#angle").fill(ANGLE)
        page.evaluate("window.scrollTo(0, 0)")
        page.screenshot(path=HERE / "studio.png")
        page.goto(f"{url}/spatial")
        expect(page.get_by_text("Feasible")).to_be_visible(timeout=60_000)
        page.wait_for_load_state("networkidle")
        page.get_by_role("button", name="Pause").click()
        page.get_by_role("slider", name="cam angle").fill(SPATIAL_ANGLE)
        page.locator("canvas").screenshot(path=HERE / "spatial.png")
        page.goto(f"{url}/linkages#kind=palletising-arms")
        expect(page.locator("#side .way").first).to_be_visible(timeout=60_000)
        page.wait_for_load_state("networkidle")
        page.locator("#answer .seen").last.screenshot(path=HERE / "linkages.png")
        browser.close()


if __name__ == "__main__":
    main(*sys.argv[1:])
