"""/v1/sweeps: start a sweep, list, watch, stop or delete it."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator
from typing import Annotated

from fastapi import APIRouter, Depends, Header, Query, Request, Response
from fastapi.sse import EventSourceResponse, ServerSentEvent

from service.contract.documentation import UNDER_WAY_HEADERS, problems, spec_body
from service.contract.examples import SWEEPS
from service.routes.resource_routes import Key, check_key, position_of
from service.state import Parts, State
from service.storage.tables import ItemRow, SweepRow
from service.sweeps.store import UNDER_WAY
from service.sweeps.views import (
    Sweep,
    SweepPage,
    SweepState,
    SweepSummary,
    item_of,
    summary_of,
    sweep_of,
    sweep_path,
)
from service.wire.body import read_body
from service.wire.errors import ProblemType
from synthesis.studies.sweeps import SweepSpec

router = APIRouter(prefix="/v1/sweeps", tags=["sweeps"])
BATCH = 200  # items read at once for a stream of events
POLL_S = 1.0  # between reads of a sweep that another process works on


async def known(sweep_id: str, parts: Parts) -> SweepRow:
    """The sweep with this id."""
    row = await parts.sweeps.store.find(sweep_id)
    if row is None:
        raise ProblemType.UNKNOWN_SWEEP(
            f"There is no sweep {sweep_id[:64]!r}. GET /v1/sweeps lists those there are; POST the "
            "spec again to start it anew."
        )
    return row


def _last_event(
    last_event_id: Annotated[
        str | None, Header(description="Id of the last event received; the stream continues there.")
    ] = None,
) -> int:
    return position_of(last_event_id) if last_event_id else 0


Known = Annotated[SweepRow, Depends(known)]
After = Annotated[int, Depends(_last_event)]


@router.post(
    "",
    status_code=202,
    response_model=Sweep,
    responses={
        202: {"description": "Running, or finished already: see `state`.",
              "headers": UNDER_WAY_HEADERS},
        **problems(400, 413, 415, 422, 429, 503),
    },
    openapi_extra=spec_body(SWEEPS, "SweepSpec"),
    summary="Start a sweep",
)  # fmt: skip
async def create_sweep(
    request: Request, response: Response, parts: Parts, idempotency_key: Key = None
) -> Sweep:
    """Many designs out of one: the base with other values in some of its fields.

    The same spec gives the same sweep: a second request joins it, or continues it where it was
    dismissed. Every finished item is stored before it is counted, and a restart of the service, of
    the scheduler or of a worker loses none.
    """
    spec = await read_body(request, SweepSpec)
    parts.sweeps.check(spec)
    await check_key(parts, idempotency_key, await request.body())
    row = await parts.sweeps.accept(spec)
    response.headers.update({"Location": sweep_path(row.id), "Retry-After": "1"})
    return _sweep(parts, row)


@router.get("", summary="List sweeps", responses=problems(422))
async def list_sweeps(
    parts: Parts,
    limit: Annotated[int, Query(ge=1, le=200, description="Sweeps on a page.")] = 50,
    cursor: Annotated[str | None, Query(description="`next` of the page before.")] = None,
    state: Annotated[SweepState | None, Query(description="Only those in this state.")] = None,
) -> SweepPage:
    """The newest first."""
    before = None if cursor is None else position_of(cursor)
    rows = await parts.sweeps.store.page(before, limit + 1, state)
    following = str(rows[limit - 1].sequence) if len(rows) > limit else None
    return SweepPage(items=[_summary(parts, row) for row in rows[:limit]], next=following)


@router.get("/{sweep_id}", summary="A sweep", responses=problems(404))
async def get_sweep(row: Known, parts: Parts) -> Sweep:
    """State, progress, counts, rate and time left; the spec; links."""
    return _sweep(parts, row)


@router.delete(
    "/{sweep_id}",
    response_model=Sweep,
    responses={
        200: {
            "description": "It was running: stopped, and what is done is kept. Or it was finished, "
            "and is kept as `discard=false` asks."
        },
        204: {"description": "It was finished: deleted with all its items."},
        **problems(404),
    },
    summary="Stop or delete a sweep",
)
async def delete_sweep(
    row: Known,
    parts: Parts,
    discard: Annotated[
        bool, Query(description="false: stop it only; one that is finished stays as it is.")
    ] = True,
) -> Response:
    """A running one is stopped within a second, its items are kept; a finished one is deleted."""
    stopped = await parts.sweeps.dismiss(row)
    if stopped is None and not discard:
        stopped = await parts.sweeps.store.find(row.id)
    if stopped is not None:
        return Response(_sweep(parts, stopped).model_dump_json(), 200, None, "application/json")
    await parts.sweeps.store.delete(row.sequence)
    return Response(status_code=204)


@router.get(
    "/{sweep_id}/events",
    response_class=EventSourceResponse,
    responses={**problems(404, 422)},
    summary="Watch a sweep",
)
async def watch_sweep(
    row: Known,
    after: After,
    parts: Parts,
    items: Annotated[
        bool, Query(description="Send an event for every item; otherwise for progress only.")
    ] = True,
) -> AsyncIterator[ServerSentEvent]:
    """Server-sent events: `item` for every finished item, `progress`, and `end` as the last one.

    The data of `item` is as in the list of items, that of the others the sweep's summary. Every
    `item` has an id; sent back as Last-Event-ID, as browsers do, the stream continues with the next
    one.
    """
    async for event in _events(parts, row, after, items):
        yield event


async def _events(
    parts: State, row: SweepRow, after: int, items: bool
) -> AsyncIterator[ServerSentEvent]:
    last: SweepSummary | None = None
    while True:
        progress = parts.sweeps.progress(row.id)
        # Taken before the sweep is read, so that no change after that is missed.
        change = progress.next_change if progress else asyncio.Event()
        now = await parts.sweeps.store.find(row.id)
        if now is None:
            return
        while items and (
            rows := await parts.sweeps.store.items(
                now.sequence, ItemRow.sequence > after, size=BATCH
            )
        ):
            for each in rows:
                yield ServerSentEvent(data=item_of(now, each), event="item", id=str(each.sequence))
            after = rows[-1].sequence
        summary = _summary(parts, now)
        if now.state not in UNDER_WAY:
            yield ServerSentEvent(data=summary, event="end")
            return
        if summary != last:
            yield ServerSentEvent(data=summary, event="progress")
            last = summary
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(change.wait(), POLL_S)


def _sweep(parts: State, row: SweepRow) -> Sweep:
    return sweep_of(row, parts.sweeps.progress(row.id))


def _summary(parts: State, row: SweepRow) -> SweepSummary:
    return summary_of(row, parts.sweeps.progress(row.id))
