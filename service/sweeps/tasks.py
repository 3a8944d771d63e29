"""What a worker does for a sweep: some items one after the other, an answer for each."""

from __future__ import annotations

import json
import time
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, Literal

from pydantic import JsonValue, ValidationError

from service.wire.errors import ProblemType
from service.workers.measured import note
from service.workers.tasks import Answer
from synthesis.design.design import Status
from synthesis.design.warnings import Severity
from synthesis.errors import Cancelled, TimeBudgetExceeded
from synthesis.spec.design_spec import DesignSpec
from synthesis.studies.sweeps import SweepSpec

Item = tuple[int, list[JsonValue]]  # its number, and the values of the axes
SolveDesign = Callable[..., Answer]  # as ``solve_design`` of the workers' tasks
SLICE_S = 1.0  # after this no further item of a chunk is begun, so that others get the worker


@dataclass(frozen=True)
class ItemAnswer:
    """A finished item.

    Attributes:
        status: of the design, or failed. quantities: by name with unit. gap: relative, to the
            bound. seconds: time that it took.
        design_id: the design's id; None where the answer is not that of the spec alone.
        design: the design's body, compressed. problem: why it failed, or why it ended early.
        severity: of the worst warning of the design.
    """

    number: int
    status: Status | Literal["failed"]
    seconds: float = 0.0
    quantities: dict[str, float] = field(default_factory=dict)
    gap: float | None = None
    design_id: str | None = None
    design: bytes | None = None
    problem: dict[str, Any] | None = None
    severity: Severity = "none"


def solve_items(
    sweep: bytes, items: Sequence[Item], budget_s: float, solve: SolveDesign, warm_start: Any = None
) -> tuple[list[ItemAnswer], Any]:
    """Solve items of a sweep in order, as many as the time slice has room for.

    Cancelled, it returns those that are done; and what the next item may begin with.

    Args:
        sweep: the SweepSpec; of its axes only the fields are used.
        budget_s: for each item. solve: solves one.
        warm_start: of the item before; each item leaves its own to the next.
    """
    spec, started = _sweep(sweep), time.monotonic()
    answers: list[ItemAnswer] = []
    for number, values in items:
        if answers and time.monotonic() - started > SLICE_S:
            break
        try:
            answer, left = _answer(spec, number, values, budget_s, solve, warm_start)
        except Cancelled:
            break
        warm_start = left or warm_start
        answers.append(answer)
    return answers, warm_start


@lru_cache(maxsize=4)
def _sweep(body: bytes) -> SweepSpec:
    return SweepSpec.model_validate_json(body)


def _answer(
    sweep: SweepSpec,
    number: int,
    values: list[JsonValue],
    budget_s: float,
    solve: SolveDesign,
    warm_start: Any,
) -> tuple[ItemAnswer, Any]:
    started = time.monotonic()
    try:
        try:
            body = _body(sweep, values)
            answer = solve(body, budget_s, tuple(sweep.quantities), warm_start)
        except ValidationError:
            item_spec(sweep, values)  # raises ServiceError for the same reason
            raise
    except Cancelled:
        raise
    except Exception as error:
        # Rarely needed, and it imports the web framework.
        from service.wire.problem import problem_of

        seconds, problem = time.monotonic() - started, problem_of(error)
        note("failed", seconds)
        problem.pop("best", None)
        best = error.best if isinstance(error, TimeBudgetExceeded) else None
        if best is None:
            return ItemAnswer(number, "failed", seconds, problem=problem), None
        # When time ended, the best certified design so far is the answer, with the problem.
        return ItemAnswer(
            number, best.status, seconds, {**best.dimensions, **best.objectives},
            best.certificate.gap, None, zlib.compress(best.model_dump_json().encode(), 1), problem,
            best.severity,
        ), None  # fmt: skip
    return ItemAnswer(
        number, answer.status, answer.seconds, answer.quantities,  # type: ignore[arg-type]
        answer.summary["gap"], answer.id, zlib.compress(answer.body, 1),
        severity=answer.summary.get("severity", "none"),
    ), answer.warm_start if sweep.warm_start else None  # fmt: skip


def item_spec(sweep: SweepSpec, values: list[JsonValue]) -> DesignSpec:
    """The spec of an item. Raises ServiceError where the values of its axes are not valid."""
    from service.wire.validation import validate

    return validate(_body(sweep, values), DesignSpec)


def _body(sweep: SweepSpec, values: list[JsonValue]) -> bytes:
    try:
        return json.dumps(sweep.item(values)).encode()
    except LookupError as error:
        raise ProblemType.INVALID_REQUEST(
            f"Another axis has replaced a field that an axis names: {error.args[0]}."
        ) from None
