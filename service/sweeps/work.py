"""What a worker does for a sweep: a few items one after the other, an answer for each."""

from __future__ import annotations

import json
import time
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any, Literal, Protocol

from pydantic import JsonValue, ValidationError

from service.wire.errors import InvalidBody
from service.workers.solve import Answer
from synthesis.design import Status
from synthesis.errors import Cancelled, TimeBudgetExceeded
from synthesis.objectives import Objective
from synthesis.spec import DesignSpec
from synthesis.sweeps import SweepSpec

Wanted = tuple[int, list[JsonValue]]  # an item: its number, and the values of the axes
SLICE_S = 1.0  # after this no further item of a chunk is begun: it goes back, and others come


class Core(Protocol):
    """What solves one design and measures further objectives on it."""

    def __call__(
        self, spec: bytes, budget_s: float, also: Sequence[Objective] = (), near: Any = None
    ) -> Answer: ...


@dataclass(frozen=True)
class ItemAnswer:
    """A finished item.

    Attributes:
        number: which. status: of the design, or failed.
        quantities: by name with unit. gap: to the bound. seconds: time in the core.
        design_id: the design's own id; None where its answer is not that of the spec alone.
        design: the design's body, compressed. problem: why it failed, or why it ended early.
        near: what it leaves to the next item of its chain; only of the last one that was begun.
    """

    number: int
    status: Status | Literal["failed"]
    seconds: float = 0.0
    quantities: dict[str, float] = field(default_factory=dict)
    gap: float | None = None
    design_id: str | None = None
    design: bytes | None = None
    problem: dict[str, Any] | None = None
    near: Any = None


def solve_items(
    sweep: bytes, wanted: Sequence[Wanted], budget_s: float, core: Core, near: Any = None
) -> list[ItemAnswer]:
    """Items of a sweep in the order they were wanted, as many as the time slice has room for.

    Stopped, it returns those that are done.

    Args:
        sweep: the SweepSpec, of whose axes only the fields matter here.
        wanted: the items. budget_s: for each. core: what solves one.
        near: with warm starts, what the item before has left; each leaves its own to the next.
    """
    spec, started = _sweep(sweep), time.monotonic()
    answers: list[ItemAnswer] = []
    for number, values in wanted:
        if answers and time.monotonic() - started > SLICE_S:
            break
        try:
            answer = _answered(spec, number, values, budget_s, core, near)
        except Cancelled:  # what is done counts
            break
        near = answer.near or near
        answers.append(replace(answer, near=None))
    if answers and spec.warm_start:
        answers[-1] = replace(answers[-1], near=near)
    return answers


@lru_cache(maxsize=4)
def _sweep(body: bytes) -> SweepSpec:
    return SweepSpec.model_validate_json(body)


def _answered(
    sweep: SweepSpec, number: int, values: list[JsonValue], budget_s: float, core: Core, near: Any
) -> ItemAnswer:
    started = time.monotonic()
    try:
        answer = _solved(sweep, values, budget_s, core, near)
    except Cancelled:
        raise
    except TimeBudgetExceeded as error:
        return _late(number, error, time.monotonic() - started)
    except Exception as error:
        from service.wire.problem import described  # rarely wanted, and it brings the web with it

        return ItemAnswer(number, "failed", time.monotonic() - started, problem=described(error))
    return ItemAnswer(
        number, answer.status, answer.seconds, answer.quantities,  # type: ignore[arg-type]
        answer.summary["gap"], answer.id, zlib.compress(answer.design, 1),
        near=answer.near if sweep.warm_start else None,
    )  # fmt: skip


def _solved(
    sweep: SweepSpec, values: list[JsonValue], budget_s: float, core: Core, near: Any
) -> Answer:
    body = _body(sweep, values)
    try:
        return core(body, budget_s, tuple(sweep.quantities), near)
    except ValidationError:
        item_spec(sweep, values)  # raises the same once more, as the service tells it
        raise


def item_spec(sweep: SweepSpec, values: list[JsonValue]) -> DesignSpec:
    """The spec of an item. Raises InvalidBody where its values make no sense."""
    from service.wire.body import validated

    return validated(_body(sweep, values), DesignSpec)


def _body(sweep: SweepSpec, values: list[JsonValue]) -> bytes:
    try:
        return json.dumps(sweep.item(values)).encode()
    except LookupError as error:
        raise InvalidBody(
            f"Another axis has replaced a field that an axis names: {error.args[0]}.", []
        ) from None


def _late(number: int, error: TimeBudgetExceeded, seconds: float) -> ItemAnswer:
    """Time ended: the best certified design so far is an answer, with a word on that."""
    from service.wire.problem import described

    problem = described(error)
    problem.pop("best", None)
    if error.best is None:
        return ItemAnswer(number, "failed", seconds, problem=problem)
    best = error.best
    body = zlib.compress(best.model_dump_json().encode(), 1)
    quantities = {**best.dimensions, **best.objectives}
    return ItemAnswer(
        number, best.status, seconds, quantities, best.certificate.gap, None, body, problem
    )
