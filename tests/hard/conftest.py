"""Time budgets are of processor time here: what a spec comes to is the same on a busy machine."""

import time

import pytest

from synthesis.numerics import clock


@pytest.fixture(autouse=True)
def budgets_of_processor_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(clock, "now", time.process_time)
