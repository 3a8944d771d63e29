"""The Python client, waiting and awaiting: answers, refusals, tries, sweeps, broken events."""

from __future__ import annotations

import asyncio
import csv
import json
import sys
from collections.abc import Callable
from email.utils import formatdate
from pathlib import Path
from time import time
from types import SimpleNamespace
from typing import Any

import httpx2
import pytest
from fastapi import Request
from sqlalchemy.exc import OperationalError

from service.client import AsyncClient, Client, Refused, Retries, Unreachable
from service.client.progress import shown
from service.wire.problem import error_response
from tests.service.conftest import Running
from tests.service.cutting import Cutting
from tests.service.fake_core import Gate
from tests.service.specs import spec
from tests.service.sweeps.test_sweeps import sweep_of

QUICK = Retries(tries=4, first_s=0.01, patience_s=2.0)
PROBLEM = {"content-type": "application/problem+json"}
Asking = Callable[..., Any]


def waiting(call: str, *given: Any, **settings: Any) -> Any:
    with Client(settings.pop("url", "http://test"), retries=QUICK, **settings) as client:
        return getattr(client, call)(*given)


def awaiting(call: str, *given: Any, **settings: Any) -> Any:
    async def question() -> Any:
        url = settings.pop("url", "http://test")
        async with AsyncClient(url, retries=QUICK, **settings) as client:
            return await getattr(client, call)(*given)

    return asyncio.run(question())


@pytest.fixture(params=[waiting, awaiting])
def ask(request: pytest.FixtureRequest) -> Asking:
    asking: Asking = request.param
    return asking


class Scripted:
    """A service that answers as it is told, and remembers what it was asked."""

    def __init__(self, *answers: httpx2.Response | Exception) -> None:
        self._answers, self.question = list(answers), list[httpx2.Request]()
        self.transport = httpx2.MockTransport(self._answer)

    def _answer(self, request: httpx2.Request) -> httpx2.Response:
        self.question.append(request)
        answer = self._answers.pop(0) if len(self._answers) > 1 else self._answers[0]
        if isinstance(answer, Exception):
            raise answer
        return answer


def test_a_design_and_its_analysis(service: Running, ask: Asking) -> None:
    found = ask("design", spec("by the client"), url=service.url)
    assert (found["name"], found["status"]) == ("by the client", "optimal")
    assert ask("get", found["links"]["self"], url=service.url) == found


def test_a_refusal_carries_the_problem(service: Running, ask: Asking) -> None:
    with pytest.raises(Refused) as caught:
        ask("design", spec(speed_rpm=-1.0), url=service.url)
    no = caught.value
    assert (no.status, no.kind, no.retry_after_s) == (422, "invalid-request", None)
    assert no.errors[0]["pointer"] == "/speed_rpm"
    assert str(no) == no.problem["detail"]


def test_the_best_so_far_comes_with_the_end_of_time(service: Running, ask: Asking) -> None:
    with pytest.raises(Refused) as caught:
        ask("design", spec("best"), url=service.url)
    assert caught.value.status == 504
    assert caught.value.best is not None
    assert caught.value.best["dimensions"]["base_radius_mm"] == 50.0


def test_busy_is_waited_for_as_long_as_the_service_says(ask: Asking) -> None:
    busy = httpx2.Response(429, headers={**PROBLEM, "retry-after": "1"}, json={"detail": "full"})
    script = Scripted(busy, httpx2.Response(200, json={"id": "x"}))
    started = time()
    assert ask("design", {}, transport=script.transport) == {"id": "x"}
    assert time() - started >= 1.0
    first, second = script.question
    assert first.headers["idempotency-key"] == second.headers["idempotency-key"]
    assert first.content == second.content


@pytest.mark.parametrize("as_date", [False, True])
def test_a_wait_beyond_patience_is_left_to_the_caller(ask: Asking, as_date: bool) -> None:
    after = formatdate(time() + 3600, usegmt=True) if as_date else "3600"
    busy = httpx2.Response(503, headers={**PROBLEM, "retry-after": after}, json={"detail": "later"})
    script = Scripted(busy)
    with pytest.raises(Refused, match="later") as caught:
        ask("design", {}, transport=script.transport)
    assert len(script.question) == 1
    assert caught.value.retry_after_s == pytest.approx(3600, abs=10)


def test_tries_are_counted(ask: Asking) -> None:
    busy = httpx2.Response(503, headers={**PROBLEM, "retry-after": "0"}, json={"detail": "no"})
    for reported, error in ((busy, Refused), (httpx2.ConnectError("nobody there"), Unreachable)):
        script = Scripted(reported)
        with pytest.raises(error, match="no"):
            ask("design", {}, transport=script.transport)
        assert len(script.question) == QUICK.tries


def test_what_the_service_does_not_want_again_is_not_sent_again(ask: Asking) -> None:
    lost = {"type": "/problems/worker-lost", "detail": "its worker died"}
    script = Scripted(httpx2.Response(503, headers=PROBLEM, json=lost))
    with pytest.raises(Refused) as caught:
        ask("design", {}, transport=script.transport)
    assert (len(script.question), caught.value.kind) == (1, "worker-lost")


def test_a_proxy_that_has_lost_its_service_is_tried_again(ask: Asking) -> None:
    script = Scripted(httpx2.Response(502, text="<html>Bad Gateway"), httpx2.Response(200, json={}))
    assert ask("design", {}, transport=script.transport) == {}
    with pytest.raises(Refused, match="status 418 without a problem document: teapot"):
        ask("design", {}, transport=Scripted(httpx2.Response(418, text="teapot")).transport)


def test_a_deletion_whose_answer_was_lost_is_not_sent_again(ask: Asking) -> None:
    """The first deletion of a sweep stops it, the second one would discard it."""
    script = Scripted(httpx2.ReadError("broken"))
    with pytest.raises(Unreachable, match="was not sent again"):
        ask("delete", "/v1/sweeps/x", transport=script.transport)
    assert len(script.question) == 1


def test_what_is_under_way_is_asked_for_until_it_is_there(ask: Asking) -> None:
    accepted = {"location": "/v1/designs/abc", "retry-after": "0"}
    script = Scripted(
        httpx2.Response(202, headers=accepted, json={}),
        httpx2.Response(202, headers=accepted, json={}),
        httpx2.Response(200, json={"id": "abc"}),
    )
    assert ask("design", {}, transport=script.transport) == {"id": "abc"}
    assert [request.url.path for request in script.question[1:]] == ["/v1/designs/abc"] * 2


def test_a_sweep_from_start_to_files(service: Running, ask: Asking, tmp_path: Path) -> None:
    names = [f"of {ask.__name__}, {i}" for i in range(7)]
    sweep = ask("sweep", sweep_of([*names, "bug"]), url=service.url)
    over = ask("wait", sweep["id"], url=service.url)
    assert (over["state"], over["counts"]["done"]) == ("successful", 8)
    target = tmp_path / "deep" / "items.csv"
    assert ask("download", over["links"]["items.csv"], target, url=service.url) == target
    assert [line.split(",")[0] for line in target.read_text().splitlines()[1:]] == [*"01234567"]
    stays = ask("dismiss", sweep["id"], url=service.url)
    assert (stays["state"], stays["counts"]) == ("successful", over["counts"])


def test_items_come_page_by_page_and_by_status(service: Running) -> None:
    with Client(service.url, retries=QUICK) as client:
        sweep = client.sweep(sweep_of([f"paged {i}" for i in range(23)] + ["bug"]))["id"]
        client.wait(sweep)
        assert sorted(item["number"] for item in client.items(sweep)) == list(range(24))
        assert [item["number"] for item in client.items(sweep, status="failed")] == [23]
        front = client.pareto(sweep, minimise=["base_radius_mm"])
        assert (front["compared"], front["excluded"]) == (23, 1)

    async def numbers() -> list[int]:
        async with AsyncClient(service.url) as client:
            return sorted([item["number"] async for item in client.items(sweep)])

    assert asyncio.run(numbers()) == list(range(24))


def test_dismissing_keeps_what_is_done(service: Running, tmp_path: Path) -> None:
    gate = Gate(tmp_path / "gate")
    gate.let(3)
    with Client(service.url, retries=QUICK) as client:
        sweep = client.sweep(sweep_of(gate.names(50)))["id"]
        for event in client.watch(sweep):
            if event.kind == "item":
                break
        stopped = client.dismiss(sweep)
        assert stopped["state"] == "dismissed"
        assert 1 <= stopped["counts"]["done"] <= 3
        assert client.dismiss(sweep)["counts"] == stopped["counts"]
        client.delete(f"/v1/sweeps/{sweep}")
        with pytest.raises(Refused, match="no sweep"):
            client.wait(sweep)


def test_watching_goes_on_when_the_connection_breaks(service: Running) -> None:
    """Every item is told once, and in order, though each of three connections is cut off."""
    with Client(service.url) as direct:
        sweep = direct.sweep(sweep_of([f"watched {i}" for i in range(31)]))["id"]
        direct.wait(sweep)
        whole = [event.data["number"] for event in direct.watch(sweep) if event.kind == "item"]
    plain = {"Accept-Encoding": "identity"}
    with Cutting(service.url, [3000, 1500, 0]) as between:
        with Client(between.url, retries=QUICK, headers=plain) as client:
            reported = list(client.watch(sweep))
        question = [request.lower() for request in between.requests]
    assert [event.data["number"] for event in reported if event.kind == "item"] == whole
    assert [event.kind for event in reported].count("end") == 1
    assert len(question) == 4
    assert [b"last-event-id" in each for each in question] == [False, True, True, True]


def test_watching_by_an_event_loop(service: Running) -> None:
    async def watch_events() -> list[str]:
        async with AsyncClient(service.url) as client:
            sweep = await client.sweep(sweep_of([f"awaited {i}" for i in range(5)]))
            return [event.kind async for event in client.watch(sweep["id"])]

    kinds = asyncio.run(watch_events())
    assert (kinds.count("item"), kinds[-1]) == (5, "end")


def test_a_service_that_only_ever_breaks_off_is_given_up(service: Running) -> None:
    with Client(service.url) as direct:
        sweep = direct.sweep(sweep_of(["given up"]))["id"]
        direct.wait(sweep)
    with (
        Cutting(service.url, [0] * 9) as between,
        Client(between.url, retries=QUICK) as client,
        pytest.raises(Unreachable, match="tried 4 times"),
    ):
        list(client.watch(sweep))


def test_models_of_the_core_are_taken_as_they_are(service: Running) -> None:
    from synthesis.spec.design_spec import DesignSpec

    body = spec("a model")
    model = DesignSpec.model_validate(body)
    with Client(service.url) as client:
        assert client.design(model)["id"] == client.design(json.loads(json.dumps(body)))["id"]


def test_a_store_that_is_away_for_a_moment_is_waited_for(ask: Asking) -> None:
    """The service says when, so that a restart of the database stops no client."""
    scope = {"type": "http", "method": "GET", "path": "/v1/designs", "headers": []}
    reported = error_response(Request(scope), OperationalError("select", None, Exception("gone")))
    assert (reported.status_code, reported.headers["retry-after"]) == (503, "2")
    headers = {**PROBLEM, "retry-after": "0"}  # how long it waits is another test's
    away = httpx2.Response(reported.status_code, headers=headers, content=bytes(reported.body))
    script = Scripted(away, httpx2.Response(200, json={"items": []}))
    assert ask("get", "/v1/designs", transport=script.transport) == {"items": []}


def test_a_sweep_is_a_table(service: Running, tmp_path: Path) -> None:
    """That of items.csv, in its order, whatever the order in which the items were finished."""
    body = sweep_of(["sized 20 3", "bug", "sized 30 4"])
    seen: list[str] = []
    with Client(service.url) as client:
        sweep = client.sweep(body).wait(lambda summary: seen.append(summary["state"]))
        assert sweep["state"] == seen[-1] == "successful"
        written = client.download(sweep["links"]["items.csv"], tmp_path / "items.csv")
        columns, arrow = sweep.columns(), sweep.to_arrow()
        assert sweep.pareto(minimise=["base_radius_mm"])["size"] == 1
        with written.open(newline="") as file:
            rows = list(csv.DictReader(file))
        assert [*rows[0]] == [*columns] == arrow.column_names
        for name, column in columns.items():
            known = [row[name] for row in rows]
            assert ["" if cell is None else str(cell) for cell in column] == known
        assert arrow.column("base_radius_mm").to_pylist() == columns["base_radius_mm"]
        assert columns["base_radius_mm"][1] is None
        assert "successful: 3 of 3 items" in sweep._repr_html_()


def test_a_sweep_is_a_data_frame(service: Running) -> None:
    pandas = pytest.importorskip("pandas")
    with Client(service.url) as client:
        frame = client.sweep(sweep_of(["sized 20 3", "bug"])).wait(False).to_pandas()
    assert frame["base_radius_mm"].dtype == float
    assert list(pandas.isna(frame["base_radius_mm"])) == [False, True]


def test_a_missing_library_is_said(service: Running, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with Client(service.url) as client, pytest.raises(ImportError, match=r"'camwright\[pandas\]'"):
        client.sweep(sweep_of(["sized 20 3"])).to_pandas()


def test_progress_is_shown_in_a_notebook(monkeypatch: pytest.MonkeyPatch) -> None:
    """One display, changed each time; a stand-in for IPython, which is not installed here."""
    said: list[str] = []
    display = SimpleNamespace(
        HTML=str, display=lambda first, display_id: SimpleNamespace(update=said.append)
    )
    ipython = SimpleNamespace(get_ipython=lambda: SimpleNamespace(kernel=1), display=display)
    monkeypatch.setitem(sys.modules, "IPython", ipython)
    monkeypatch.setitem(sys.modules, "IPython.display", display)
    counts = {"items": 4, "done": 1, "optimal": 1, "feasible": 0, "unsolved": 0, "infeasible": 0}
    summary = {
        "name": "<b>", "state": "running", "counts": {**counts, "failed": 0}, "progress": 25.0,
        "time_left_s": 3.2,
    }  # fmt: skip
    show = shown()
    show(summary)
    show({**summary, "state": "successful", "time_left_s": None})
    assert 'value="25"' in said[0]
    assert "&lt;b&gt;" in said[0]
    assert "running: 1 of 4 items, 1 optimal, 3 s left" in said[0]
    assert "successful: 1 of 4 items, 1 optimal<" in said[1]
