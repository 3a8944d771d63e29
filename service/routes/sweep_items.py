"""/v1/sweeps/{id}/items and what is made of them: pages, files, the Pareto front."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query

from service.documentation import problems
from service.errors import UnknownSweep
from service.routes.sweeps import Known
from service.state import Parts
from service.sweeps.store import UNDER_WAY
from service.sweeps.views import ItemStatus, SweepItem, SweepItemPage, item_of, items_of
from service.views import cursor_at, position_of

router = APIRouter(prefix="/v1/sweeps/{sweep_id}", tags=["sweeps"])


@router.get("/items", summary="Finished items", responses=problems(404, 422))
async def list_sweep_items(
    sweep: Known,
    parts: Parts,
    limit: Annotated[int, Query(ge=1, le=1000, description="Items on a page.")] = 100,
    cursor: Annotated[str | None, Query(description="`next` of the page before.")] = None,
    status: Annotated[ItemStatus | None, Query(description="Only those with this status.")] = None,
) -> SweepItemPage:
    """In the order in which they were finished, so that following `next` misses none."""
    after = 0 if cursor is None else position_of(cursor)
    rows = await parts.sweeps.store.items(sweep.sequence, after, limit + 1, status)
    shown = rows[:limit]
    over = len(rows) <= limit and sweep.state not in UNDER_WAY
    following = None if over else cursor_at(shown[-1].sequence if shown else after)
    return SweepItemPage(items=items_of(sweep, shown), next=following)


@router.get("/items/{number}", summary="One item", responses=problems(404, 422))
async def get_sweep_item(sweep: Known, number: int, parts: Parts) -> SweepItem:
    """Its values, what came out, and where the design is."""
    row = None
    if 0 <= number < sweep.size:
        row = await parts.sweeps.store.item(sweep.sequence, number)
    if row is None:
        raise UnknownSweep(
            f"Item {number} of sweep {sweep.id} is not finished, or there is none: "
            f"they are numbered from 0 to {sweep.size - 1}."
        )
    return item_of(sweep, row)
