"""Time budgets are of processor time here: what a spec comes to is the same on a busy machine."""

import time

import pytest

from synthesis.numerics import clock
from synthesis.pipeline import conflict


@pytest.fixture(autouse=True)
def budgets_of_processor_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """What would suffice in a conflict is sought coarsely: whether it does is asked elsewhere."""
    monkeypatch.setattr(clock, "now", time.process_time)
    monkeypatch.setattr(conflict, "ACCURACY", 0.3)


@pytest.fixture
def short_diagnosis(monkeypatch: pytest.MonkeyPatch) -> None:
    """Conflicts of random specs are sought for a tenth of the time; ``make hard`` takes all."""
    monkeypatch.setattr(conflict, "DIAGNOSIS_S", 0.1 * conflict.DIAGNOSIS_S)
