"""The long checks in small, so that they can be run when they are needed."""

from __future__ import annotations

import asyncio
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from service.cli import app
from tests.service import load
from tests.service.checks import backups, faults, web
from tests.service.checks.clock import HOUR_S, Clock
from tests.service.conftest import Running, settings_for
from tests.service.specs import spec


class InThisProcess(Running):
    """A service that is here at once: what the checks start as a process of its own."""

    def stop(self) -> None:
        self.__exit__()


def started(_folder: Path, port: int, **environment: str) -> InThisProcess:
    url = environment["CAMWRIGHT_DATABASE_URL"]
    running = InThisProcess(settings_for(Path(), port=port, database_url=url), real=False)
    running.__enter__()
    return running


def admin(*words: str) -> None:
    app(["admin", *words], standalone_mode=False)


def test_a_backup_under_load(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(backups, "service", started)
    monkeypatch.setattr(backups, "admin", admin)
    few = ["--singles", "4", "--sweeps", "1", "--items", "4", "--over", "1"]
    monkeypatch.setattr(sys, "argv", ["backups", *few])
    assert backups.main() == 0


def test_a_fault(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    few = {"faults": 1, "singles": 3, "sweeps": 1, "items": 4, "services": 1}
    words = [word for name, number in few.items() for word in (f"--{name}", str(number))]
    monkeypatch.setattr(sys, "argv", ["faults", *words, "--only", "of a worker"])
    assert faults.main() == 0
    said = capsys.readouterr().out
    assert "{'kill -9 of a worker': 1}" in said
    assert "lost 0, doubled 0, stuck 0, failed 0, wrong 0, leases left 0" in said


@pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")
def test_a_clock_that_is_set(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Processes that are started under it have it; no other notices."""
    monkeypatch.setattr(os, "environ", dict(os.environ))
    set_clock = Clock(tmp_path).set_by_an_hour
    ask = [sys.executable, "-S", "-c", "import time; print(time.time(), time.monotonic())"]

    def ahead() -> tuple[float, float]:
        said = subprocess.run(ask, env=os.environ, capture_output=True, text=True, check=True)
        now, steady = map(float, said.stdout.split())
        return round((now - time.time()) / HOUR_S, 1), round((steady - time.monotonic()) / HOUR_S)

    assert ahead() == (0.0, 0.0)
    set_clock()
    assert ahead() == (1.0, 0.0)
    set_clock()
    assert ahead() == (0.0, 0.0)


def test_a_scan(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["web", "readyz"])
    with Running(settings_for(tmp_path), real=False, keys_needed=True) as running:
        port = running.client.base_url.port
        assert port is not None
        scan = web.Scan(port, running.new_key("ada"))
        id = scan.ask("POST", "/v1/designs", scan.key, json=spec("zq7<b>")).json()["id"]
        scan.operations(id)
        scan.injections(id)
        scan.ways_up()
        web.strangers(scan, [os.getpid()], tmp_path)
        scan.client.close()
    # In this process other services may listen.
    assert [each for each in scan.found if not each.startswith("listens on one port")] == []
    assert sum(scan.made.values()) > 200
    assert {"needs a key", "strangers run nothing", "no header injected"} < set(scan.made)


def test_a_line_of_the_load_table(service: Running, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(load, "HELD_S", 1.5)
    monkeypatch.setattr(load, "SWEPT", 50)
    keys = [service.new_key(name) for name in ("quiet", "loud")]
    port = service.client.base_url.port
    assert port is not None
    line = asyncio.run(load.measure(port, os.getsid(0), keys, 2))
    cells = [cell.strip() for cell in line.strip("| ").split("|")]
    answers, errors = int(cells[1]), int(cells[8])
    assert answers > 0, line
    assert errors == 0
