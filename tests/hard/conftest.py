"""Time budgets are of processor time here: what a spec comes to is the same on a busy machine."""

import time

import pytest

from synthesis.numerics import clock
from synthesis.pipeline import boundary, conflict
from synthesis.pipeline.conflict import explain

EXPLAIN = "synthesis.pipeline.synthesise.explain"


@pytest.fixture(autouse=True)
def budgets_of_processor_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """What would suffice in a conflict is sought coarsely: whether it does is asked elsewhere."""
    monkeypatch.setattr(clock, "now", time.process_time)
    monkeypatch.setattr(conflict, "ACCURACIES", (0.3,))


@pytest.fixture
def members_only(coarse_conflicts: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """A conflict's members are found by leaving out one number after the other, each a question.

    The values that would suffice are not sought: each takes many questions, and no case looks at
    them.
    """
    monkeypatch.setattr("synthesis.pipeline.conflict.seek_value", lambda _: None)
    monkeypatch.setattr(boundary.Boundary, "narrow", lambda _: None)


@pytest.fixture
def short_diagnosis(monkeypatch: pytest.MonkeyPatch) -> None:
    """Conflicts of random specs are sought for half a second; ``make hard`` takes all there is."""
    monkeypatch.setattr(EXPLAIN, lambda *question: explain(*question[:3], clock.now() + 0.5))
