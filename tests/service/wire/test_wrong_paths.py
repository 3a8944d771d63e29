"""Paths, methods and parameters that are wrong: what there is instead, and what to write."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace
from typing import Any

import httpx2
import pytest

from service.client import Refused
from service.resources.quotas import UsedQuotas
from service.routes.files import make_in_worker
from service.state import NOBODY
from service.wire.errors import ProblemType, ServiceError
from service.wire.fair_queue import FairQueue
from synthesis.errors import TimeBudgetExceeded
from tests.service.specs import spec


@pytest.fixture(scope="module")
def design(service: Any) -> str:
    """The path of a design that is done."""
    return str(service.client.post("/v1/designs", json=spec()).headers["content-location"])


@pytest.mark.parametrize(
    ("query", "words"),
    [
        ("density=4", "density is not a parameter here. Write points_per_degree=4."),
        ("density=abc", "Write points_per_degree instead of density."),
        ("points_per_degree=abc", "must be a number. Give a number. Points per degree"),
        ("points_per_degree=1e9", "must be greater than 0 and at most 100. Write a number within"),
        ("tolerance_mm=0.01", "Write tolerance_um=10 (0.01 mm)."),
        ("points=12.5", "must be a whole number. Write 12, for example."),
        ("curve=Pitch", "Write pitch."),
        ("turn=20", "Write turn_deg=20."),
        ("z_mm=3 mm", "Write 3, without a unit."),
        ("colour=red", "Allowed: "),
    ],
)
def test_a_files_parameters(client: httpx2.Client, design: str, query: str, words: str) -> None:
    answer = client.get(f"{design}/profile.csv?{query}")
    assert answer.status_code == 422
    problem = answer.json()
    assert words in problem["detail"], problem["detail"]
    (error,) = problem["errors"]
    assert error["parameter"] == query.partition("=")[0]


def test_a_format_that_there_is_not(client: httpx2.Client, design: str) -> None:
    detail = client.get(f"{design}/profile.cvs").json()["detail"]
    assert "Did you mean 'profile.csv'? There are: " in detail
    assert "profile.dxf, " in detail
    assert "report.html" in detail


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("/designs", "Did you mean '/v1/designs'?"),
        ("/v1/design", "Did you mean 'designs'? There are: analyses, cam-sets, "),
        ("/v1/linkages/shapers", "Did you mean 'six-bar-shapers'?"),
        ("/nothing/of/the/kind", "See /docs for what there is."),
    ],
)
def test_a_path_that_leads_nowhere(client: httpx2.Client, path: str, words: str) -> None:
    answer = client.get(path)
    assert answer.status_code == 404
    assert words in answer.json()["detail"]


def test_a_method_that_a_path_has_not(client: httpx2.Client) -> None:
    answer = client.put("/v1/designs", json={})
    assert answer.headers["allow"] == "GET, HEAD, POST"
    assert answer.json()["detail"].endswith("It has GET, HEAD, POST.")


def test_a_number_of_a_list(client: httpx2.Client) -> None:
    detail = client.get("/v1/designs?limit=1000").json()["detail"]
    assert detail.startswith("limit must be at most 200. Write a number within that.")


@pytest.mark.parametrize(
    ("raised", "problem", "words"),
    [
        (TimeBudgetExceeded(30.0), ProblemType.TIME_BUDGET, "solid.step took longer than 30 s"),
        (
            ProblemType.WORKER_LOST("The process working on it died.", {"Retry-After": "2"}),
            ProblemType.WORKER_LOST, "The process that made solid.step died",
        ),
    ],
    ids=["time", "memory"],
)  # fmt: skip
def test_a_file_that_is_not_made_says_where_to_get_it_later(
    raised: Exception, problem: ProblemType, words: str
) -> None:
    """The design's own error would speak of a tolerance that was not reached."""

    async def run(*_: Any, **__: Any) -> None:
        raise raised

    engine = SimpleNamespace(queue=FairQueue(lambda: 1), run=run)
    parts: Any = SimpleNamespace(
        engine=engine, settings=SimpleNamespace(budget_s=lambda _: 30.0),
        quotas=UsedQuotas(SimpleNamespace(do=None)), caller=NOBODY,  # type: ignore[arg-type]
    )  # fmt: skip
    url = SimpleNamespace(path="/v1/designs/abc/solid.step", query="tolerance_um=1")
    request: Any = SimpleNamespace(url=url)
    with pytest.raises(ServiceError) as refused:
        asyncio.run(make_in_worker(request, parts, lambda: None))
    assert refused.value.problem is problem
    assert refused.value.headers == getattr(raised, "headers", {})
    text = str(refused.value)
    assert words in text
    assert "again by GET /v1/designs/abc/solid.step?tolerance_um=1, when less is going on" in text
    assert "tolerance was reached" not in text


def test_the_client_tells_every_error() -> None:
    errors = [
        {"pointer": "/rpm", "value": 1, "rule": "is not a field here", "remedy": "Write …"},
        {"pointer": "", "value": 1, "rule": "is wrong.", "remedy": "Mend it."},
    ]
    refused = Refused({"detail": "Two are wrong.", "errors": errors}, 422)
    assert str(refused).splitlines() == [
        "Two are wrong.", "/rpm: is not a field here. Write …", "the body: is wrong. Mend it.",
    ]  # fmt: skip
    assert str(Refused({"detail": "One is wrong.", "errors": errors[:1]}, 422)) == "One is wrong."
