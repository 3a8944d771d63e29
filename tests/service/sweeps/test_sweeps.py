"""Sweeps over HTTP with a fake core: all the way, watching, stopping, and what is refused."""

from __future__ import annotations

import csv
import io
import json
import os
import time
from pathlib import Path
from typing import Any

import httpx2
import pytest

from service.workers import engine
from tests.service.conftest import Running, wait_until_idle
from tests.service.fake_core import Gate
from tests.service.killing import children
from tests.service.specs import spec
from tests.service.workers.test_trouble import is_problem


def sweep_of(names: list[str], **more: Any) -> dict[str, Any]:
    """A sweep whose items do what their names say, in the fake core."""
    axis = {"kind": "list", "pointer": "/name", "values": names}
    return {"name": "many", "base": spec(), "axes": [axis], **more}


def posted(client: httpx2.Client, body: dict[str, Any]) -> str:
    answer = client.post("/v1/sweeps", json=body)
    assert answer.status_code == 202, answer.text
    where: str = answer.headers["location"]
    assert where == answer.json()["links"]["self"]
    return where


def over(client: httpx2.Client, where: str) -> dict[str, Any]:
    for _ in range(6000):
        found: dict[str, Any] = client.get(where).json()
        if found["state"] not in ("accepted", "running"):
            return found
        time.sleep(0.05)  # to ask is work too
    raise AssertionError(found)


def items_at(client: httpx2.Client, where: str, **query: Any) -> list[dict[str, Any]]:
    """Every finished item, page by page."""
    found: list[dict[str, Any]] = []
    while True:
        page = client.get(f"{where}/items", params=query).json()
        found += page["items"]
        if page["next"] is None:
            return found
        query["cursor"] = page["next"]


def counted(found: dict[str, Any], **expected: int) -> None:
    """Exactly these counts; those not named are 0."""
    zero = dict.fromkeys(("optimal", "feasible", "unsolved", "infeasible", "failed"), 0)
    assert found["counts"] == {"items": 0, "done": 0} | zero | expected


def events(client: httpx2.Client, where: str, **headers: str) -> list[dict[str, Any]]:
    """Server-sent events to the end of the stream."""
    with client.stream("GET", f"{where}/events", headers=headers) as answer:
        assert answer.headers["content-type"].startswith("text/event-stream")
        found, now = [], dict[str, Any]()
        for line in answer.iter_lines():
            name, _, value = line.partition(": ")
            if line and name:
                now[name] = json.loads(value) if name == "data" else value
            elif now:
                found.append(now)
                now = {}
    return found


def test_from_end_to_end(client: httpx2.Client) -> None:
    body = sweep_of([f"item {i}" for i in range(57)])
    where = posted(client, body)
    found = over(client, where)
    assert (found["state"], found["progress"]) == ("successful", 100.0)
    counted(found, items=57, done=57, optimal=57)
    assert found["spec"]["axes"][0]["values"] == body["axes"][0]["values"]
    items = items_at(client, where, limit=10)
    assert sorted(item["number"] for item in items) == list(range(57))
    for item in items:
        assert item["values"] == {"/name": f"item {item['number']}"}
        assert item["quantities"]["base_radius_mm"] == 50.0
        assert (item["status"], item["gap"], item["problem"]) == ("optimal", 0.002, None)
    design = client.get(items[0]["links"]["design"])
    assert design.json()["name"] == items[0]["values"]["/name"]
    one = client.get(f"{where}/items/41").json()
    assert one["values"] == {"/name": "item 41"}
    assert one in items
    listed = client.get("/v1/sweeps", params={"limit": 1, "state": "successful"}).json()
    assert listed["items"][0]["id"] == found["id"]


def test_the_design_of_an_item_is_that_of_its_spec_alone(client: httpx2.Client) -> None:
    body = sweep_of(["alone", "beside"])
    where = posted(client, body)
    over(client, where)
    link = client.get(f"{where}/items/1").json()["links"]["design"]
    answer = client.post("/v1/designs", json={**body["base"], "proof": "quick", "name": "beside"})
    assert answer.headers["content-location"] == link
    kept = client.get(link)
    assert (kept.content, kept.headers["etag"]) == (answer.content, answer.headers["etag"])


def test_a_design_that_was_there_before_its_sweep_is_forgotten_alone(client: httpx2.Client) -> None:
    body = sweep_of(["there before"])
    answer = client.post(
        "/v1/designs", json={**body["base"], "proof": "quick", "name": "there before"}
    )
    where = answer.headers["content-location"]
    over(client, posted(client, body))
    assert client.delete(where).status_code == 204
    assert client.get(where).content == answer.content
    is_problem(client.delete(where), 409, "part-of-sweep")


def test_the_same_sweep_is_joined_and_a_key_goes_with_it(client: httpx2.Client) -> None:
    body, key = sweep_of(["sleep 0.3", "x"]), {"Idempotency-Key": "sweep-key-1"}
    first = client.post("/v1/sweeps", json=body, headers=key).json()
    assert client.post("/v1/sweeps", json=body, headers=key).json()["id"] == first["id"]
    other = client.post("/v1/sweeps", json=sweep_of(["y"]), headers=key)
    is_problem(other, 422, "idempotency-key-reused")
    counted(over(client, first["links"]["self"]), items=2, done=2, optimal=2)


def test_items_that_go_wrong_are_told_one_by_one(client: httpx2.Client) -> None:
    where = posted(client, sweep_of(["fine", "solver", "bug", "empty", "best", "fine too"]))
    counted(over(client, where), items=6, done=6, optimal=3, failed=3)
    failed = {item["number"]: item["problem"] for item in items_at(client, where, status="failed")}
    assert {n: problem["type"] for n, problem in failed.items()} == {
        1: "/problems/solver-failed", 2: "/problems/internal", 3: "/problems/time-budget",
    }  # fmt: skip
    assert "secret" not in json.dumps(failed)
    best = client.get(f"{where}/items/4").json()
    assert best["problem"]["type"] == "/problems/time-budget"
    assert best["quantities"]["base_radius_mm"] == 50.0
    assert "design" not in best["links"]


def test_an_item_that_makes_no_sense_points_at_what_is_wrong(client: httpx2.Client) -> None:
    axis = {"kind": "list", "pointer": "/limits/0/rise_deg", "values": [30.0, -5.0]}
    where = posted(client, {"base": spec(), "axes": [axis]})
    counted(over(client, where), items=2, done=2, optimal=1, failed=1)
    problem = client.get(f"{where}/items/1").json()["problem"]
    assert problem["errors"][0]["pointer"] == "/limits/0/rise_deg"
    assert problem["errors"][0]["value"] == -5.0


def test_a_sweep_without_one_sensible_item_is_refused(client: httpx2.Client) -> None:
    axis = {
        "kind": "range",
        "pointer": "/program/0/angle_deg",
        "start": 61,
        "stop": 80,
        "count": 99,
    }
    problem = is_problem(
        client.post("/v1/sweeps", json={"base": spec(), "axes": [axis]}), 422, "invalid-request"
    )
    assert problem["errors"][0]["pointer"] == "/base/program"
    assert "None of 8 items" in problem["detail"]


@pytest.mark.parametrize(
    ("axis", "pointer"),
    [
        ({"kind": "list", "values": ["100", "200 rpm"]}, "/axes/0/values/0"),
        ({"kind": "range", "start": -2, "stop": -1, "count": 2}, "/axes/0"),
    ],
)
def test_a_value_that_no_item_can_take_is_told_where_it_was_written(
    client: httpx2.Client, axis: dict[str, Any], pointer: str
) -> None:
    sweep = {"base": spec(), "axes": [{"pointer": "/speed_rpm", **axis}]}
    problem = is_problem(client.post("/v1/sweeps", json=sweep), 422, "invalid-request")
    assert [each["pointer"] for each in problem["errors"]] == [pointer]


def test_what_is_too_large_is_refused_before_any_work(client: httpx2.Client) -> None:
    most = client.get("/v1/limits").json()["server"]["max_sweep_items"]
    axes = [
        {"kind": "range", "pointer": pointer, "start": 10, "stop": 20, "count": count}
        for pointer, count in (("/speed_rpm", most), ("/limits/0/rise_deg", 2))
    ]
    answer = client.post("/v1/sweeps", json={"base": spec(), "axes": axes})
    (found,) = is_problem(answer, 422, "invalid-request")["errors"]
    assert (found["pointer"], found["value"]) == ("/axes", 2 * most)
    assert str(most) in found["rule"]


def test_watching_goes_on_where_it_was_left(client: httpx2.Client) -> None:
    where = posted(client, sweep_of([f"sleep 0.0{i % 7}" + " " * i for i in range(40)]))
    live = events(client, where)
    reported = [event for event in live if event["event"] == "item"]
    assert sorted(event["data"]["number"] for event in reported) == list(range(40))
    assert live[-1]["event"] == "end"
    assert live[-1]["data"]["counts"]["done"] == 40
    shares = [event["data"]["progress"] for event in live if event["event"] == "progress"]
    assert shares == sorted(shares)
    later = events(client, where, **{"Last-Event-ID": reported[24]["id"]})
    assert [event["id"] for event in later[:-1]] == [event["id"] for event in reported[25:]]


@pytest.mark.parametrize("long", ["look", "sleep"])
def test_a_sweep_is_stopped_in_the_middle_of_its_items(
    service: Running, long: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An item that looks at the clock ends there, and its worker stays; another one's does not.

    What of a chunk is done is kept, nothing after the answer; asked again, the sweep goes on.
    """
    client = service.client
    if long == "look":
        monkeypatch.setattr(engine, "CANCEL_S", 50.0)  # however busy the machine is
    wait_until_idle(client)
    workers = children(os.getpid())
    endless = [f"{long} 3600{' ' * i}" for i in range(20)]
    where = posted(client, sweep_of(["quick", *endless], base=spec(time_budget_s=300)))
    while not client.get(where).json()["counts"]["done"]:
        time.sleep(0.02)
    started = time.monotonic()
    answer = client.delete(where)
    took = time.monotonic() - started
    print(f"{long}: stopped within {took:.2f} s")
    assert answer.status_code == 200
    stopped = answer.json()
    assert (stopped["state"], stopped["counts"]["done"]) == ("dismissed", 1)
    assert took < 60.0
    wait_until_idle(client)
    assert client.get(where).json() == stopped
    assert (set(workers) == set(children(os.getpid()))) == (long == "look")


def test_a_sweep_that_was_stopped_goes_on(service: Running, tmp_path: Path) -> None:
    client, gate = service.client, Gate(tmp_path / "gate")
    body = sweep_of(gate.names(36))
    where = posted(client, body)
    gate.let(8)
    while client.get(where).json()["counts"]["done"] < 2:
        time.sleep(0.02)
    stopped = client.delete(where).json()
    assert 2 <= stopped["counts"]["done"] <= 8
    assert len(items_at(client, where)) == stopped["counts"]["done"]
    gate.open()
    assert posted(client, body) == where
    counted(over(client, where), items=36, done=36, optimal=36)
    assert len({item["number"] for item in items_at(client, where)}) == 36


def test_a_sweep_that_is_over_is_discarded_with_its_items(client: httpx2.Client) -> None:
    where = posted(client, sweep_of(["one", "two"]))
    over(client, where)
    design = client.get(f"{where}/items/0").json()["links"]["design"]
    reported = is_problem(client.delete(design), 409, "part-of-sweep")["detail"]
    assert f"item 0 of sweep {where.rpartition('/')[2]}" in reported
    assert f"DELETE {where} " in reported
    assert client.get(design).status_code == 200
    assert client.delete(where).status_code == 204
    for gone in (where, f"{where}/items", f"{where}/items/0", f"{where}/events"):
        is_problem(client.get(gone), 404, "unknown-sweep")
    is_problem(client.get(design), 404, "unknown-design")
    is_problem(client.delete(where), 404, "unknown-sweep")


@pytest.mark.parametrize("query", ["limit=0", "cursor=%25", "status=done"])
def test_wrong_questions_about_items(client: httpx2.Client, query: str) -> None:
    where = posted(client, sweep_of(["asked wrongly"]))
    is_problem(client.get(f"{where}/items?{query}"), 422, "invalid-parameter")


def test_tables_hold_every_item_as_it_is(client: httpx2.Client) -> None:
    axes = [
        {"kind": "list", "pointer": "/name", "values": ["a, b", 'c "d"', "solver"]},
        {"kind": "range", "pointer": "/limits/0/rise_deg", "start": 20, "stop": 40, "count": 167},
    ]
    where = posted(client, {"name": "table", "base": spec(), "axes": axes})
    counted(over(client, where), items=501, done=501, optimal=334, failed=167)
    answer = client.get(f"{where}/items.csv")
    assert answer.headers["content-disposition"] == 'attachment; filename="table-items.csv"'
    rows = list(csv.DictReader(io.StringIO(answer.text)))
    assert [int(row["number"]) for row in rows] == list(range(501))
    from pyarrow import parquet

    frame = parquet.read_table(io.BytesIO(client.get(f"{where}/items.parquet").content))
    assert frame.num_rows == 501
    assert frame.column_names == list(rows[0])
    items = {item["number"]: item for item in items_at(client, where, limit=1000)}
    for row, other in zip(rows, frame.to_pylist(), strict=True):
        item = items[int(row["number"])]
        assert row["status"] == other["status"] == item["status"]
        assert row["severity"] == other["severity"] == item["severity"]
        assert row["/name"] == other["/name"] == item["values"]["/name"]
        for name, value in {**item["values"], **item["quantities"]}.items():
            if name != "/name":
                assert float(row[name]) == other[name] == value
        failed = item["problem"] is not None
        assert (
            row["problem"]
            == (other["problem"] or "")
            == (item["problem"]["detail"] if failed else "")
        )
        assert (row["base_radius_mm"] == "") == (other["base_radius_mm"] is None) == failed


def test_the_front_of_a_sweep(client: httpx2.Client) -> None:
    """The fake core's cams are all alike, but for the values that the name asks for."""
    names = [f"sized {2.5 * a} {b}" for a, b in ((1, 9), (2, 4), (3, 4), (4, 1), (5, 2), (2, 4))]
    where = posted(client, sweep_of([*names, "solver"]))
    over(client, where)
    query = {"minimise": ["base_radius_mm", "offset_mm"]}
    front = client.get(f"{where}/pareto", params=query).json()
    assert (front["compared"], front["excluded"], front["size"]) == (6, 1, 4)
    assert [item["number"] for item in front["items"]] == [0, 1, 5, 3]
    coarse = client.get(f"{where}/pareto", params={**query, "tolerance": 0.8}).json()
    assert (coarse["size"], coarse["indistinct"]) == (2, 2)
    assert [item["number"] for item in coarse["items"]] == [1, 5]  # alike: both stay
    query = {"minimise": "offset_mm", "maximise": "base_radius_mm", "limit": "1"}
    front = client.get(f"{where}/pareto", params=query).json()
    assert front["axes"][1] == {"quantity": "base_radius_mm", "direction": "maximise"}
    assert front["size"] == 2
    assert [item["number"] for item in front["items"]] == [3]
    drawn = client.get(f"{where}/pareto.svg", params={**query, "theme": "print"})
    assert drawn.headers["content-type"] == "image/svg+xml"
    assert drawn.headers["content-disposition"] == 'inline; filename="many-pareto.svg"'
    assert "6 certified designs, 2 of them on the front" in drawn.text
    assert "not shown: 1 failed" in drawn.text
    same = {"If-None-Match": drawn.headers["etag"]}
    again = client.get(f"{where}/pareto.svg", params={**query, "theme": "print"}, headers=same)
    assert again.status_code == 304
    pixels = client.get(f"{where}/pareto.png", params={**query, "width_px": 431})
    assert pixels.headers["content-type"] == "image/png"
    assert pixels.content[:8] == b"\x89PNG\r\n\x1a\n"
    assert int.from_bytes(pixels.content[16:20], "big") == 431  # IHDR
    assert is_problem(
        client.get(f"{where}/pareto.png", params={**query, "width_px": 7}), 422, "invalid-parameter"
    )
    alone = client.get(f"{where}/pareto.svg?minimise=offset_mm")
    assert "Name two to 4" in is_problem(alone, 422, "invalid-parameter")["detail"]


@pytest.mark.parametrize(
    "query", ["", "minimise=weight_kg", "minimise=offset_mm&maximise=offset_mm"]
)
def test_a_front_of_nothing_is_refused_with_what_there_is(
    client: httpx2.Client, query: str
) -> None:
    where = posted(client, sweep_of(["for a front"]))
    over(client, where)
    problem = is_problem(client.get(f"{where}/pareto?{query}"), 422, "invalid-parameter")
    assert "base_radius_mm" in problem["detail"] or "twice" in problem["detail"]
