"""Gaps against time: what is counted, which families fall short, and the page."""

from __future__ import annotations

import re
from dataclasses import replace
from math import inf
from pathlib import Path

import pytest

from benchmarks import gaps
from benchmarks.gaps import FAMILIES, LEVELS, Outcome, Picture, section

CLEAN, OPEN, EMPTY = "slide, centred", "arm, pivot free", "face, width"


def made(family: str, number: int, *closing: float | None, **more: str) -> list[Outcome]:
    """A scene with a gap at each level."""
    return [
        Outcome(family, number, level, 0.13 * 3.7**k, gap, "feasible", **more)
        for k, (level, gap) in enumerate(zip(LEVELS, closing, strict=True))
    ]


FOUND = [
    *made(CLEAN, 0, 0.003, 0.003, 0.003),
    *made(CLEAN, 1, 0.31, 0.0049, 0.0049),
    *made(OPEN, 0, 0.87, 0.043, 0.011, end="node limit", over="all; not wholly in it: hertz"),
    *made(EMPTY, 0, None, None, None),
]


def test_there_are_enough_families() -> None:
    assert len(FAMILIES) >= 40


def test_shares_are_those_of_scenes_with_a_cam() -> None:
    shares, short, families, _ = section(FOUND, "--scenes 2", 97.0).parts
    closed = {row[0]: row[1] for row in shares.rows}
    assert closed == {"quick": "33 %", "auto": "67 %", "thorough": "67 %"}
    assert f"{EMPTY} #0 (feasible)" in shares.note
    assert [row[0] for row in short.rows] == [OPEN]
    assert short.rows[0][1:] == ("1 of 1", "1.1 %", "node limit", "hertz", "more nodes")
    row = {row[0]: row for row in families.rows}
    assert row[CLEAN][1:4] == ("2", "0.13 s", "15.7 % / 31 %")
    assert row[EMPTY][3] == "–"


def test_bounds_at_chosen_numbers_are_marked() -> None:
    found = made(OPEN, 0, 0.001, 0.001, 0.001, over=f"all motion laws, {gaps.NUMBERS}")
    assert f"| {OPEN} * |" in section(found, "", 1.0).markdown()


def test_what_a_level_closes_is_not_run_again(monkeypatch: pytest.MonkeyPatch) -> None:
    question = list[str]()

    def outcome(family: str, number: int, level: str) -> Outcome:
        question.append(level)
        gap = {"quick": 0.2, "auto": 0.004}[level]
        return Outcome(family, number, level, 1.0, gap, "feasible")

    monkeypatch.setattr(gaps, "outcome", outcome)
    found = gaps.outcomes(OPEN, 3)
    assert question == ["quick", "auto"]
    assert [one.level for one in found] == [*LEVELS]
    assert found[2] == replace(found[1], level="thorough")


def test_a_scene_is_measured() -> None:
    quick, auto, thorough = gaps.outcomes("slide, laws given, centred", 0)
    assert quick.closed
    assert quick.seconds > 0.0
    assert (quick.status, quick.end) == ("optimal", "tolerance")
    assert auto == replace(quick, level="auto")
    assert thorough == replace(quick, level="thorough")


def test_a_kept_scene_is_not_asked_again_and_the_end_keeps_what_is_known(tmp_path: Path) -> None:
    kept, cheap = tmp_path / "kept.jsonl", ["slide, laws given", "face, laws given"]
    first = gaps.measured(cheap, 1, inf, 1, kept)
    assert {(one.family, one.number) for one in first} == {(name, 0) for name in cheap}
    assert gaps.measured(cheap, 1, inf, 1, kept) == first  # with the seconds of that time
    more = gaps.measured(cheap, 100, 0.0, 1, kept)
    assert more[: len(first)] == first
    assert len(first) < len(more) < 100 * len(LEVELS)
    assert gaps.measured(cheap, 0, inf, 1, kept) == more


def test_the_picture_has_a_panel_for_each_family(tmp_path: Path) -> None:
    page = section(FOUND, "", 1.0)
    gaps.write(page, tmp_path)
    drawing = (tmp_path / "gaps.svg").read_bytes()
    assert all(f">{name}<" in drawing.decode() for name in (CLEAN, OPEN, EMPTY))
    (picture,) = (part for part in page.parts if isinstance(part, Picture))
    assert picture.svg() == drawing
    text = (tmp_path / "README.md").read_text(encoding="utf-8")
    assert text.startswith("# Proofs")
    assert "(gaps.svg)" in text


def test_the_committed_page_is_whole() -> None:
    text = (gaps.FOLDER / "README.md").read_text(encoding="utf-8")
    assert (gaps.FOLDER / "gaps.svg").exists()
    rows = re.findall(r"^\| ([a-z][^|*]*?)(?: \*)? \| \d+ \|", text, re.M)
    assert set(rows) <= set(gaps.EVERY)
    assert len(rows) >= 40
