"""Everything the library raises on purpose, and wrong input in the words of an engineer.

CamwrightError
├── InputError                the question makes no sense (wrong value, rule, way out)
├── SolverFailed              a solver stopped without a usable point
├── TimeBudgetExceeded        time ran out; carries the best certified design so far
├── Cancelled                 nobody waits for the answer any more
└── ExtraMissing              an optional part is not installed

Wrong input is first found by pydantic, as a list of its errors. ``violations`` makes of them what a
caller reads: where, which value, which rule, what to write; open it first.

    wrong_names, values what to write instead of a wrong name, and of a wrong value
    names               which field or kind a word stands for
    words.toml          words that people use for fields and kinds, and units
    quantities          units in names and texts; ``schema``: what a body may hold at a place
    places              where rules over several fields point to
    explanation         the same for models that are made in Python
"""

from __future__ import annotations

from typing import Any


class CamwrightError(Exception):
    """Root of the tree; never raised itself."""


class InputError(CamwrightError, ValueError):
    """A value that breaks a rule.

    Args:
        field: path of the field, as in ``/program/0/angle_deg``.
        value: the value found there.
        rule: what it has to satisfy.
        remedy: what the caller can do about it.
    """

    def __init__(self, field: str, value: Any, rule: str, remedy: str) -> None:
        super().__init__(f"{field} = {value!r}: {rule} {remedy}")
        self.field, self.value, self.rule, self.remedy = field, value, rule, remedy

    def __reduce__(self) -> tuple[type[InputError], tuple[str, Any, str, str]]:
        return type(self), (self.field, self.value, self.rule, self.remedy)


class SolverFailed(CamwrightError):
    """A solver gave no usable point; ``status`` is the solver's own word."""

    def __init__(self, solver: str, status: str, advice: str) -> None:
        super().__init__(f"{solver} stopped with {status!r}. {advice}")
        self.solver, self.status, self.advice = solver, status, advice

    def __reduce__(self) -> tuple[type[SolverFailed], tuple[str, str, str]]:
        return type(self), (self.solver, self.status, self.advice)


class TimeBudgetExceeded(CamwrightError):
    """The time budget ended first; ``best`` is the best certified design, or None."""

    def __init__(self, budget_s: float, best: Any = None) -> None:
        found = "no feasible design was" if best is None else "a feasible design was"
        super().__init__(
            f"The time budget of {budget_s:g} s ended before the tolerance was reached; "
            f"{found} found. Allow more time by time_budget_s, or ask for a larger tolerance."
        )
        self.budget_s, self.best = budget_s, best

    def __reduce__(self) -> tuple[type[TimeBudgetExceeded], tuple[float, Any]]:
        return type(self), (self.budget_s, self.best)


class Cancelled(CamwrightError):
    """Whoever asked has stopped the work; there is no answer."""

    def __init__(self) -> None:
        super().__init__("It was stopped while it was being worked on.")

    def __reduce__(self) -> tuple[type[Cancelled], tuple[()]]:
        return type(self), ()


EXTRAS = {
    "cad": 380,
    "cvxpy": 70,
    "dxf": 56,
    "exact": 26,
    "pandas": 85,
    "parquet": 170,
    "plots": 100,
    "postgres": 13,
    "traces": 12,
}
"""What may be installed besides, by the names in pyproject.toml, and its size on disk [MB].

Rounded, with what it brings along, on Linux; `tests/architecture/test_extras.py` has the names.
"""


class ExtraMissing(CamwrightError):
    """Something optional is asked for that is not installed; ``extra`` names what brings it.

    ``library``: what of the system the installed extra lacks, and how to install it; '' where the
    extra itself is not there.
    """

    def __init__(self, what: str, extra: str, library: str = "") -> None:
        super().__init__(
            f"{what} needs a library of the system that is not installed here. {library}"
            if library
            else f"{what} needs an optional part that is not installed here. "
            f"Install it with: pip install 'camwright[{extra}]' ({EXTRAS[extra]} MB)"
        )
        self.what, self.extra, self.library = what, extra, library

    def __reduce__(self) -> tuple[type[ExtraMissing], tuple[str, str, str]]:
        return type(self), (self.what, self.extra, self.library)
