"""A proof that goes on by itself: the quick one first, then as far as its budget goes."""

from __future__ import annotations

import itertools
from functools import cache
from typing import Any

import pytest

from synthesis import DesignSpec, synthesise
from synthesis.design.design import Design
from synthesis.numerics import clock
from synthesis.pipeline import goal
from tests.pipeline.scenes import PRESSURE, jerk, spec
from tests.pipeline.ticking import ticking

EASY = spec(limits=[PRESSURE, jerk(51.3)], proof="auto")
BENT = spec(limits=[PRESSURE, jerk(47.1), {"kind": "profile_radius", "min_mm": 12.7}], proof="auto")
HARD, HARDER = (BENT.model_copy(update={"tolerance": x}) for x in (3e-4, 1e-4))
"""Take more than the budgets here."""


@cache
def quick_hard() -> tuple[Design, int]:
    return answered(HARD, proof="quick")


def answered(question: DesignSpec, **changes: Any) -> tuple[Design, int]:
    """The answer, and the programs that were solved for it."""
    before = clock.programs_solved()
    design = synthesise(question.model_copy(update=changes))
    return design, clock.programs_solved() - before


def numbers(design: Design) -> dict[str, Any]:
    """All but what follows from the wording of the question, and times."""
    return design.model_dump(exclude={"id", "spec", "report"})


def test_it_is_the_default() -> None:
    body = EASY.model_dump(exclude_unset=True, exclude={"proof"})
    assert DesignSpec.model_validate(body) == EASY


def test_a_gap_that_is_closed_at_the_root_costs_nothing_more() -> None:
    (quick, few), (auto, same) = (answered(EASY, proof=proof) for proof in ("quick", "auto"))
    assert quick.status == "optimal"
    assert (numbers(auto), same) == (numbers(quick), few)


def test_an_open_gap_is_closed() -> None:
    (quick, few), (auto, more) = (answered(BENT, proof=proof) for proof in ("quick", "auto"))
    assert quick.status == "feasible"
    assert auto.status == "optimal"
    assert few < more <= goal.AUTO_PROGRAMS
    thorough, _ = answered(BENT, proof="thorough")
    assert numbers(auto) == numbers(thorough)


def test_its_end_depends_on_no_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where programs end the proof, a machine of any speed gives the same answer."""
    monkeypatch.setattr(goal, "AUTO_PROGRAMS", 20)
    ended, solved = answered(HARDER)
    assert ended.status == "feasible"
    assert 20 <= solved < 60
    quick, _ = answered(HARDER, proof="quick")
    assert quick.certificate.lower_bound < ended.certificate.lower_bound
    later = itertools.count(0.0, 1e3)
    monkeypatch.setattr(clock, "now", lambda: next(later))
    assert numbers(synthesise(HARDER)) == numbers(ended)


def test_of_a_time_that_is_given_a_part_is_used(monkeypatch: pytest.MonkeyPatch) -> None:
    """More than by itself, and the answer comes on time, without an error."""
    monkeypatch.setattr(goal, "AUTO_PROGRAMS", 0)
    _, few = quick_hard()
    with ticking(monkeypatch) as machine:
        design, more = answered(HARD, time_budget_s=0.8)
    assert more > few
    assert design.status == "feasible"
    assert design.report.stages[-1].exit == "budget of the proof"
    assert 0.4 <= machine.time < 0.8
