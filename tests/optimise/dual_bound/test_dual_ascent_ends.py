"""When the search for better multipliers ends."""

from __future__ import annotations

from math import inf
from types import SimpleNamespace
from typing import Any

import pytest

from synthesis.optimise.dual_bound import dual_ascent


@pytest.mark.filterwarnings("error")
def test_bounds_that_stay_infinite_end_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """−∞ less −∞ is no number: it warned, and went on to the last iteration."""
    asked = []
    nothing: Any = SimpleNamespace(value=-inf, switching=())

    def solve(*_: Any) -> Any:
        asked.append(1)
        return nothing

    task = SimpleNamespace(order=3, solve=solve)
    monkeypatch.setattr(dual_ascent, "law_controls", lambda model: [SimpleNamespace(weight=0.0)])
    monkeypatch.setattr(dual_ascent, "_DualProgram", SimpleNamespace(of=lambda *_: task))
    model: Any = SimpleNamespace(recover=lambda x: ((), ()))
    solution: Any = SimpleNamespace(x=None)
    found = dual_ascent.improve_multipliers(model, solution, nothing, lambda _: False, 10.0)
    assert found is nothing
    assert len(asked) == 1
