"""The deployment: the compose file's words are true, and what it starts works together."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import dask
import httpx2
import pytest

from service.client import Client
from service.contract.examples import SELF_CHECK, examples
from service.settings import Settings
from tests.lazy import LazyModule
from tests.service.killing import ROOT, Process, answering, free_port
from tests.service.postgres import PASSWORD, postgres
from tests.service.sweeps.test_kills import until
from tests.service.topology import (
    COMPOSE,
    DOCKERFILE,
    SECRET,
    SERVICES,
    Topology,
    without_variables,
)

psycopg = LazyModule("psycopg")

ITEMS = 60


def test_every_variable_is_a_setting() -> None:
    known = {f"CAMWRIGHT_{name.upper()}" for name in Settings.model_fields}
    used = {
        name for service in SERVICES.values() for name in service.get("environment", {})
        if name.startswith("CAMWRIGHT_")
    }  # fmt: skip
    assert used | set(re.findall(r"CAMWRIGHT_\w+(?==)", DOCKERFILE)) <= known
    assert {"CAMWRIGHT_DATABASE_URL", "CAMWRIGHT_SCHEDULER"} <= used
    api = {key.removeprefix("CAMWRIGHT_").lower(): without_variables(value)
           for key, value in SERVICES["api"]["environment"].items()
           if key.startswith("CAMWRIGHT_")}  # fmt: skip
    settings = Settings.model_validate(api)
    # Without keys as long as this machine alone reaches it, and said so.
    (port,) = SERVICES["api"]["ports"]
    assert without_variables(port) == "127.0.0.1:8000:8000"
    assert (settings.access, settings.reaches_others) == ("open-to-anyone", True)
    database = SERVICES["database"]["environment"]
    assert settings.database.username == database["POSTGRES_USER"]
    assert settings.database.database == database["POSTGRES_DB"]
    assert settings.database.password == SECRET.sub(PASSWORD, database["POSTGRES_PASSWORD"])


@pytest.mark.parametrize("name", ["api", "scheduler", "worker"])
def test_who_speaks_to_the_cluster_shows_its_certificate(name: str) -> None:
    """Dask reads its settings from variables, and finds one file for all that it asks for."""
    declared = dask.config.collect_env(SERVICES[name]["environment"])["distributed"]["comm"]
    assert declared["require_encryption"] is True
    roles = {role: entry["cert"] for role, entry in declared["tls"].items() if role != "ca_file"}
    assert roles.keys() == {"client", "scheduler", "worker"}
    assert {*roles.values()} == {declared["tls"]["ca_file"]}
    folder, _, _ = declared["tls"]["ca_file"].rpartition("/")
    (volume,) = SERVICES[name]["volumes"]
    assert volume.split(":")[1:] == [folder, *(() if name == "scheduler" else ("ro",))]


@pytest.mark.parametrize("name", SERVICES)
def test_every_service_is_limited_restarted_and_checked(name: str) -> None:
    service = SERVICES[name]
    limits = service["deploy"]["resources"]["limits"]
    assert float(limits["cpus"]) > 0
    assert limits["memory"].endswith("G")
    assert service["restart"] == "unless-stopped"
    check = service.get("healthcheck", {})
    assert check.get("test") or name == "api"  # the image's own
    assert not check.get("disable")


def test_only_the_api_is_reachable_and_everything_is_on_a_declared_network() -> None:
    assert [name for name, service in SERVICES.items() if "ports" in service] == ["api"]
    for service in SERVICES.values():
        assert set(service["networks"]) <= set(COMPOSE["networks"])
        assert set(service.get("depends_on", {})) <= set(SERVICES)
    assert COMPOSE["networks"]["inside"]["internal"] is True
    worker = " ".join(SERVICES["worker"]["command"])
    memory = re.search(r"--memory-limit=(\d+)MiB", worker)
    assert memory is not None
    limit = SERVICES["worker"]["deploy"]["resources"]["limits"]["memory"]
    assert int(memory.group(1)) < 1024 * int(limit.removesuffix("G"))


@pytest.fixture
def database() -> Iterator[int]:
    declared = SERVICES["database"]["environment"]
    with postgres(declared["POSTGRES_USER"], declared["POSTGRES_DB"]) as port:
        yield port


def signalled(worker: Process, what: signal.Signals) -> None:
    """As when its container is killed or paused: the keeper and the process that it keeps."""
    os.killpg(worker.running.pid, what)
    if what is signal.SIGKILL:
        worker.running.wait()


def sweep() -> dict[str, Any]:
    base = json.loads(json.dumps(examples()[SELF_CHECK]["value"]))
    axis = {"kind": "range", "pointer": "/limits/0/rise_deg", "start": 22, "stop": 36}
    return {"name": "on many machines", "base": base, "axes": [{**axis, "count": ITEMS}]}


def test_a_sweep_while_workers_come_and_go(database: int, tmp_path: Path) -> None:
    """A third worker joins, the first two die, then the scheduler, then the service.

    Nothing is lost. What Docker would do is done here: whatever has ended is started again, but for
    the first two workers.
    """
    here = Topology(tmp_path, database)
    running = [here.started("scheduler")]
    try:
        until(lambda: here.listens("scheduler"))
        assert here.healthy("scheduler")
        workers = [here.started("worker", f"worker {i}") for i in (1, 2)]
        api = here.started("api")
        running += [*workers, api]
        url = f"http://127.0.0.1:{here.api}"
        with Client(url, timeout_s=180.0) as client, httpx2.Client(base_url=url) as plain:
            answering(plain)
            until(lambda: ready(plain, 2))
            for name in ("worker 1", "worker 2"):
                assert here.healthy("worker", name)
            assert here.healthy("api")
            assert here.healthy("database")
            where = client.sweep(sweep())["links"]["self"]
            until(lambda: done(client, where) >= 8)
            for worker in workers:  # so that a fast machine is not done before the third is there
                signalled(worker, signal.SIGSTOP)
            running.append(here.started("worker", "worker 3"))
            until(lambda: ready(plain, 3))
            signalled(workers[1], signal.SIGCONT)
            signalled(workers[0], signal.SIGKILL)
            assert done(client, where) < ITEMS, "it was over before a worker was killed"
            signalled(workers[1], signal.SIGKILL)
            running[0].kill()
            assert not here.healthy("worker", "worker 1")
            until(lambda: running[-1].running.poll() is not None)  # it has no scheduler any more
            kept = done(client, where)
            for process in running[0], running[-1]:
                process.start()
            until(lambda: done(client, where) > kept)  # the service has found the new scheduler
            api.kill()
            api.start()
            answering(plain)
            assert done(client, where) < ITEMS, "it was over before the service was killed"
            until(lambda: ready(plain, 1))
            over = client.wait(where.rpartition("/")[2])
            assert (over["state"], over["counts"]["failed"]) == ("successful", 0)
            listed = [item["number"] for item in client.items(over["id"])]
        every_item_once(database, listed)
    finally:
        for process in reversed(running):
            process.stop()
    assert not here.healthy("api")
    assert not here.healthy("scheduler")


def every_item_once(port: int, listed: list[int]) -> None:
    """By what the service lists, and by the rows of the database."""
    address = SECRET.sub(PASSWORD, SERVICES["api"]["environment"]["CAMWRIGHT_DATABASE_URL"])
    address = address.replace("+psycopg", "").replace("@database:5432", f"@127.0.0.1:{port}")
    with psycopg.connect(address) as connection:
        rows = [row[0] for row in connection.execute("select number from sweep_items")]
    lost, twice = set(range(ITEMS)) - set(rows), len(rows) - len(set(rows))
    print(f"items expected {ITEMS}, done {len(rows)}, lost {len(lost)}, duplicated {twice}")
    assert sorted(rows) == sorted(listed) == list(range(ITEMS))


def ready(client: httpx2.Client, workers: int) -> bool:
    found = client.get("/readyz").json()
    return bool(found["store"]) and found["workers"] == workers


def done(client: Client, where: str) -> int:
    counts: dict[str, int] = client.get(where)["counts"]
    return counts["done"]


def test_what_a_running_service_needs_is_in_the_image() -> None:
    for folder in ("synthesis", "service", "openapi"):
        assert re.search(rf"^COPY {folder} ", DOCKERFILE, re.M)
        assert (ROOT / folder).is_dir()


def test_our_images_are_built_here_and_may_do_little() -> None:
    ours = [each for name, each in SERVICES.items() if name != "database"]
    assert len(ours) == 3
    for each in ours:
        assert each["build"]["context"] == "."
        assert each["read_only"] is True
        assert each["cap_drop"] == ["ALL"]
        assert each["security_opt"] == ["no-new-privileges:true"]
    assert re.findall(r"^USER (\w+)$", DOCKERFILE, re.M) == ["camwright"]
    # What lies below is named by the operator, by digest if he likes, and nowhere else.
    assert set(re.findall(r"^FROM (\S+)", DOCKERFILE, re.M)) == {"${PYTHON_IMAGE}"}
    assert SERVICES["database"]["image"].startswith("${POSTGRES_IMAGE:-")


def test_it_works_where_it_may_write_nothing_but_its_data(tmp_path: Path) -> None:
    """As in a container that is read-only and has no capabilities: a mount namespace of its own."""
    data, port = tmp_path / "data", free_port()
    data.mkdir()
    alone = ["unshare", "--mount", "sh", "-c"]
    if subprocess.run([*alone, "mount --make-rprivate /"], check=False).returncode:
        pytest.skip("this account may not mount")
    script = (
        f"mount --make-rprivate / && mount --bind {data} {data} && mount -o remount,ro,bind / "
        f"&& ! touch {ROOT}/written && exec setpriv --no-new-privs --bounding-set=-all "
        f"--inh-caps=-all {sys.executable} -m service"
    )
    environment = {
        "PATH": os.environ["PATH"], "PYTHONPATH": str(ROOT), "HOME": str(data), "TMPDIR": str(data),
        "CAMWRIGHT_PORT": str(port), "CAMWRIGHT_DATABASE_URL": f"sqlite:///{data}/camwright.db",
    }  # fmt: skip
    running = subprocess.Popen([*alone, script], cwd=ROOT, env=environment)
    try:
        with httpx2.Client(base_url=f"http://127.0.0.1:{port}", timeout=60.0) as client:
            answering(client)
            assert client.get("/readyz").json()["store"] is True
            designed = client.post("/v1/designs", json=examples()[SELF_CHECK]["value"])
            assert designed.status_code == 200
            for file in ("profile.dxf", "profile.png", "datasheet.pdf", "solid.step"):
                made = client.get(f"{designed.headers['content-location']}/{file}")
                assert made.status_code == 200, file
    finally:
        running.terminate()
        running.wait()
