"""/v1/sweeps: start a sweep, list, watch, stop or delete it; its items, tables and Pareto front."""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable
from functools import partial
from typing import Annotated

from fastapi import APIRouter, Depends, Header, Query, Request, Response
from fastapi.responses import StreamingResponse
from fastapi.sse import EventSourceResponse, ServerSentEvent

from service.contract.documentation import (
    UNDER_WAY_HEADERS,
    etag_response,
    file_response,
    problems,
    spec_body,
)
from service.routes.files import PNG, SVG, content_of, download_headers, make_beside, make_in_worker
from service.routes.resource_routes import Cursor, Key, check_key, newest, position_of
from service.state import Parts, State, hold_stream
from service.storage.tables import ItemRow, SweepRow
from service.sweeps import views
from service.sweeps.question import read_sweep
from service.sweeps.store import UNDER_WAY
from service.sweeps.sweeps import id_of, spec_of
from service.wire.body import receive_body
from service.wire.conditional import IN_PARTS, not_modified, tag_of
from service.wire.errors import ProblemType
from synthesis.exporters.diagrams.tradeoff import Aim, TradeOff, trade_off
from synthesis.exporters.drawing.raster import rasterise
from synthesis.exporters.options import Colours, PixelColours, PixelWidth

router = APIRouter(prefix="/v1/sweeps", tags=["sweeps"])
MAX_FRONT = 2000  # items of a front in one answer: about 1 MB
MAX_DRAWN = 4  # quantities of a drawing: six panels, one for each pair
QUANTITIES = 8  # that one front may be of


async def find_sweep(sweep_id: str, parts: Parts) -> SweepRow:
    """The sweep with this id."""
    row = await parts.sweeps.store.find(sweep_id, parts.owner)
    if row is None:
        raise ProblemType.UNKNOWN_SWEEP(
            f"There is no sweep {sweep_id[:64]!r}. GET /v1/sweeps lists those there are; POST the "
            "spec again to start it anew."
        )
    return row


async def _last_event(
    last_event_id: Annotated[
        str | None, Header(description="Id of the last event received; the stream continues there.")
    ] = None,
) -> int:
    return position_of(last_event_id) if last_event_id else 0


RequestedSweep = Annotated[SweepRow, Depends(find_sweep)]
After = Annotated[int, Depends(_last_event)]


@router.post(
    "",
    status_code=202,
    response_model=views.Sweep,
    responses={
        202: {"description": "Running, or finished already: see `state`.",
              "headers": UNDER_WAY_HEADERS},
        **problems(413, 415, 422),
    },
    openapi_extra=spec_body("sweeps", "SweepSpec"),
    summary="Start a sweep",
)  # fmt: skip
async def create_sweep(request: Request, parts: Parts, idempotency_key: Key = None) -> Response:
    """Many designs out of one: the base with other values in some of its fields.

    The same spec gives the same sweep: a second request joins it, or continues it where it was
    dismissed. Every finished item is stored before it is counted, and a restart of the service, of
    the scheduler or of a worker loses none.
    """
    body = await receive_body(request, parts.settings.max_body_bytes)
    question = await parts.readers.run(read_sweep, body, parts.settings.max_sweep_items)
    await check_key(parts, idempotency_key, body)
    async with parts.quotas.room(parts.caller, id_of(question.id, parts.owner)):
        row = await parts.sweeps.accept(question, parts.owner)
    headers = {"Location": views.sweep_path(row.id), "Retry-After": "1"}
    return Response(views.sweep_of(row, parts.sweeps), 202, headers, "application/json")


@router.get("", summary="List sweeps", responses=problems(422))
async def list_sweeps(
    parts: Parts,
    limit: Annotated[int, Query(ge=1, le=200, description="How many on a page.")] = 50,
    cursor: Cursor = None,
    state: Annotated[
        views.SweepState | None, Query(description="Only those in this state.")
    ] = None,
) -> views.SweepPage:
    """The newest first."""
    rows, following = await newest(parts.sweeps.store, parts.owner, limit, cursor, state)
    items = [views.summary_of(row, parts.sweeps) for row in rows]
    return views.SweepPage(items=items, next=following)


@router.get("/{sweep_id}", response_model=views.Sweep, summary="A sweep", responses=problems(404))
async def get_sweep(row: RequestedSweep, parts: Parts) -> Response:
    """State, progress, counts, rate and time left; the spec; links."""
    return Response(views.sweep_of(row, parts.sweeps), media_type="application/json")


@router.delete(
    "/{sweep_id}",
    response_model=views.Sweep,
    responses={
        200: {
            "description": "It was running: stopped, and what is done is kept. Or it was finished, "
            "and is kept as `discard=false` asks."
        },
        204: {"description": "It was finished: deleted with all its items."},
        **problems(404, 422),
    },
    summary="Stop or delete a sweep",
)
async def delete_sweep(
    row: RequestedSweep,
    parts: Parts,
    discard: Annotated[
        bool, Query(description="false: stop it only; one that is finished stays as it is.")
    ] = True,
) -> Response:
    """A running one is stopped within a second, its items are kept; a finished one is deleted."""
    stopped = await parts.sweeps.dismiss(row)
    if stopped is None and not discard:
        stopped = await parts.sweeps.store.find(row.id, parts.owner)
    if stopped is not None:
        return Response(views.sweep_of(stopped, parts.sweeps), media_type="application/json")
    await parts.sweeps.store.delete(row.sequence)
    return Response(status_code=204)


@router.get(
    "/{sweep_id}/events",
    response_class=EventSourceResponse,
    dependencies=[Depends(hold_stream)],
    responses=problems(404, 422),
    summary="Watch a sweep",
)
async def watch_sweep(
    row: RequestedSweep,
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
    async for event in views.events(parts.sweeps, row, after, items):
        yield event


@router.get("/{sweep_id}/items", summary="Finished items", responses=problems(404, 422))
async def list_sweep_items(
    sweep: RequestedSweep,
    parts: Parts,
    limit: Annotated[int, Query(ge=1, le=1000, description="How many on a page.")] = 100,
    cursor: Cursor = None,
    status: Annotated[
        views.ItemStatus | None, Query(description="Only those with this status.")
    ] = None,
) -> views.SweepItemPage:
    """In the order in which they were finished, so that following `next` misses none."""
    after = 0 if cursor is None else position_of(cursor)
    where = [ItemRow.sequence > after]
    if status is not None:
        where.append(ItemRow.status == status)
    rows = await parts.sweeps.store.items(sweep.sequence, *where, size=limit + 1)
    shown = rows[:limit]
    # More may follow for as long as the sweep runs.
    over = len(rows) <= limit and sweep.state not in UNDER_WAY
    following = None if over else str(shown[-1].sequence if shown else after)
    return views.SweepItemPage(items=[views.item_of(sweep, row) for row in shown], next=following)


@router.get("/{sweep_id}/items/{number}", summary="One item", responses=problems(404, 422))
async def get_sweep_item(sweep: RequestedSweep, number: int, parts: Parts) -> views.SweepItem:
    """Its values, status and quantities, and the address of its design."""
    return views.item_of(sweep, await find_item(sweep, number, parts))


async def find_item(sweep: SweepRow, number: int, parts: State) -> ItemRow:
    """The finished item with this number."""
    there = 0 <= number < sweep.size
    row = await parts.sweeps.store.item(sweep.sequence, number) if there else None
    if row is None:
        raise ProblemType.UNKNOWN_SWEEP(
            f"Item {number} of sweep {sweep.id} is not finished, or there is none: "
            f"they are numbered from 0 to {sweep.size - 1}."
        )
    return row


def _add_table(
    extension: str,
    media_type: str,
    write: Callable[[views.Columns, views.Pages], AsyncIterator[bytes]],
    title: str,
    text: str,
    may_lack: bool = False,
) -> None:
    """Add the route of a table; ``may_lack``: whether it takes an optional part."""

    async def handler(request: Request, sweep: RequestedSweep, parts: Parts) -> Response:
        def body() -> AsyncIterator[bytes]:
            return write(views.Columns(sweep, axes), parts.sweeps.store.pages(sweep.sequence))

        tag = _tag(request, sweep, extension)
        if isinstance(tag, Response):
            return tag
        axes = (await spec_of(sweep)).axes
        headers = download_headers(sweep.name, f"items.{extension}", media_type) | tag
        if tag:
            headers |= IN_PARTS
            if "range" in request.headers:  # Content-Range needs the total: written once to count
                headers["Content-Length"] = str(sum([len(chunk) async for chunk in body()]))
        return StreamingResponse(body(), 200, headers, media_type)

    router.add_api_route(
        f"/{{sweep_id}}/items.{extension}", handler, name=f"get_sweep_items_{extension}",
        summary=title, description=text, response_class=StreamingResponse,
        responses=file_response(content_of(media_type), may_lack),
    )  # fmt: skip


_add_table(
    "csv", "text/csv; charset=utf-8", views.csv_table, "Finished items as CSV",
    "A row for each item, by number: status, severity, axes, quantities, gap, seconds, design, "
    "problem.\n\nOnce the sweep has ended, it has a tag, and parts of it can be requested.",
)  # fmt: skip
_add_table(
    "parquet", "application/vnd.apache.parquet", views.parquet_table, "Finished items as Parquet",
    "The same table for data frames; axes of numbers and quantities are doubles.",
    may_lack=True,
)  # fmt: skip


FrontTolerance = Annotated[
    float | None,
    Query(
        ge=0.0,
        le=1.0,
        description="Relative difference that does not count: a design that is not better than "
        "one of the front by more than this in any quantity is left out; 0: every difference "
        "counts. Left out: in the quantity that was minimised the gap that is left between a "
        "design and its proven bound, up to the tolerance of the sweep's base; in others 0.",
    ),
]


async def _axes(
    minimise: Annotated[
        list[str],
        Query(max_length=QUANTITIES, description="Quantity to minimise; may be repeated."),
    ] = [],  # noqa: B006 (never changed)
    maximise: Annotated[
        list[str],
        Query(max_length=QUANTITIES, description="Quantity to maximise; may be repeated."),
    ] = [],  # noqa: B006
    tolerance: FrontTolerance = None,
) -> views.TradeOffQuestion:
    wanted = [(name, False) for name in minimise] + [(name, True) for name in maximise]
    return views.TradeOffQuestion([Aim(name, larger) for name, larger in wanted], tolerance)


Axes = Annotated[views.TradeOffQuestion, Depends(_axes)]


@router.get("/{sweep_id}/pareto", summary="The Pareto front", responses=problems(404, 422))
async def get_sweep_pareto(
    sweep: RequestedSweep,
    parts: Parts,
    axes: Axes,
    limit: Annotated[int, Query(ge=1, le=MAX_FRONT, description="Most items of the front.")] = 500,
) -> views.ParetoFront:
    """The certified designs that are not dominated by another in the quantities named.

    Of those that differ by less than counts (`tolerance`) one stands for the others. `quantities`
    of the sweep says what can be named. `size` is the number of designs on the front, which may be
    more than `limit`.
    """
    return await views.pareto_front(parts.sweeps.store, sweep, axes, limit)


@router.get(
    "/{sweep_id}/pareto.svg",
    response_class=Response,
    responses={
        **etag_response(description="The file.", content=content_of(SVG)),
        **problems(404, 422, 504, late=False),
    },
    summary="The Pareto front as a drawing",
)
async def get_sweep_pareto_svg(
    request: Request,
    sweep: RequestedSweep,
    parts: Parts,
    axes: Axes,
    theme: Annotated[Colours, Query()] = "auto",
) -> Response:
    """The front among all certified designs: two to four quantities, a panel for every pair.

    Items that are not shown, such as infeasible designs, are counted. It has a tag once the
    sweep has ended.
    """

    def paint(drawn: TradeOff) -> Awaitable[bytes]:
        return make_beside(request, parts, partial(trade_off, drawn, theme))

    return await _drawn(request, sweep, parts, axes, ("svg", SVG, theme), paint)


@router.get(
    "/{sweep_id}/pareto.png",
    response_class=Response,
    responses={
        **etag_response(description="The file.", content=content_of(PNG)),
        **problems(404, 422, 501, 504, late=False),
    },
    summary="The Pareto front as pixels",
)
async def get_sweep_pareto_png(
    request: Request,
    sweep: RequestedSweep,
    parts: Parts,
    axes: Axes,
    theme: Annotated[PixelColours, Query()] = "light",
    width_px: Annotated[PixelWidth, Query()] = 1600,
) -> Response:
    """The drawing, painted. Needs the optional part plots; without it the answer is 501."""

    def paint(drawn: TradeOff) -> Awaitable[bytes]:
        return make_in_worker(request, parts, partial(_pixels, drawn, theme, width_px))

    options = ("png", PNG, theme, str(width_px))
    return await _drawn(request, sweep, parts, axes, options, paint)


def _pixels(drawn: TradeOff, theme: PixelColours, width_px: int) -> bytes:
    return rasterise(trade_off(drawn, theme), width_px)


async def _drawn(
    request: Request,
    sweep: SweepRow,
    parts: State,
    axes: views.TradeOffQuestion,
    options: tuple[str, ...],
    paint: Callable[[TradeOff], Awaitable[bytes]],
) -> Response:
    """A picture of the front, or 304; ``options``: extension, media type, and what is chosen."""
    if not 2 <= len(axes.aims) <= MAX_DRAWN:
        raise ProblemType.INVALID_PARAMETER(
            f"minimise, maximise: {len(axes.aims)} named. Name two to {MAX_DRAWN} quantities."
        )
    extension, media_type, *_ = options
    tag = _tag(request, sweep, repr(axes), *options)
    if isinstance(tag, Response):
        return tag
    drawing = await paint(await views.compare_designs(parts.sweeps.store, sweep, axes))
    headers = download_headers(sweep.name, f"pareto.{extension}", media_type) | tag
    return Response(drawing, 200, headers, media_type)


def _tag(request: Request, sweep: SweepRow, *made_by: str) -> dict[str, str] | Response:
    """The header with the tag of what is made of a sweep's items, or 304 where the caller has it.

    There is no tag until the sweep has ended.
    """
    if sweep.state in UNDER_WAY:
        return {}
    tag = tag_of(sweep.id, sweep.created.isoformat(), str(sweep.done), *made_by)
    return not_modified(request, tag) or {"ETag": f'"{tag}"'}
