"""A design that nobody waits for ends wherever it is; being stoppable changes nothing else."""

from __future__ import annotations

from threading import Event, Thread
from typing import Any

import numpy as np
import pytest
from scipy import sparse

from synthesis import synthesise
from synthesis.errors import Cancelled
from synthesis.numerics import clock
from synthesis.numerics.solvers import highs, ipopt
from tests.pipeline.scenes import PRESSURE, jerk, spec

RADIUS = {"kind": "profile_radius", "min_mm": 12.0}
SCENES: dict[str, dict[str, Any]] = {
    "cone programs": {"limits": [PRESSURE, jerk(48.0)], "tolerance": 1e-3},
    "tangents": {"limits": [PRESSURE, jerk(48.0), RADIUS], "proof": "quick"},
    "IPOPT": {
        "limits": [PRESSURE, RADIUS],
        "base_radius_mm": {"max": 34.0},
        "objective": {"kind": "peak_jerk"},
        "tolerance": 5e-2,
        "proof": "quick",
    },
    "hulls": {"limits": [PRESSURE, jerk(48.0), RADIUS], "proof": "thorough"},
}


class Patience(Event):
    """Set, as by whoever stops it, once it has been looked at so many times."""

    def __init__(self, looks: int) -> None:
        super().__init__()
        self.looks, self._most = 0, looks

    def is_set(self) -> bool:
        self.looks += 1
        return self.looks > self._most


@pytest.mark.parametrize("scene", SCENES)
def test_it_ends_at_the_next_look(scene: str) -> None:
    """A solver's iteration is a look, and so is the step after it: two, and nothing goes on."""
    question = spec(**SCENES[scene])
    endless = Patience(10**9)
    with clock.cancellation_scope(endless):
        design = synthesise(question)
    assert endless.looks > 20
    for looks in range(0, endless.looks, max(1, endless.looks // 4)):
        patience = Patience(looks)
        with clock.cancellation_scope(patience), pytest.raises(Cancelled):
            synthesise(question)
        assert patience.looks <= looks + 2
    if scene != "hulls":
        alone = synthesise(question)
        assert (alone.size, alone.motion) == (design.size, design.motion)
        assert alone.certificate == design.certificate


def test_ipopt_stops_between_two_iterations(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stopped in its callback, it says so itself; the clock raises only after that."""
    reported: list[str] = []
    event = Event()

    class Stopping(ipopt._Look):
        def eval(self, point: Any) -> list[float]:
            event.set()
            reported.append("asked")
            return super().eval(point)

    monkeypatch.setattr(ipopt, "_Look", Stopping)
    with clock.cancellation_scope(event), pytest.raises(Cancelled):
        synthesise(spec(**SCENES["IPOPT"]))
    assert reported == ["asked"]


def test_linear_programs_stop_between_two_objectives() -> None:
    rows = highs.LinearRows(
        sparse.csc_matrix([[1.0, 2.0]]), np.array([3.0]), 0, np.zeros(2), np.full(2, 5.0)
    )
    objectives = [np.array([-1.0, k]) for k in range(5)]
    patience = Patience(3)
    with clock.cancellation_scope(patience), pytest.raises(Cancelled):
        highs.minimise_each(rows, objectives)
    assert patience.looks == 4
    assert len(highs.minimise_each(rows, objectives)) == 5


def test_it_is_the_threads_own_affair() -> None:
    """What runs beside a stopped design, in another thread, goes on."""
    event, seen = Event(), list[float]()
    event.set()
    with clock.cancellation_scope(event):
        beside = Thread(target=lambda: seen.append(clock.now()))
        beside.start()
        beside.join()
        with pytest.raises(Cancelled):
            clock.now()
    assert seen[0] <= clock.now()
