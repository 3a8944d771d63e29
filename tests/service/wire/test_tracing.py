"""One trace from a caller's request to the stages of the core, sent to a collector."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from typing import Any

import httpx2
import pytest

from service.wire.tracing import span, traceparent
from tests.service.specs import spec

TRACE, CALLER = "0af7651916cd43dd8448eb211c80319c", "b7ad6b7169203331"


class Collector(BaseHTTPRequestHandler):
    """Takes what an exporter sends by OTLP over HTTP."""

    bodies: list[bytes]

    def do_POST(self) -> None:
        self.bodies.append(self.rfile.read(int(self.headers["Content-Length"])))
        self.send_response(200)
        self.end_headers()

    def log_message(self, format: str, *args: Any) -> None:
        """Nothing."""


@pytest.fixture
def collector() -> Iterator[tuple[str, list[bytes]]]:
    bodies: list[bytes] = []
    server = HTTPServer(("127.0.0.1", 0), type("Own", (Collector,), {"bodies": bodies}))
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield f"http://127.0.0.1:{server.server_port}", bodies
    server.shutdown()
    thread.join()
    server.server_close()


def test_one_trace_from_the_request_to_a_stage(
    collector: tuple[str, list[bytes]], tmp_path: Path
) -> None:
    messages = pytest.importorskip("opentelemetry.proto.collector.trace.v1.trace_service_pb2")
    address, bodies = collector
    own = {
        "CAMWRIGHT_PORT": "0",
        "CAMWRIGHT_DATABASE_URL": f"sqlite:///{tmp_path}/designs.db",
        "CAMWRIGHT_WORKERS": "1",
        "OTEL_EXPORTER_OTLP_ENDPOINT": address,
    }
    command = [sys.executable, "-m", "service"]
    with (
        (tmp_path / "log").open("w") as log,
        subprocess.Popen(
            command, env=os.environ | own, stdout=subprocess.PIPE, stderr=log, text=True
        ) as service,
    ):
        assert service.stdout is not None
        url = next(line.split()[1] for line in service.stdout if " start " in line)
        with httpx2.Client(base_url=url.rstrip("/"), timeout=60.0) as client:
            caller = {"traceparent": f"00-{TRACE}-{CALLER}-01", "X-Request-ID": "job-17"}
            made = client.post("/v1/designs", json=spec("traced"), headers=caller)
            assert made.status_code == 200
            stages = [each["stage"] for each in made.json()["report"]["stages"]]
            file = client.get(made.json()["links"]["profile.csv"], headers=caller)
            assert file.status_code == 200
            client.get("/livez", headers=caller)
            page = client.get("/metrics").text
        service.terminate()  # what was not sent yet is sent at the end

    assert stages
    assert 'camwright_stage_seconds_count{stage="convex"}' in page
    spans = {}
    for body in bodies:
        for resource in messages.ExportTraceServiceRequest.FromString(body).resource_spans:
            named = {each.key: each.value.string_value for each in resource.resource.attributes}
            assert named["service.name"] == "camwright"
            for scope in resource.scope_spans:
                spans |= {each.span_id: each for each in scope.spans}
    ours = {key: each for key, each in spans.items() if each.trace_id.hex() == TRACE}

    def path(each: Any) -> tuple[str, ...]:
        above = ours.get(each.parent_span_id)
        if above is None:
            assert each.parent_span_id.hex() == CALLER
            return (each.name,)
        assert above.start_time_unix_nano <= each.start_time_unix_nano
        return (*path(above), each.name)

    paths = {path(each) for each in ours.values()}
    post = "POST /v1/designs"
    expected = {
        (post,), (post, "validation"), (post, "store"), (post, "question", "queue"),
        (post, "question", "worker", "core"), (post, "question", "store"),
        *((post, "question", "worker", "core", stage) for stage in stages),
        ("GET /v1/designs/{design_id}/profile.csv", "file"),
    }  # fmt: skip
    assert expected <= paths
    assert not any("/livez" in name for name, *_ in paths)
    text = (tmp_path / "log").read_text(encoding="utf-8")
    line = next(line for line in text.splitlines() if "job-17" in line)
    assert f'"trace_id": "{TRACE}"' in line


def test_nothing_is_recorded_without_a_collector() -> None:
    assert traceparent() == ""
    with span("validation") as nothing:
        assert nothing is None
    code = "import service.app, sys; print(*(m for m in sys.modules if 'telemetry.sdk' in m))"
    came = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert came.stdout.strip() == ""
