"""For those who run the service: probes, metrics, request ids, logs, CORS."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path

import httpx2
import pytest

import service
from service.app import create_app
from service.settings import Settings
from service.wire.errors import ProblemType
from synthesis.design.identity import ENGINE_NUMBER, engine_version
from tests.service.conftest import settings_for, wait_until_idle
from tests.service.specs import spec

SERVICE = Path(service.__file__).parent


def test_probes(client: httpx2.Client) -> None:
    assert client.get("/livez").json() == {"status": "alive"}
    wait_until_idle(client)
    assert client.get("/readyz").json() == {"ready": True, "store": True, "workers": 2}
    version = client.get("/v1/version").json()
    assert version["version"] == engine_version()
    assert version["engine"] == ENGINE_NUMBER


def test_metrics_count_by_route_and_not_by_path(client: httpx2.Client) -> None:
    client.post("/v1/designs", json=spec("counted"))
    wait_until_idle(client)
    client.get("/v1/designs/no-such-design")
    client.get("/some/where")
    page = client.get("/metrics").text
    for line in (
        'camwright_http_requests_total{method="GET",route="/v1/designs/{design_id}",status="404"}',
        'camwright_http_requests_total{method="GET",route="unmatched",status="404"}',
        'camwright_http_requests_total{method="POST",route="/v1/designs",status="200"}',
        'camwright_http_request_seconds_bucket{le="0.01",route="/v1/designs"}',
        'camwright_solve_seconds_count{status="optimal"}',
        'camwright_designs{status="optimal"}',
        "camwright_designs_waiting 0.0",
        "camwright_workers 2.0",
    ):
        assert line in page, line
    assert "no-such-design" not in page


@pytest.mark.parametrize(
    ("given", "kept"), [("job-17:b", True), ("", False), ("x" * 99, False), ("a b", False)]
)
def test_request_ids(client: httpx2.Client, given: str, kept: bool) -> None:
    answer = client.get("/livez", headers={"X-Request-ID": given})
    assert (answer.headers["x-request-id"] == given) is kept


def test_every_problem_has_its_page(client: httpx2.Client) -> None:
    for kind in ProblemType:
        page = client.get(f"/problems/{kind.slug}").json()
        assert (page["status"], page["title"]) == (kind.status, kind.title)
        assert page["meaning"]


def test_catalogue(client: httpx2.Client) -> None:
    laws = {law["kind"]: law for law in client.get("/v1/motion-laws").json()}
    assert laws["cycloidal"]["characteristics"]["Cv"] == pytest.approx(2.0)
    assert {"spline", "parabolic", "polynomial_3_4_5"} <= set(laws)
    assert client.get("/v1/followers").json()[0]["kind"] == "translating_roller"
    formats = client.get("/v1/formats").json()
    assert {"json", "csv", "txt", "svg"} <= {each["name"] for each in formats["profile"]}
    limits = client.get("/v1/limits").json()
    assert {"pressure_angle", "jerk"} <= {each["kind"] for each in limits["limits"]}
    assert limits["server"]["max_body_bytes"] == 1_048_576
    assert limits["server"]["workers"] == 2


def test_other_origins_only_where_allowed(client: httpx2.Client, tmp_path: Path) -> None:
    origin = {"Origin": "https://cad.example"}
    assert "access-control-allow-origin" not in client.get("/livez", headers=origin).headers
    app = create_app(settings_for(tmp_path, cors_origins=["https://cad.example"]))

    async def reported() -> None:  # without workers: none is needed for that
        transport = httpx2.ASGITransport(app=app)
        async with httpx2.AsyncClient(transport=transport, base_url="http://127.0.0.1") as other:
            answer = await other.get("/livez", headers=origin)
            assert answer.headers["access-control-allow-origin"] == "https://cad.example"
            question = {**origin, "Access-Control-Request-Method": "POST"}
            assert (await other.options("/v1/designs", headers=question)).status_code == 200

    asyncio.run(reported())


def test_settings_come_from_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CAMWRIGHT_PORT", "9001")
    monkeypatch.setenv("CAMWRIGHT_CORS_ORIGINS", json.dumps(["https://a.example"]))
    settings = Settings()
    assert (settings.host, settings.port) == ("127.0.0.1", 9001)
    assert settings.cors_origins == ["https://a.example"]
    assert settings.budget_s(None) == 30.0
    assert settings.budget_s(10_000.0) == settings.max_time_budget_s


def test_dask_is_behind_the_engine() -> None:
    texts = [(path.name, path.read_text("utf-8")) for path in SERVICE.rglob("*.py")]

    def users(*words: str) -> list[str]:
        return sorted(name for name, text in texts if any(word in text for word in words))

    assert users("from distributed", "import dask") == ["remote.py", "scheduler.py"]
    assert users("workers.remote import") == ["engine.py", "scheduler.py"]
