"""Two owners on every route of the contract: what one has asked is not there for the other."""

from __future__ import annotations

import re
import uuid
from collections.abc import Iterator
from datetime import UTC, datetime

import httpx2
import pytest

from service.resources.records import RESOURCES
from service.storage.tables import AnswerRow
from service.wire.access import Quotas
from synthesis.design.identity import ENGINE_NUMBER
from tests.service.conftest import Running
from tests.service.specs import spec
from tests.service.sweeps.test_sweeps import over, posted, sweep_of


def client_of(service: Running, text: str) -> httpx2.Client:
    headers = {"Authorization": f"Bearer {text}"}
    anew = httpx2.Limits(max_keepalive_connections=0)
    return httpx2.Client(base_url=service.url, headers=headers, timeout=60.0, limits=anew)


@pytest.fixture
def ada(service: Running) -> Iterator[httpx2.Client]:
    with client_of(service, service.new_key("ada")) as client:
        yield client


@pytest.fixture
def bob(service: Running) -> Iterator[httpx2.Client]:
    with client_of(service, service.new_key("bob")) as client:
        yield client


def kept_for(service: Running, owner: str) -> dict[str, str]:
    """A failed answer of every resource that this owner holds: ids by path of the collection."""
    problem = {"type": "/problems/internal", "title": "", "status": 500, "detail": ""}
    ids = {}
    for path in RESOURCES:
        ids[path] = uuid.uuid4().hex
        row = AnswerRow(
            id=ids[path], kind=path, engine=ENGINE_NUMBER, name="n", created=datetime.now(UTC),
            state="failed", spec=b"{}", summary={}, problem=problem,
        )  # fmt: skip
        answers = service.app.state.parts.jobs[path].answers
        service.run(answers.accept(row))
        service.run(answers.claim(ids[path], owner))
    return ids


def test_on_no_route_is_there_anything_of_another_owner(
    service: Running, ada: httpx2.Client, bob: httpx2.Client
) -> None:
    """What the other's answer is, 404, he gets for every id that there is not."""
    ids = kept_for(service, "ada")
    sweep = over(ada, posted(ada, sweep_of(["a", "b"])))
    item = ada.get(f"{sweep['links']['self']}/items/0").json()
    design = item["links"]["design"]
    paths = service.client.get("/openapi.json").json()["paths"]
    routes = [(path, method) for path, methods in paths.items() for method in methods]
    # DELETE last: it is what ends them for their owner.
    routes.sort(key=lambda route: route[1] == "delete")
    gone_through = 0
    for path, method in routes:
        collection = next((each for each in ids if path.startswith(f"{each}/")), "")
        if path.startswith("/v1/sweeps/"):
            addresses = [path.format(sweep_id=sweep["id"], number=0)]
        elif collection:
            name = path.removeprefix(f"{collection}/").partition("/")[0]
            addresses = [path.replace(name, ids[collection])]
            if collection == "/v1/designs":
                addresses.append(path.replace(name, design.rpartition("/")[2]))
        elif method == "get" and (path in ids or path == "/v1/sweeps"):
            assert bob.get(path).json() == {"items": [], "next": None}, path
            listed = {each["id"] for each in ada.get(path).json()["items"]}
            assert {ids.get(path, sweep["id"])} <= listed, path
            continue
        else:
            assert "{" not in path or path == "/problems/{slug}", path
            continue
        for address in addresses:
            query = {"item": "0"} if address.endswith("proofs.zip") else {}
            hidden = bob.request(method, address, params=query)
            assert (address, hidden.status_code) == (address, 404)
            never = re.sub(r"[0-9a-f]{32}", "0" * 32, address)
            unknown = bob.request(method, never, params=query)
            same = [re.sub(r"[0-9a-f]{32}", "", each.text) for each in (hidden, unknown)]
            assert same[0] == same[1], address
            gone_through += 1
            if design in address and address != design:
                continue  # files: of the fake core's cams there are none
            seen = ada.request(method, address, params=query)
            assert seen.status_code not in (401, 403, 404), (method, address)
    assert gone_through > 100


def test_an_answer_of_two_is_kept_once_and_each_deletes_it_for_himself(
    ada: httpx2.Client, bob: httpx2.Client
) -> None:
    body = spec("of two")
    path = ada.post("/v1/designs", json=body).headers["content-location"]
    assert bob.get(path).status_code == 404
    assert bob.delete(path).status_code == 404
    first, second = ada.get(path), bob.post("/v1/designs", json=body)
    assert (second.headers["content-location"], second.content) == (path, first.content)
    assert bob.delete(path).status_code == 204
    assert (bob.get(path).status_code, ada.get(path).status_code) == (404, 200)
    assert ada.delete(path).status_code == 204
    assert ada.get(path).status_code == 404


def test_sweeps_and_idempotency_keys_are_of_their_owner_alone(
    ada: httpx2.Client, bob: httpx2.Client
) -> None:
    body = sweep_of(["x"])
    of_ada, of_bob = (over(each, posted(each, body)) for each in (ada, bob))
    assert of_ada["id"] != of_bob["id"]
    assert ada.delete(of_ada["links"]["self"]).status_code == 204
    assert bob.get(of_bob["links"]["self"]).json() == of_bob
    again = {"Idempotency-Key": uuid.uuid4().hex}
    for each in ada, bob:
        answer = each.post("/v1/designs", json=spec("mine"), headers=again)
        assert answer.status_code == 200, answer.text
    assert ada.post("/v1/designs", json=spec("new"), headers=again).status_code == 422


@pytest.mark.parametrize(
    ("quotas", "name", "waits"),
    [
        (Quotas(requests_per_minute=1), "requests", True),
        (Quotas(core_seconds_per_day=1e-9), "core-seconds", True),
        (Quotas(storage_mb=1e-9), "storage", False),
        (Quotas(concurrent=1), "concurrent", True),
    ],
    ids=lambda each: "",
)
def test_a_quota_is_refused_with_what_there_is_of_it(
    service: Running, quotas: Quotas, name: str, waits: bool
) -> None:
    owner = f"has little of {name}"
    with client_of(service, service.new_key(owner, quotas=quotas)) as client:
        later = {"Prefer": "respond-async"} if name == "concurrent" else {}
        first = client.post("/v1/designs", json=spec("look 3" if later else ""), headers=later)
        assert first.status_code == (202 if later else 200), first.text
        refused = client.post("/v1/designs", json=spec())
        assert (refused.status_code, refused.json()["type"]) == (429, "/problems/quota-used-up")
        assert refused.headers["ratelimit"].startswith(f'"{name}";r=0')
        assert refused.headers["ratelimit-policy"].startswith(f'"{name}";q=')
        assert ("retry-after" in refused.headers) is waits
        if name == "requests":
            assert 0 < int(refused.headers["retry-after"]) <= 60
            assert first.headers["ratelimit"].startswith('"requests";r=0;t=')
        if later:
            client.delete(first.headers["location"])
            assert client.post("/v1/designs", json=spec()).status_code == 200
