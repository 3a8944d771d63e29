"""Swagger UI and ReDoc in a real browser with no way out: every asset comes from the service."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from service.contract.examples import SELF_CHECK, VARIANTS, examples
from service.openapi import TARGET
from tests.service.browsing import Closed, expect, picture
from tests.service.conftest import Running

pytestmark = pytest.mark.browser


def document(*paths: str) -> dict[str, Any]:
    """The API's document with these paths only: to draw all of it takes a browser ten seconds."""
    document: dict[str, Any] = json.loads(TARGET.read_text(encoding="utf-8"))
    return document | {"paths": {path: document["paths"][path] for path in paths}}


def test_swagger_sends_a_worked_example_and_downloads_a_file(
    closed: Closed, real_service: Running, tmp_path: Path
) -> None:
    page, served = closed.page, document("/v1/designs", "/v1/designs/{design_id}/profile.csv")
    page.route("**/openapi.json", lambda route: route.fulfill(json=served))
    page.goto(f"{real_service.url}/docs")
    operation = page.locator("#operations-designs-create_design")
    expect(operation).to_be_visible()
    # operations of other tags are drawn when these open
    assert page.locator("#operations-files-get_profile_csv").count() == 0
    picture(page, tmp_path, "operations")
    operation.locator(".opblock-summary-control").click()
    menu = operation.locator(".examples-select-element").first
    shown = menu.locator("option").all_inner_texts()
    listed = {name: each for name, each in examples().items() if name not in VARIANTS}
    assert {example["summary"] for example in listed.values()} <= set(shown)
    menu.select_option(SELF_CHECK)
    expect(operation.locator("textarea.body-param__text")).to_have_value(re.compile("example 13-6"))
    operation.locator("button.execute").click()
    answer = operation.locator(".live-responses-table .response").first
    expect(answer.locator(".response-col_status")).to_contain_text("200")
    expect(answer).to_contain_text("base_radius_mm")
    operation.get_by_role("tab", name="Schema").first.click()
    expect(operation.locator(".model-example").first).to_contain_text("time_budget_s")
    assert closed.refused == []
    answer.scroll_into_view_if_needed()
    picture(page, tmp_path, "executed")
    operation.locator(".opblock-summary-control").click()
    spec = examples()[SELF_CHECK]["value"]
    design = real_service.client.post("/v1/designs", json=spec).json()
    page.locator("#operations-tag-files").click()
    operation = page.locator("#operations-files-get_profile_csv")
    operation.locator(".opblock-summary-control").click()
    operation.get_by_placeholder("design_id").fill(design["id"])
    operation.get_by_placeholder("points_per_degree").fill("1")
    operation.locator("button.execute").click()
    link = operation.get_by_role("link", name="Download file")
    with page.expect_download() as taken:
        link.click()
    picture(page, tmp_path, "downloaded")
    rows = Path(taken.value.path()).read_text(encoding="utf-8").splitlines()
    assert rows == real_service.client.get(
        f"/v1/designs/{design['id']}/profile.csv?points_per_degree=1"
    ).text.splitlines()  # fmt: skip
    assert len(rows) > 360
    # of schemas, too, what is opened is shown whole
    page.locator("section.models button").first.click()
    schema = page.locator("section.models .json-schema-2020-12", has_text="Accepted").first
    schema.locator(".json-schema-2020-12-accordion").first.click()
    expect(schema).to_contain_text(
        next(iter(served["components"]["schemas"]["Accepted"]["properties"]))
    )


def test_swagger_asks_for_the_contract_once_and_follows_a_link_to_any_operation(
    closed: Closed, real_service: Running
) -> None:
    page, asked = closed.page, []
    page.on("request", lambda request: asked.append(request.url))
    # its tag is none of those that are drawn first
    page.goto(f"{real_service.url}/docs#/files/get_profile_csv")
    operation = page.locator("#operations-files-get_profile_csv")
    expect(operation.locator("button.execute")).to_be_visible()
    expect(page.locator("#operations-designs-create_design")).to_be_visible()
    assert asked.count(f"{real_service.url}/openapi.json") == 1
    # what comes after the first operations comes below them
    tags = page.locator(".opblock-tag").evaluate_all("each => each.map(tag => tag.dataset.tag)")
    assert tags[0] == "designs"
    assert tags == [tag["name"] for tag in document()["tags"]]


def test_swagger_says_that_the_contract_is_not_to_be_had(
    closed: Closed, real_service: Running
) -> None:
    page = closed.page
    page.route("**/openapi.json", lambda route: route.fulfill(status=503, body="no"))
    page.goto(f"{real_service.url}/docs")
    expect(page.locator("body")).to_contain_text("Failed to load API definition")


def test_redoc_shows_the_reference(closed: Closed, real_service: Running, tmp_path: Path) -> None:
    page = closed.page
    page.route("**/openapi.json", lambda route: route.fulfill(json=document("/v1/designs")))
    page.goto(f"{real_service.url}/redoc")
    expect(page.get_by_role("heading", name="Synthesise a cam")).to_be_visible()
    expect(page.locator("body")).to_contain_text("base_radius_mm")
    picture(page, tmp_path, "redoc")
