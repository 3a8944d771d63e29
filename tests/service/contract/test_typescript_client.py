"""A TypeScript client made from the contract compiles under --strict and works; Redocly's rules.

`npm ci` in the folder `node` beside this file brings what is needed of Node.js; `make` has it done.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

from service.openapi import TARGET
from tests.service.conftest import Running

HERE = Path(__file__).with_name("node")
TOOLS = HERE / "node_modules" / ".bin"


def run(*command: str | Path, folder: Path) -> str:
    """What a tool prints; it must be there and end well."""
    assert shutil.which("node"), "Node.js 20.19 or newer is missing; on Debian: apt install nodejs"
    assert TOOLS.is_dir(), f"run: npm ci --ignore-scripts --prefix {HERE}"
    quiet = {"REDOCLY_TELEMETRY": "off", "REDOCLY_SUPPRESS_UPDATE_NOTICE": "true"}
    done = subprocess.run(
        [str(part) for part in command], cwd=folder, env={**os.environ, **quiet},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program beside this file, compiled with the types that the contract leads to.

    What must not compile stands in it too: an error that is expected and does not occur is one.
    """
    folder = tmp_path_factory.mktemp("typescript")
    (folder / "node_modules").symlink_to(HERE / "node_modules")
    for name in ("package.json", "tsconfig.json", "program.ts"):
        shutil.copy(HERE / name, folder / name)
    made = ("--default-non-nullable=false", "-o", "camwright.ts")  # a default may be left out
    run(TOOLS / "openapi-typescript", TARGET, *made, folder=folder)
    run(TOOLS / "tsc", "--project", folder, folder=folder)
    return folder / "program.js"


def test_a_program_designs_a_cam_gets_a_file_and_reads_a_refusal(
    program: Path, real_service: Running
) -> None:
    printed = run("node", program, real_service.url, folder=program.parent)
    answer = json.loads(printed)
    assert answer.pop("base_radius_mm") == pytest.approx(50.888, abs=1e-3)
    assert answer.pop("rows") > 360
    assert answer == {"status": "optimal", "certified": True, "pointer": "/speed_rpm"}


def test_redocly_finds_nothing() -> None:
    config = HERE / "redocly.yaml"
    found = run(TOOLS / "redocly", "lint", TARGET, "--config", config, "--format=json", folder=HERE)
    assert json.loads(found)["totals"] == {"errors": 0, "warnings": 0, "ignored": 0}
