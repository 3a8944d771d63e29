"""The guard: without a key nothing but what is open, no other names, and who is told what."""

from __future__ import annotations

import asyncio
import json
import logging
from collections.abc import Callable, Iterator, Sequence
from datetime import UTC, datetime, timedelta
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import httpx2
import pytest
from sqlalchemy import text as sql
from sqlalchemy import update
from starlette.routing import Mount

from service.app import create_app
from service.openapi import TARGET
from service.server import keys_needed
from service.settings import Settings
from service.storage.keys import KEY_BYTES, LONGEST, PREFIX, REREAD_S, ApiKeys
from service.storage.store import Store
from service.storage.tables import ApiKeyRow, in_utc
from service.wire import access
from service.wire.access import Caller, Guard, KeyRefused
from tests.service.conftest import Running, settings_for
from tests.service.postgres import PASSWORD, postgres

Ask = Callable[..., httpx2.Response]


def asking(app: Any) -> Ask:
    """Requests of an application that does not listen."""

    def ask(method: str, path: str, **headers: str) -> httpx2.Response:
        (answer,) = answers_of(app, [(method, path)], **headers)
        return answer

    return ask


def answers_of(
    app: Any, requests: Sequence[tuple[str, str]], **headers: str
) -> list[httpx2.Response]:
    async def send() -> list[httpx2.Response]:
        transport, url = httpx2.ASGITransport(app), "http://localhost"
        async with httpx2.AsyncClient(transport=transport, base_url=url) as client:
            return [await client.request(*each, headers=headers) for each in requests]

    return asyncio.run(send())


async def _nothing(scope: Any, receive: Any, send: Any) -> None:
    await send({"type": "http.response.start", "status": 200, "headers": []})
    await send({"type": "http.response.body", "body": b""})


async def _caller_of(text: str) -> Caller:
    if text == "good":
        return Caller("ada", "1")
    raise KeyRefused("has expired")


def guarded(without_key: Caller | None = None, *hosts: str) -> Ask:
    names = Settings(allowed_hosts=hosts).hosts
    return asking(Guard(_nothing, names, _caller_of, without_key))


def test_every_route_but_those_that_hold_nothing_needs_a_key() -> None:
    """A route that comes to be needs one, unless it is listed."""
    app = create_app(Settings(), keys_needed=True)
    paths = json.loads(TARGET.read_text(encoding="utf-8"))["paths"]
    closed = {*paths, "/v1/anything", "//v1/designs", "/metrics/", "/docs/../v1/designs"}
    closed -= {"/livez", "/problems/{slug}", "/readyz"}
    requests = [(method, path) for path in closed for method in ("GET", "POST", "DELETE", "PUT")]
    for request, answer in zip(requests, answers_of(app, requests), strict=True):
        assert answer.status_code == 401, request
        assert answer.headers["www-authenticate"] == 'Bearer realm="camwright"'
    mounts = [f"{route.path}/x" for route in app.routes if isinstance(route, Mount)]
    free = [("GET", path) for path in ("/", "/livez", "/docs", "/guide", *mounts)]
    for request, answer in zip(free, answers_of(app, free), strict=True):
        assert answer.status_code != 401, request


@pytest.mark.parametrize(
    ("host", "known"),
    [
        ("localhost", True), ("LOCALHOST:8000", True), ("127.0.0.1:1", True), ("[::1]:8000", True),
        ("cams.example", True), ("CAMS.example:443", True), ("evil.example", False), ("", False),
        ("localhost.evil.example", False), ("evil.example:127.0.0.1", False), ("[::1", False),
        ("127.0.0.1@evil.example", False), ("10.0.0.1", False),
    ],
)  # fmt: skip
def test_only_the_names_of_the_service_are_answered(host: str, known: bool) -> None:
    """Another name is that of a page elsewhere, which has given it the address of this machine."""
    answer = guarded(Caller("local"), "cams.example")("GET", "/v1/designs", host=host)
    assert answer.status_code == (200 if known else 421)
    if not known:
        assert "CAMWRIGHT_ALLOWED_HOSTS" in answer.json()["detail"]


def test_keys_come_in_a_header_or_a_cookie_and_are_refused_with_the_reason() -> None:
    ask = guarded()
    for given in ({"authorization": "Bearer good"}, {"authorization": "bearer good"},
                  {"cookie": "a=b; camwright-key=good"}):  # fmt: skip
        answer = ask("GET", "/v1/designs", **given)
        assert (answer.status_code, answer.headers["cache-control"]) == (200, "private")
    for given in ({"authorization": "Bearer bad"}, {"authorization": "Basic good"},
                  {"authorization": "Bearer bad", "cookie": "camwright-key=good"},
                  {"cookie": "camwright-key=bad"}):  # fmt: skip
        answer = ask("GET", "/v1/designs", **given)
        assert answer.status_code == 401
        assert "has expired" in answer.json()["detail"]
        assert 'error="invalid_token"' in answer.headers["www-authenticate"]
        assert "bad" not in answer.text
    ask = guarded(Caller("local"))
    assert ask("GET", "/v1/designs", cookie="camwright-key=another-service's").status_code == 200
    assert ask("GET", "/v1/designs", authorization="Bearer bad").status_code == 401


def test_who_did_what_is_told_and_no_key_is(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO, access.audit.name)
    ask = guarded()
    for method, headers in (
        ("POST", {"authorization": "Bearer good"}), ("GET", {"authorization": "Bearer good"}),
        ("DELETE", {"authorization": "Bearer good"}), ("DELETE", {"authorization": "Bearer bad"}),
    ):  # fmt: skip
        ask(method, "/v1/designs/7", **headers)
    ask("GET", "/metrics", authorization="Bearer good")
    told = [record.__dict__["fields"] for record in caplog.records]
    assert [(each["action"], each["owner"], each["key"], each["status"]) for each in told] == [
        ("create", "ada", "1", 200), ("delete", "ada", "1", 200), ("refuse", None, None, 401),
        ("refuse", "ada", "1", 403),
    ]  # fmt: skip
    assert all(each["path"] in ("/v1/designs/7", "/metrics") for each in told)
    assert "good" not in str(told)


def test_a_key_is_kept_as_a_hash_rotated_without_a_gap_and_revoked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = Store(settings_for(tmp_path))
    keys = ApiKeys(store, settings_for(tmp_path, quota_concurrent=3))

    async def work() -> None:
        row, text = await keys.create("laptop", "ada", 1.0, quotas=access.Quotas(storage_mb=2.0))
        assert text.startswith(PREFIX)
        assert len(text) >= len(PREFIX) + KEY_BYTES * 8 / 6
        caller = await keys.caller(text)
        assert caller == Caller("ada", row.id, False, access.Quotas(None, None, 2.0, 3))
        new, later, _ = await keys.rotate(row.id, 0.5, None)
        assert (new.owner, new.quotas) == ("ada", row.quotas)
        assert later != text
        for each in text, later:  # both open it
            assert (await keys.caller(each)).owner == "ada"
        with pytest.raises(LookupError):
            await keys.rotate("none", 1.0, None)
        monkeypatch.setattr("service.storage.keys.REREAD_S", 0.0)
        keys._known.clear()
        assert await keys.revoke(new.id)
        assert not await keys.revoke(new.id)
        assert (await keys.caller(text)).key == row.id
        end = await keys.rotate(row.id, 0.0, None)
        for each, why in ((later, "revoked"), (text, "expired"), (PREFIX + "x", "not one"),
                          ("x" * 999, "not one"), (text + "x", "not one")):  # fmt: skip
            with pytest.raises(KeyRefused, match=why):
                await keys.caller(each)
        assert (await keys.caller(end[1])).owner == "ada"
        kept = await store.do(lambda s: [vars(each) for each in s.query(ApiKeyRow).all()])
        assert len(kept) == 3
        assert not any(secret in str(kept) for secret in (text, later, end[1]))

    try:
        asyncio.run(work())
    finally:
        store.dispose()


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    store = Store(settings_for(tmp_path))
    yield store
    store.dispose()


def test_the_store_is_asked_for_a_key_at_most_once_a_second(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Until then a key that was revoked is not refused; what cannot be a key is never looked up."""
    keys, now, looks = ApiKeys(store, Settings()), [100.0], list[float]()
    clock = SimpleNamespace(monotonic=lambda: now[0])
    monkeypatch.setattr("service.storage.keys.time", clock)

    async def look(work: Callable[[Any], Any]) -> Any:
        looks.append(now[0])
        return await store.do(work)

    async def work() -> None:
        row, text = await ApiKeys(store, Settings()).create("laptop", "ada")
        monkeypatch.setattr(keys, "_do", look)
        for wrong in ("", text.removeprefix(PREFIX), PREFIX + "x" * LONGEST):
            with pytest.raises(KeyRefused, match="not one"):
                await keys.caller(wrong)
        assert looks == []
        again = 100.0 + 1.1 * REREAD_S
        for now[0] in (100.0, 100.0 + 0.9 * REREAD_S, again):
            assert (await keys.caller(text)).key == row.id
        assert looks == [100.0, again]
        assert await ApiKeys(store, Settings()).revoke(row.id)
        now[0] = again + 0.9 * REREAD_S
        assert (await keys.caller(text)).key == row.id
        now[0] = again + 1.1 * REREAD_S
        with pytest.raises(KeyRefused, match="revoked"):
            await keys.caller(text)

    asyncio.run(work())


@pytest.mark.parametrize(("days", "left"), [(None, 1.0), (0.5, 0.5), (2.0, 1.0)])
def test_a_rotated_key_ends_after_the_overlap_or_when_it_would_have(
    store: Store, days: float | None, left: float
) -> None:
    keys, began = ApiKeys(store, Settings()), datetime.now(UTC)

    async def work() -> None:
        old, text = await keys.create("laptop", "ada", days)
        new, _, end = await keys.rotate(old.id, 1.0, None)
        assert {row.id: in_utc(row.expires) for row in await keys.all()} == {
            old.id: end,
            new.id: None,
        }
        assert timedelta(0) <= end - began - timedelta(days=left) < timedelta(minutes=1)
        assert (await keys.caller(text)).key == old.id

    asyncio.run(work())


def test_keys_are_listed_owner_by_owner(store: Store) -> None:
    keys = ApiKeys(store, Settings())

    async def work() -> None:
        for name, owner in (("first", "bob"), ("second", "ada"), ("third", "bob")):
            await keys.create(name, owner)
        assert [row.name for row in await keys.all()] == ["second", "first", "third"]

    asyncio.run(work())


def test_a_key_that_is_revoked_meanwhile_gets_none_in_its_place(tmp_path: Path) -> None:
    """A rotation waits for a revocation that has begun, and finds the key refused."""
    waiting = sql("select count(*) from pg_locks where not granted")
    with postgres("camwright", "camwright") as port:
        address = f"camwright:{PASSWORD}@127.0.0.1:{port}/camwright"
        store = Store(settings_for(tmp_path, database_url=f"postgresql+psycopg://{address}"))
        keys = ApiKeys(store, Settings())

        async def work() -> None:
            old, _ = await keys.create("laptop", "ada")
            with store.engine.begin() as revoking:
                revoking.execute(update(ApiKeyRow).values(revoked=datetime.now(UTC)))
                rotation = asyncio.create_task(keys.rotate(old.id, 1.0, None))
                for _ in range(1000):
                    if revoking.scalar(waiting) or rotation.done():
                        break
                    await asyncio.sleep(0.01)
            with pytest.raises(LookupError):
                await rotation
            assert [row.id for row in await keys.all()] == [old.id]

        try:
            asyncio.run(work())
        finally:
            store.dispose()


@pytest.fixture
def folder_with_a_key(tmp_path: Path) -> Path:
    folder = tmp_path / "with a key"
    store = Store(settings_for(folder))
    asyncio.run(ApiKeys(store, settings_for(folder)).create("k", "ada"))
    store.dispose()
    return folder


@pytest.mark.parametrize(
    ("given", "empty", "with_a_key"),
    [
        ({}, False, True),
        ({"host": "::1"}, False, True),
        ({"host": "127.0.0.2", "allowed_hosts": "localhost, 127.0.0.1"}, False, True),
        ({"access": "keys"}, True, True),
        ({"access": "open-to-anyone"}, False, False),
        ({"host": "0.0.0.0"}, None, True),
        ({"host": "::"}, None, True),
        ({"host": "cams.example"}, None, True),
        ({"allowed_hosts": "cams.example"}, None, True),  # behind a proxy
        ({"host": "0.0.0.0", "access": "keys"}, None, True),
        ({"host": "0.0.0.0", "access": "open-to-anyone"}, False, False),
    ],
)
def test_it_does_not_start_where_others_reach_it_and_nobody_said_who_may(
    tmp_path: Path,
    folder_with_a_key: Path,
    given: dict[str, str],
    empty: bool | None,
    with_a_key: bool,
) -> None:
    """Whether keys are needed, with an empty database and one that has a key; None: exit 1."""
    assert keys_needed(settings_for(folder_with_a_key, **given)) is with_a_key
    if empty is None:
        with pytest.raises(SystemExit, match="CAMWRIGHT_ACCESS=open-to-anyone"):
            keys_needed(settings_for(tmp_path, **given))
    else:
        assert keys_needed(settings_for(tmp_path, **given)) is empty


def test_every_answer_says_what_a_browser_may_do_with_it(service: Running) -> None:
    for path in ("/livez", "/v1/designs", "/no such path", "/", "/openapi.json", "/guide"):
        headers = service.client.get(path).headers
        assert headers["x-content-type-options"] == "nosniff"
        assert "frame-ancestors" in headers["content-security-policy"]
        assert headers["cross-origin-resource-policy"] == "same-origin"
        assert headers["referrer-policy"] == "no-referrer"
        assert "access-control-allow-origin" not in headers
    tag = service.client.get("/openapi.json").headers["etag"]
    kept = service.client.get("/openapi.json", headers={"If-None-Match": tag})
    assert kept.status_code == 304
    assert "content-security-policy" not in kept.headers  # it would take the place of the page's
    asked = {"Origin": "https://evil.example", "Access-Control-Request-Method": "DELETE"}
    answer = service.client.options("/v1/designs/1", headers=asked)
    assert not any(name.startswith("access-control") for name in answer.headers)
