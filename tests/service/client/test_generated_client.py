"""A client made from the contract by openapi-python-client: it is made whole, and it works."""

from __future__ import annotations

import importlib
import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from service.contract.examples import SELF_CHECK, examples
from service.openapi import TARGET
from tests.service.conftest import Running

CONFIG = TARGET.with_name("generator.yml")
Found = Callable[[str], ModuleType]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The package, importable. A warning of the generator would mean that something is missing."""
    folder = tmp_path_factory.mktemp("made") / "camwright_client"
    command = [sys.executable, "-m", "openapi_python_client", "generate", "--fail-on-warning"]
    paths = ["--path", str(TARGET), "--config", str(CONFIG), "--output-path", str(folder)]
    run = subprocess.run(
        [*command, *paths, "--meta", "none"], capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stdout + run.stderr
    sys.path.insert(0, str(folder.parent))
    yield folder
    sys.path.remove(str(folder.parent))
    for name in [name for name in sys.modules if name.partition(".")[0] == folder.name]:
        del sys.modules[name]


@pytest.fixture(scope="module")
def found(made: Path) -> Found:
    return lambda name: importlib.import_module(f"{made.name}.{name}")


@pytest.fixture(scope="module")
def client(found: Found, real_service: Running) -> Iterator[Any]:
    with found("client").Client(base_url=real_service.url, timeout=120.0) as opened:
        yield opened


def spec_for_design() -> dict[str, Any]:
    spec: dict[str, Any] = json.loads(json.dumps(examples()[SELF_CHECK]["value"]))
    return spec


def test_every_operation_has_a_function(made: Path) -> None:
    document = json.loads(TARGET.read_text(encoding="utf-8"))
    paths = document["paths"].values()
    wanted = {operation["operationId"] for methods in paths for operation in methods.values()}
    functions = {path.stem for path in (made / "api").glob("*/*.py")} - {"__init__"}
    assert functions == wanted
    models = set(document["components"]["schemas"])
    enough = {"DesignSpec", "Design", "Sweep", "SweepSpec", "Problem", "Analysis"}
    assert enough <= models
    for name in ("DesignSpec", "SweepSpec", "TranslatingRoller", "OscillatingRoller"):
        assert any(f"class {name}:" in path.read_text() for path in (made / "models").glob("*.py"))


def test_a_design_and_its_files(found: Found, client: Any) -> None:
    models, spec = found("models"), spec_for_design()
    question = models.DesignSpec.from_dict(spec)
    assert question.to_dict()["program"] == spec["program"]
    design = found("api.designs.create_design").sync(client=client, body=question)
    assert type(design).__name__ == "Design"
    assert design.certificate.certified
    again = found("api.designs.get_design").sync(design.id, client=client)
    assert again.to_dict() == design.to_dict()
    asked_for = {"client": client, "points_per_degree": 2.0}
    table = found("api.files.get_profile_csv").sync(design.id, **asked_for)
    assert len(table.splitlines()) > 720
    assert found("api.files.get_profile_svg").sync(design.id, client=client).startswith("<")
    listed = found("api.designs.list_designs").sync(client=client, limit=200)
    assert design.id in [line.id for line in listed.items]


def test_an_analysis(found: Found, client: Any) -> None:
    body = next(iter(examples("analyses").values()))["value"]
    question = found("models").DesignSpec.from_dict(body)
    analysis = found("api.analyses.create_analysis").sync(client=client, body=question)
    assert type(analysis).__name__ == "Analysis"
    assert analysis.holds in (True, False)


def test_a_problem_is_a_problem(found: Found, client: Any) -> None:
    spec = spec_for_design() | {"speed_rpm": -3.0}
    question = found("models").DesignSpec.from_dict(spec)
    answer = found("api.designs.create_design").sync_detailed(client=client, body=question)
    assert answer.status_code == 422
    assert type(answer.parsed).__name__ == "Problem"
    assert answer.parsed.errors[0].pointer == "/speed_rpm"


def test_a_sweep_its_items_and_its_tables(found: Found, client: Any) -> None:
    axis = {"kind": "range", "pointer": "/limits/0/rise_deg", "start": 24, "stop": 34, "count": 5}
    body = {"name": "generated", "base": spec_for_design(), "axes": [axis]}
    sweeps, question = "api.sweeps", found("models").SweepSpec.from_dict(body)
    sweep = found(f"{sweeps}.create_sweep").sync(client=client, body=question)
    while sweep.state in ("accepted", "running"):
        time.sleep(0.1)
        sweep = found(f"{sweeps}.get_sweep").sync(sweep.id, client=client)
    assert (sweep.state, sweep.counts.done) == ("successful", 5)
    page = found(f"{sweeps}.list_sweep_items").sync(sweep.id, client=client, limit=3)
    assert len(page.items) == 3
    rest = found(f"{sweeps}.list_sweep_items").sync(sweep.id, client=client, cursor=page.next_)
    items = sorted([*page.items, *rest.items], key=lambda item: item.number)
    assert [item.values["/limits/0/rise_deg"] for item in items] == [24.0, 26.5, 29.0, 31.5, 34.0]
    radii = [item.quantities["base_radius_mm"] for item in items]
    assert radii == sorted(radii, reverse=True)  # a steeper cam may be smaller
    table = found(f"{sweeps}.get_sweep_items_csv").sync(sweep.id, client=client)
    assert len(table.splitlines()) == 6
    file = found(f"{sweeps}.get_sweep_items_parquet").sync(sweep.id, client=client)
    assert file.payload.read(4) == b"PAR1"
    wanted = {"minimise": ["base_radius_mm"], "maximise": []}
    front = found(f"{sweeps}.get_sweep_pareto").sync(sweep.id, client=client, **wanted)
    assert [item.number for item in front.items] == [4]
