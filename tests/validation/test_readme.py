"""What README.md and docs/overview.md say of the examples is what they come to."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from synthesis import DesignSpec, synthesise

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")
OVERVIEW = (ROOT / "docs/overview.md").read_text(encoding="utf-8")
ROW = re.compile(
    r"^\| `([a-z0-9-]+)` \| (.*) \| ([\d.]+) mm \| (?:below )?([\d.]+) %, (.*) \|$", re.M
)
ROWS = {name: reported for name, *reported in ROW.findall(OVERVIEW)}
OVER = {"all laws": "all motion laws", "all sizes": "every size", "at that length": "alone"}


def test_the_table_is_read() -> None:
    assert {"example-13-6-sized", "conjugate", "p3-sized"} <= set(ROWS)
    assert len(ROWS) == OVERVIEW.count("\n| `", OVERVIEW.index("| example |"))


@pytest.mark.parametrize("name", ROWS)
def test_an_example_comes_to_what_the_table_says(name: str) -> None:
    what, radius, gap, over = ROWS[name]
    example = json.loads((ROOT / f"openapi/examples/{name}.json").read_text(encoding="utf-8"))
    design = synthesise(DesignSpec.model_validate(example["value"]))
    sizes = design.dimensions
    assert sizes["base_radius_mm"] == pytest.approx(float(radius), abs=0.006)
    for length in re.findall(r": ([\d.]+) mm", what):
        assert any(size == pytest.approx(float(length), abs=0.06) for size in sizes.values())
    proof = design.certificate
    assert OVER[over] in proof.bound_valid_for
    if "below 0.01 %" in OVERVIEW[OVERVIEW.index(f"`{name}`") :].split("\n")[0]:
        assert proof.gap < 1e-4
    else:
        assert 100.0 * proof.gap == pytest.approx(float(gap), abs=0.006)


@pytest.mark.parametrize("more", [{}, {"proof": "quick"}], ids=["as it is", "quick"])
def test_the_request_is_answered_as_told(more: dict[str, str]) -> None:
    body = json.loads(re.search(r"json' -d '(\{.*?\})'", TEXT, re.S)[1])
    radius = float(re.search(r"base radius ([\d.]+) mm\)", TEXT)[1])
    gaps = re.search(r"more than\s([\d.]+) % smaller\..*?proves ([\d.]+) % only", TEXT, re.S)
    most = float(gaps[2 if more else 1])
    design = synthesise(DesignSpec.model_validate(body | more))
    assert design.dimensions["base_radius_mm"] == pytest.approx(radius, abs=0.006)
    assert 0.5 * most <= 100.0 * design.certificate.gap <= 1.1 * most
