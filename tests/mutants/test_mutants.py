"""The tool that plants faults: what it plants, and that tests see it."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.mutants.collected import Collected
from tests.mutants.operators import Fault, faults
from tests.mutants.runs import Asked, ask, plant, record

SOURCE = """
from math import ceil

SLACK_ROUNDING = 1e-9  # an allowance


def most(values: list[float], bound: float) -> float:
    if not values:
        raise ValueError("Δ")
    return max(values) - SLACK_ROUNDING


def fits(value: float, bound: float) -> bool:
    return value <= bound and ceil(value) < 9


def inner(values: list[float]) -> list[float]:
    return [0.5 * each for each in values[1:]]


def rows(a: float, b: float) -> list[float]:
    found = [a, -b]
    found.append(a + b)
    return found
"""
STORE = """
async def take(session, row):
    with session.begin() as s:
        s.execute(update(Row).where(Row.id == row.id, Row.owner.is_(None)))
        row.owner = 1
        s.commit()
"""


def planted(found: list[Fault]) -> set[tuple[str, str]]:
    return {(fault.before, fault.after) for fault in found}


def test_faults_are_aimed_at_what_a_claim_rests_on() -> None:
    wanted = {
        ("not values", "False"), ("not values", "True"),
        ('raise ValueError("Δ")', "pass"), ("max", "min"),
        ("SLACK_ROUNDING", "0.0"), ("SLACK_ROUNDING", "(1e3 * SLACK_ROUNDING)"),
        ("max(values) - SLACK_ROUNDING", "max(values) + SLACK_ROUNDING"),
        ("ceil", "floor"), ("value <= bound", "value >= bound"), ("[a, -b]", "[a]"),
        ("value <= bound and ceil(value) < 9", "True"), ("-b", "b"), ("a + b", "a - b"),
        ("0.5", "(0.5 * 0.99)"), ("1", "1 + 1"),
        ("value <= bound and ceil(value) < 9", "(value <= bound)"), ("found.append(a + b)", "pass"),
    }  # fmt: skip
    assert wanted <= planted(faults("m.py", SOURCE))


def test_in_the_store_they_are_aimed_at_conditions_and_transactions() -> None:
    wanted = {
        ("update(Row).where(Row.id == row.id, Row.owner.is_(None))",
         "update(Row).where(Row.id == row.id)"),
        ("session.begin()", "session()"), ("row.owner = 1", "pass"), ("s.commit()", "pass"),
    }  # fmt: skip
    assert wanted <= planted(faults("m.py", STORE, store=True))
    assert not wanted & planted(faults("m.py", STORE))


def test_a_fault_changes_one_place_and_keeps_its_name_when_lines_move() -> None:
    found = faults("m.py", SOURCE)
    assert len({fault.key for fault in found}) == len(found)
    for fault in found:
        assert fault.plant(SOURCE) == SOURCE.replace(fault.before, fault.after, 1) or (
            SOURCE.count(fault.before) > 1
        )
    assert [fault.key for fault in faults("m.py", "\n# é\n" + SOURCE)] == [f.key for f in found]


@pytest.fixture
def tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A product of one module, and its tests: of the slack there is none."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / ".mutants").mkdir()
    (tmp_path / "synthesis" / "certify").mkdir(parents=True)
    for package in ("synthesis", "synthesis/certify"):
        (tmp_path / package / "__init__.py").touch()
    (tmp_path / "synthesis" / "certify" / "m.py").write_text(SOURCE)
    (tmp_path / "tests").mkdir()
    (tmp_path / "tests" / "test_m.py").write_text(
        "import pytest\n"
        "from synthesis.certify.m import most, rows\n"
        "@pytest.fixture(scope='module', params=['most', 'rows'])\n"
        "def made(request): return most([1.0], 2.0) if request.param == 'most' else rows(1, 2)\n"
        "def test_made(made): assert made\n"
        "def test_rows(): assert rows(1, 2) == [1, -2, 3]\n"
        "def test_most(): assert abs(most([1.0, 2.0], 3.0) - 2.0) < 1e-3\n"
        "def test_that_fails(): assert rows(1, 2) == []\n"
    )
    return tmp_path


def test_what_tests_reach_and_see(tree: Path) -> None:
    names, tests = record(tree, Path("tests/test_m.py"))
    each = [
        f"tests/test_m.py::test_{name}" for name in ("made[most]", "made[rows]", "most", "rows")
    ]
    assert sorted(tests) == each
    for test in each:  # of a fixture's parameters each test has its own
        reached = {names[line] for line in tests[test][1]}
        of_rows = "rows" in test
        assert ("synthesis/certify/m.py rows: found.append(a + b)" in reached) == of_rows
        assert any("max(values)" in name for name in reached) != of_rows

    asked = Asked(sorted(tests), 1.0, "")
    found = {fault.after: fault for fault in faults("synthesis/certify/m.py", SOURCE)}
    for after, seen_by in (("a - b", "test_rows"), ("0.0", "")):
        with plant(tree / "synthesis/certify/m.py", found[after].plant(SOURCE)):
            assert ask(tree, asked).rpartition("::")[2] == seen_by
    text = (tree / "synthesis/certify/m.py").read_text()
    assert text == SOURCE  # planted for as long as it is asked about


def test_collected_tests_see_what_they_see_in_a_process_of_their_own(tree: Path) -> None:
    names = ["test_rows", "test_most"]
    asked = Asked([f"tests/test_m.py::{name}" for name in names], 1.0, "")
    file, collected = tree / "synthesis/certify/m.py", Collected(tree, ["tests"])
    seen_by = {
        fault.after: collected.ask(file, SOURCE, fault.plant(SOURCE), asked).rpartition("::")[2]
        for fault in faults("synthesis/certify/m.py", SOURCE)
    }
    assert (seen_by["a - b"], seen_by["min"], seen_by["0.0"]) == (*names, "")
    endless = SOURCE.replace("found = [a, -b]", "while True: pass")
    assert collected.ask(file, SOURCE, endless, Asked(asked.tests, -4.0, "")) == "endless"
    assert collected.passes(asked.tests[0])
    assert not collected.passes("tests/test_m.py::test_that_fails")


def test_an_endless_loop_is_seen(tree: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tests.mutants.runs.LEAST", 1.0)
    asked = Asked(["tests/test_m.py::test_rows"], 0.0, "")
    endless = SOURCE.replace("found = [a, -b]", "while True: pass")
    with plant(tree / "synthesis/certify/m.py", endless):
        assert ask(tree, asked) == "endless"
