"""A key entered in the studio and in Swagger UI goes along with what they ask."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import pytest

from service.openapi import TARGET
from tests.service.browsing import PATIENT, Closed, expect
from tests.service.conftest import Running

if TYPE_CHECKING:
    from playwright.sync_api import Route

pytestmark = pytest.mark.browser


def test_the_studio_asks_for_a_key_once_and_keeps_it_from_scripts(
    closed: Closed, real_service: Running
) -> None:
    """The service here needs none: until one is entered it is refused on its behalf."""
    text = real_service.new_key("she who asks in the studio")
    page = closed.page

    def refuse_without(route: Route) -> None:
        if "camwright-key=" in route.request.all_headers().get("cookie", ""):
            route.continue_()
        else:
            route.fulfill(status=401, json={"title": "A key is needed", "status": 401})

    page.emulate_media(reduced_motion="reduce")
    page.route("**/v1/**", refuse_without)
    page.goto(real_service.url)
    dialog = page.locator("#key-dialog")
    for entered, words in (("wrong", "not one of this service's"), ("\u20ac", "is it complete")):
        dialog.get_by_label("Your key").fill(entered)
        dialog.get_by_role("button", name="Use it").click()
        expect(dialog.get_by_role("alert")).to_contain_text(words)
    with page.expect_response("**/v1/designs") as designed:
        dialog.get_by_label("Your key").fill(text)
        dialog.get_by_role("button", name="Use it").click()
    expect(page.locator("#status")).to_have_class("optimal", timeout=PATIENT)
    assert page.evaluate("() => document.cookie") == ""
    made = designed.value.headers["content-location"]
    headers = {"Authorization": f"Bearer {text}"}
    assert real_service.client.get(made).status_code == 404
    assert real_service.client.get(made, headers=headers).status_code == 200
    assert (
        page.evaluate("path => fetch(path).then(each => each.status)", f"{made}/contact.svg") == 200
    )
    page.unroute_all()
    page.get_by_role("button", name="Forget my key").click()
    expect(page.get_by_role("button", name="Forget my key")).to_be_hidden()
    # Not whether its answer is there: the studio asks the same again by now, for the local owner.
    assert [each for each in page.context.cookies() if each.get("name") == "camwright-key"] == []


def test_swagger_sends_the_key_that_was_entered(closed: Closed, real_service: Running) -> None:
    text = real_service.new_key("he who tries it")
    page, served = closed.page, json.loads(TARGET.read_text(encoding="utf-8"))
    served["paths"] = {"/v1/version": served["paths"]["/v1/version"]}
    page.route("**/openapi.json", lambda route: route.fulfill(json=served))
    page.goto(f"{real_service.url}/docs")
    page.get_by_role("button", name="Authorize").click()
    page.locator(".auth-container input").fill(text)
    page.locator(".auth-btn-wrapper .authorize").click()
    page.locator(".auth-btn-wrapper .btn-done").click()
    page.locator("#operations-tag-operation").click()  # all but the first are closed
    operation = page.locator("#operations-operation-get_version")
    operation.locator(".opblock-summary-control").click()
    with page.expect_request("**/v1/version") as sent:
        operation.locator("button.execute").click()
    assert sent.value.headers["authorization"] == f"Bearer {text}"
    expect(operation.locator(".live-responses-table .response-col_status").last).to_contain_text(
        "200"
    )
    assert closed.refused == []
