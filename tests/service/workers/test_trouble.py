"""When things go wrong: workers die, time runs out, too many ask at once. The service goes on."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import httpx2
import pytest

from tests.service.conftest import Running, settings_for, wait_until, wait_until_idle
from tests.service.fake_core import Gate
from tests.service.specs import spec


def post(client: httpx2.Client, body: dict[str, Any]) -> httpx2.Response:
    return client.post("/v1/designs", json=body)


def is_problem(answer: httpx2.Response, status: int, slug: str) -> dict[str, Any]:
    assert answer.status_code == status, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    body: dict[str, Any] = answer.json()
    assert (body["type"], body["status"]) == (f"/problems/{slug}", status)
    assert body["instance"] == answer.url.path
    assert body["request_id"] == answer.headers["x-request-id"]
    assert body["detail"]
    return body


def test_a_worker_killed_at_work_costs_one_design(service: Running) -> None:
    with ThreadPoolExecutor(2) as pool:
        dying = pool.submit(post, service.client, spec("die 0.5"))
        living = pool.submit(post, service.client, spec("sleep 1.0"))
        is_problem(dying.result(), 503, "worker-lost")
        assert dying.result().headers["retry-after"]
        assert living.result().status_code == 200
    assert post(service.client, spec("next")).status_code == 200


def test_the_time_budget_ends_with_the_best_so_far(client: httpx2.Client) -> None:
    body = is_problem(post(client, spec("best")), 504, "time-budget")
    assert body["best"]["dimensions"]["base_radius_mm"] == 50.0
    assert "best" not in is_problem(post(client, spec("empty")), 504, "time-budget")


def test_a_worker_that_overruns_is_stopped_and_its_place_is_used_again(service: Running) -> None:
    with ThreadPoolExecutor(2) as pool:
        bodies = [spec("sleep 3600", time_budget_s=0.3) for _ in range(2)]
        for answer in pool.map(lambda body: post(service.client, body), bodies):
            is_problem(answer, 504, "time-budget")
    with ThreadPoolExecutor(2) as pool:
        bodies = [spec("again") for _ in range(4)]
        answers = pool.map(lambda body: post(service.client, body), bodies)
        assert {answer.status_code for answer in answers} == {200}


def test_faults_of_ours_say_nothing_of_the_inside(client: httpx2.Client) -> None:
    answer = post(client, spec("bug"))
    is_problem(answer, 500, "internal")
    assert "secret" not in answer.text
    assert "Traceback" not in answer.text
    is_problem(post(client, spec("solver")), 500, "solver-failed")


def test_twenty_at_once(tmp_path: Path) -> None:
    settings = settings_for(tmp_path, workers=1)
    with Running(settings, real=False) as service, ThreadPoolExecutor(20) as pool:
        bodies = [spec("sleep 0.05") for _ in range(20)]
        answers = list(pool.map(lambda body: post(service.client, body), bodies))
        assert {answer.status_code for answer in answers} == {200}
        assert len({answer.json()["id"] for answer in answers}) == 20
        same = spec("sleep 0.3")
        answers = list(pool.map(lambda _: post(service.client, same), range(20)))
        assert len({answer.content for answer in answers}) == 1
        solved = 'camwright_solve_seconds_count{status="optimal"} 21.0'
        assert solved in service.client.get("/metrics").text.splitlines()


def test_too_many_waiting_are_told_when_to_come_back(service: Running, tmp_path: Path) -> None:
    client, later, gate = service.client, {"Prefer": "respond-async"}, Gate(tmp_path / "gate")
    wait_until_idle(client)
    bodies = [spec(name) for name in gate.names(2 + 4)]
    for body in bodies:
        assert client.post("/v1/designs", json=body, headers=later).status_code == 202
    wait_until(client, running=2, waiting=4)
    for headers in ({}, later):
        answer = client.post("/v1/designs", json=spec("one more"), headers=headers)
        is_problem(answer, 429, "busy")
        assert int(answer.headers["retry-after"]) > 0
    gate.open()
    assert post(client, bodies[0]).status_code == 200
    assert post(client, spec("one more")).status_code == 200


def test_what_was_accepted_outlives_the_process(tmp_path: Path) -> None:
    settings, gate = settings_for(tmp_path, workers=1), Gate(tmp_path / "gate")
    (name,) = gate.names(1)
    body = spec(name)
    with Running(settings, real=False) as service:
        answer = service.client.post("/v1/designs", json=body, headers={"Prefer": "respond-async"})
        where = answer.headers["location"]
    with Running(settings, real=False) as service:
        assert service.client.get(where).status_code == 202
        gate.open()
        assert post(service.client, body).status_code == 200
        assert service.client.get(where).status_code == 200


@pytest.mark.parametrize(
    ("method", "path", "status", "slug"),
    [
        ("GET", "/nowhere", 404, "not-found"),
        ("GET", "/v1/designs/0000", 404, "unknown-design"),
        ("GET", "/v1/designs/0000/profile.csv", 404, "unknown-design"),
        ("DELETE", "/v1/designs/%00%F0%9F%92%A5", 404, "unknown-design"),
        ("GET", "/v1/cam-sets/0000", 404, "unknown-cam-set"),
        ("GET", "/v1/cam-sets/0000/bundle.zip", 404, "unknown-cam-set"),
        ("GET", "/v1/cam-sets/0000/timing.svg", 404, "unknown-cam-set"),
        ("DELETE", "/v1/cam-sets/0000", 404, "unknown-cam-set"),
        ("GET", "/v1/cam-sets?cursor=%25%25", 422, "invalid-parameter"),
        ("PUT", "/v1/cam-sets", 405, "method-not-allowed"),
        ("PUT", "/v1/designs", 405, "method-not-allowed"),
        ("POST", "/v1/limits", 405, "method-not-allowed"),
        ("GET", "/v1/designs?limit=0", 422, "invalid-parameter"),
        ("GET", "/v1/designs?cursor=%25%25", 422, "invalid-parameter"),
        ("GET", "/v1/designs/0000/profile.csv?points_per_degree=NaN", 422, "invalid-parameter"),
        ("GET", "/v1/designs/0000/profile.csv?curve=shadow", 422, "invalid-parameter"),
        ("GET", "/v1/designs/0000/profile.csv?cutter_diameter_mm=5", 422, "invalid-parameter"),
        ("GET", "/v1/designs/0000/profile.txt?points=1000000000", 422, "invalid-parameter"),
        ("GET", "/v1/designs/0000/motion.csv?tolerance_um=1", 422, "invalid-parameter"),
        ("GET", "/problems/none", 404, "not-found"),
    ],
)
def test_everything_else_is_a_problem_document_too(
    client: httpx2.Client, method: str, path: str, status: int, slug: str
) -> None:
    answer = client.request(method, path)
    body = is_problem(answer, status, slug)
    if status == 405:
        assert answer.headers["allow"]
    for entry in body.get("errors", []):
        assert entry["parameter"] in path
        assert entry["rule"]
        assert entry["remedy"]


def test_every_kind_of_problem_is_explained_where_its_type_leads(client: httpx2.Client) -> None:
    kind = post(client, spec("bug")).json()["type"]
    assert client.get(kind).json()["title"]
