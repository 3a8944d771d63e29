"""The Pareto front of a sweep, from its finished items page by page."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from service.sweeps.store import SweepRow, SweepStore
from service.sweeps.views import ParetoAxis, ParetoFront, item_of
from service.wire.errors import BadQuery
from synthesis.sweeps.pareto import non_dominated

PAGE = 2000


@dataclass(frozen=True, eq=False)
class Weighed:
    """The certified designs of a sweep that have every quantity of the axes.

    Attributes:
        numbers: (n,) of the items. values: (n, k). front: indices of those that none beats,
            ascending in the first quantity. left_out: other finished items, by why.
    """

    numbers: Sequence[int]
    values: NDArray[np.float64]
    front: NDArray[np.intp]
    left_out: Mapping[str, int]


async def weighed(store: SweepStore, sweep: SweepRow, axes: Sequence[ParetoAxis]) -> Weighed:
    """Every design of a sweep in the quantities that are traded, and which none of them beats.

    Raises:
        BadQuery: a quantity that no design of the sweep has, or none at all.
    """
    _check(sweep, axes)
    signs = np.array([1.0 if axis.direction == "minimise" else -1.0 for axis in axes])
    numbers: list[int] = []
    values: list[list[float]] = []
    left_out: Counter[str] = Counter()
    above = -1
    while found := await store.numbered(sweep.sequence, above, PAGE):
        for item in found:
            told = [item.quantities.get(axis.quantity) for axis in axes]
            known = [value for value in told if value is not None]
            if item.status not in ("optimal", "feasible"):
                left_out[item.status] += 1
            elif len(known) < len(told):
                left_out["without one of these"] += 1
            else:
                numbers.append(item.number)
                values.append(known)
        above = found[-1].number
    table = np.array(values).reshape(len(values), len(axes))
    front = await asyncio.to_thread(non_dominated, table * signs)
    return Weighed(numbers, table, front, left_out)


async def front_of(
    store: SweepStore, sweep: SweepRow, axes: Sequence[ParetoAxis], most: int
) -> ParetoFront:
    """What no other certified design of the sweep beats in all of these quantities; ``weighed``."""
    found = await weighed(store, sweep, axes)
    best = [found.numbers[index] for index in found.front]
    rows = {item.number: item for item in await store.chosen(sweep.sequence, best[:most])}
    return ParetoFront(
        axes=list(axes),
        considered=len(found.numbers),
        left_out=sweep.done - len(found.numbers),
        size=len(best),
        items=[item_of(sweep, rows[number]) for number in best[:most] if number in rows],
    )


def _check(sweep: SweepRow, axes: Sequence[ParetoAxis]) -> None:
    known = ", ".join(sweep.quantities) or "nothing so far"
    if not axes:
        raise BadQuery(
            f"minimise: name what is to be small, or under maximise what is to be large. Measured "
            f"on the designs of this sweep: {known}."
        )
    names = [axis.quantity for axis in axes]
    for name in names:
        if names.count(name) > 1:
            raise BadQuery(f"minimise, maximise: {name!r} is named twice. Name it once.")
        if name not in sweep.quantities:
            raise BadQuery(
                f"minimise, maximise: {name[:80]!r} is not measured on any design of this sweep. "
                f"Measured are: {known}. The field `quantities` of a sweep's spec adds to these."
            )
