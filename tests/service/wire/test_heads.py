"""HEAD, tags and places: what is answered without making anything."""

from __future__ import annotations

import time
from pathlib import Path

import httpx2
import pytest

from service.contract.examples import examples
from service.routes import files
from tests.service.conftest import Running
from tests.service.fake_core import Gate
from tests.service.specs import spec
from tests.service.sweeps.test_sweeps import posted, sweep_of
from tests.service.workers.test_trouble import is_problem

CAM = examples("analyses")["p3-same"]["value"]
TOLD = ("etag", "content-type", "content-disposition", "accept-ranges")


def test_head_tells_what_get_would_and_makes_nothing(
    client: httpx2.Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So does a GET with the tag."""
    owner = client.post("/v1/analyses", json=CAM).headers["content-location"]
    head, got = (client.request(method, owner) for method in ("HEAD", "GET"))
    assert (head.status_code, head.content) == (200, b"")
    assert head.headers["etag"].strip('"') in got.headers["etag"]
    path, plain = f"{owner}/motion.svg", {"Accept-Encoding": "identity"}
    file = client.get(path, headers=plain)
    assert file.status_code == 200
    monkeypatch.setattr(files, "partial", None)  # to make a file would fail
    assert client.get(path, headers=plain).status_code == 500
    head = client.head(path, headers=plain)
    assert (head.status_code, head.content) == (200, b"")
    assert [head.headers[each] for each in TOLD] == [file.headers[each] for each in TOLD]
    for method in ("GET", "HEAD"):
        known = client.request(method, path, headers={"If-None-Match": file.headers["etag"]})
        assert (known.status_code, known.content) == (304, b"")


def test_head_of_a_file_that_cannot_be(
    client: httpx2.Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It has no cam: as GET says."""
    monkeypatch.setattr(files, "WITHOUT_CAM", ("optimal",))
    owner = client.post("/v1/designs", json=spec()).headers["content-location"]
    assert client.head(f"{owner}/profile.csv").status_code == 409


@pytest.mark.parametrize(
    "path", ["/v1/designs/none", "/v1/designs/none/profile.csv", "/v1/sweeps/none/events"]
)
def test_head_of_what_is_not_there(client: httpx2.Client, path: str) -> None:
    assert client.head(path).status_code == 404


def test_the_contract_has_a_tag(client: httpx2.Client) -> None:
    document = client.get("/openapi.json", headers={"Accept-Encoding": "identity"})
    assert document.json()["openapi"].startswith("3.1")
    again = client.get("/openapi.json", headers={"If-None-Match": document.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")


def test_streams_have_places(
    service: Running, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A place is free again when its stream has ended, or its watcher has gone."""
    client, places = service.client, service.app.state.parts.streams
    gate = Gate(tmp_path / "gate")
    events = f"{posted(client, sweep_of(gate.names(1)))}/events"
    head = client.head(events, timeout=10.0)  # which does not watch
    assert head.headers["content-type"].startswith("text/event-stream")
    while places._all:  # of the answer above, perhaps after its last byte, and of tests before
        time.sleep(0.01)
    monkeypatch.setattr(places, "_each", 1)
    with client.stream("GET", events) as first:
        lines = first.iter_lines()
        next(lines)
        refused = is_problem(client.get(events), 429, "busy")
        assert "1 streams of events from 127.0.0.1" in refused["detail"]
        gate.open()
        assert "event: end" in list(lines)
    for _ in range(3):  # each gives its place back, though perhaps after its last byte
        for _ in range(500):
            answer = client.get(events)
            if answer.status_code != 429:
                break
            time.sleep(0.01)
        assert answer.status_code == 200
