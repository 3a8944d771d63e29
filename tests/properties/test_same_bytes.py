"""The same spec gives the same bytes, whatever the hash seed and the number of threads."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = """
import json, sys
from synthesis import DesignSpec, synthesise
for name in ("undercut-limit", "tilted-flat-face", "no-residual-vibration"):
    body = json.load(open(f"openapi/examples/{name}.json", encoding="utf-8"))["value"]
    design = synthesise(DesignSpec.model_validate(body)).model_dump(mode="json")
    for stage in design["report"]["stages"]:
        stage.pop("seconds")
    design["report"].pop("seconds")  # all that may differ
    print(json.dumps(design))
"""


def designs(seed: str, threads: str) -> str:
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "RAYON_NUM_THREADS")
    reported = os.environ | {"PYTHONHASHSEED": seed, "PYTHONPATH": str(ROOT)}
    reported |= dict.fromkeys(names, threads)
    run = subprocess.run(
        [sys.executable, "-c", SCRIPT],
        cwd=ROOT,
        env=reported,
        capture_output=True,
        text=True,
        check=True,
    )
    return run.stdout


def test_in_processes_of_their_own() -> None:
    first, second = designs("1", "1"), designs("4711", "4")
    assert len(first) > 10_000
    assert first == second
