"""The Pareto front of a sweep, from its finished items, read page by page."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from service.sweeps.store import ItemRow, SweepRow, SweepStore
from service.sweeps.views import ParetoAxis, ParetoFront, item_of
from service.wire.errors import ProblemType
from synthesis.studies.sweeps.pareto import non_dominated


@dataclass(frozen=True, eq=False)
class Comparison:
    """The certified designs of a sweep that have all quantities of the axes.

    Attributes:
        numbers: (n,) of the items. values: (n, k). front: indices of the non-dominated ones,
            ascending in the first quantity. left_out: how many other finished items, by reason.
    """

    numbers: Sequence[int]
    values: NDArray[np.float64]
    front: NDArray[np.intp]
    left_out: Mapping[str, int]


async def compare_designs(
    store: SweepStore, sweep: SweepRow, axes: Sequence[ParetoAxis]
) -> Comparison:
    """Compare the designs of a sweep in the quantities of the axes.

    Raises:
        ServiceError: no quantity is named, or one that no design of the sweep has.
    """
    _check(sweep, axes)
    signs = np.array([1.0 if axis.direction == "minimise" else -1.0 for axis in axes])
    numbers: list[int] = []
    values: list[list[float]] = []
    left_out: Counter[str] = Counter()
    async for page in store.pages(sweep.sequence):
        for item in page:
            row = [item.quantities.get(axis.quantity) for axis in axes]
            known = [value for value in row if value is not None]
            if item.status not in ("optimal", "feasible"):
                left_out[item.status] += 1
            elif len(known) < len(row):
                left_out["without one of these"] += 1
            else:
                numbers.append(item.number)
                values.append(known)
    table = np.array(values).reshape(len(values), len(axes))
    front = await asyncio.to_thread(non_dominated, table * signs)
    return Comparison(numbers, table, front, left_out)


async def pareto_front(
    store: SweepStore, sweep: SweepRow, axes: Sequence[ParetoAxis], most: int
) -> ParetoFront:
    """The non-dominated designs of a sweep in these quantities; see ``compare_designs``."""
    comparison = await compare_designs(store, sweep, axes)
    best = [comparison.numbers[index] for index in comparison.front]
    shown = await store.items(sweep.sequence, ItemRow.number.in_(best[:most]))
    rows = {item.number: item for item in shown}
    return ParetoFront(
        axes=list(axes),
        compared=len(comparison.numbers),
        excluded=sweep.done - len(comparison.numbers),
        size=len(best),
        items=[item_of(sweep, rows[number]) for number in best[:most] if number in rows],
    )


def _check(sweep: SweepRow, axes: Sequence[ParetoAxis]) -> None:
    known = ", ".join(sweep.quantities) or "nothing so far"
    if not axes:
        raise ProblemType.INVALID_PARAMETER(
            f"minimise, maximise: name at least one quantity. Measured in this sweep: {known}."
        )
    names = [axis.quantity for axis in axes]
    for name in names:
        if names.count(name) > 1:
            raise ProblemType.INVALID_PARAMETER(
                f"minimise, maximise: {name!r} is named twice. Name it once."
            )
        if name not in sweep.quantities:
            raise ProblemType.INVALID_PARAMETER(
                f"minimise, maximise: {name[:80]!r} is not measured on any design of this sweep. "
                f"Measured are: {known}. The field `quantities` of a sweep's spec adds to these."
            )
