"""A machine of known speed: its clock goes on with the work that is done, not with the sun.

Every call of a function costs the same, and every solver what its program's size and its steps say.
So how often a stage looks at the clock, and how far past its budget an answer comes, are the same
on every machine, however much else it has to do.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import pytest

from synthesis.numerics import clock
from synthesis.numerics.solvers import clarabel
from synthesis.optimise.heuristics import ipopt_search as nonlinear

CALL = 3e-6  # s, of any function's call: some three times a real machine's
ENTRY = 1e-7  # s, of an entry of a solver's matrix in one of its steps


@dataclass(eq=False)
class Ticking:
    """The clock [s]: ``longest`` is what was done between two looks at it, at most."""

    calls: int = 0
    solving: float = 0.0
    looks: list[float] = field(default_factory=list)

    @property
    def time(self) -> float:
        return CALL * self.calls + self.solving

    @property
    def longest(self) -> float:
        ends = [0.0, *self.looks, self.time]
        return max(later - sooner for sooner, later in pairwise(ends))

    def now(self) -> float:
        self.looks.append(self.time)
        return self.time

    def count(self, _frame: Any, event: str, _arg: Any) -> None:
        self.calls += event in ("call", "c_call")

    def costing(self, solve: Callable[..., Any]) -> Callable[..., Any]:
        """A solver that takes time on this clock, and no more of it than it is given."""

        def costly(program: Any, *more: Any, **named: Any) -> Any:
            found = solve(program, *more, **named)
            limits = [each for each in more if isinstance(each, float)]
            cost = ENTRY * max(found.iterations, 1) * _entries(program)
            self.solving += min([cost, *(max(limit, 0.0) for limit in limits[:1])])
            return found

        return costly


def _entries(program: Any) -> float:
    matrix = getattr(program, "matrix", None)
    return float(matrix.nnz if matrix is not None else 20 * len(program.lower))


@contextmanager
def ticking(monkeypatch: pytest.MonkeyPatch) -> Iterator[Ticking]:
    """All work inside goes by such a clock."""
    found, before, conic = Ticking(), sys.getprofile(), clarabel.solve
    with monkeypatch.context() as patched:
        patched.setattr(clock, "now", found.now)
        patched.setattr(nonlinear, "solve", found.costing(nonlinear.solve))
        for name, module in list(sys.modules.items()):
            if name.startswith("synthesis.") and getattr(module, "solve", None) is conic:
                patched.setattr(module, "solve", found.costing(conic))
        sys.setprofile(found.count)
        try:
            yield found
        finally:
            sys.setprofile(before)
