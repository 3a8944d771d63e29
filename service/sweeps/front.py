"""The Pareto front of a sweep, from its finished items page by page."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence

import numpy as np

from service.errors import BadQuery
from service.sweeps.store import SweepRow, SweepStore
from service.sweeps.views import ParetoAxis, ParetoFront, item_of
from synthesis.sweeps.pareto import non_dominated

PAGE = 2000


async def front_of(
    store: SweepStore, sweep: SweepRow, axes: Sequence[ParetoAxis], most: int
) -> ParetoFront:
    """What no other certified design of the sweep beats in all of these quantities.

    Raises:
        BadQuery: a quantity that no design of the sweep has, or none at all.
    """
    _check(sweep, axes)
    signs = np.array([1.0 if axis.direction == "minimise" else -1.0 for axis in axes])
    numbers: list[int] = []
    values: list[list[float]] = []
    above = -1
    while found := await store.numbered(sweep.sequence, above, PAGE):
        for item in found:
            told = [item.quantities.get(axis.quantity) for axis in axes]
            known = [value for value in told if value is not None]
            if item.status in ("optimal", "feasible") and len(known) == len(told):
                numbers.append(item.number)
                values.append(known)
        above = found[-1].number
    costs = np.array(values).reshape(len(values), len(axes)) * signs
    chosen = await asyncio.to_thread(non_dominated, costs)
    best = [numbers[index] for index in chosen]
    rows = {item.number: item for item in await store.chosen(sweep.sequence, best[:most])}
    return ParetoFront(
        axes=list(axes),
        considered=len(numbers),
        left_out=sweep.done - len(numbers),
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
