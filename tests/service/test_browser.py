"""Swagger UI and ReDoc in a real browser with no way out: every asset comes from the service."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from playwright.sync_api import expect

from service.examples import SELF_CHECK, examples
from tests.service.browsing import Closed, picture
from tests.service.conftest import Running

pytestmark = pytest.mark.browser


def test_swagger_sends_a_worked_example(
    closed: Closed, real_service: Running, tmp_path: Path
) -> None:
    page = closed.page
    page.goto(f"{real_service.url}/docs")
    operation = page.locator("#operations-designs-create_design")
    expect(operation).to_be_visible()
    assert page.locator(".opblock").count() >= 15
    picture(page, tmp_path, "operations")
    operation.locator(".opblock-summary-control").click()
    menu = operation.locator(".examples-select-element").first
    shown = menu.locator("option").all_inner_texts()
    assert {example["summary"] for example in examples().values()} <= set(shown)
    menu.select_option(SELF_CHECK)
    expect(operation.locator("textarea.body-param__text")).to_have_value(re.compile("example 13-6"))
    operation.locator("button.execute").click()
    answer = operation.locator(".live-responses-table .response").first
    expect(answer.locator(".response-col_status")).to_contain_text("200")
    expect(answer).to_contain_text("base_radius_mm")
    answer.scroll_into_view_if_needed()
    picture(page, tmp_path, "executed")


def test_redoc_shows_the_reference(closed: Closed, real_service: Running, tmp_path: Path) -> None:
    page = closed.page
    page.goto(f"{real_service.url}/redoc")
    expect(page.get_by_role("heading", name="Synthesise a cam")).to_be_visible(timeout=20_000)
    expect(page.locator("body")).to_contain_text("base_radius_mm")
    picture(page, tmp_path, "redoc")


def test_the_start_page_leads_everywhere(
    closed: Closed, real_service: Running, tmp_path: Path
) -> None:
    page = closed.page
    page.goto(real_service.url)
    expect(page.get_by_role("heading", name="Camwright")).to_be_visible()
    picture(page, tmp_path, "start")
    paths = [link.get_attribute("href") for link in page.locator("a").all()]
    assert {"/docs", "/redoc"} <= set(paths)
    for path in paths:
        assert path is not None
        assert real_service.client.get(path).status_code == 200, path
