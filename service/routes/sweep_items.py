"""/v1/sweeps/{id}/items, their tables, and the Pareto front."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from functools import partial
from typing import Annotated

from fastapi import APIRouter, Depends, Query, Request, Response
from fastapi.responses import StreamingResponse

from service.contract.documentation import in_parts, problems, tagged
from service.routes.file_routes import (
    PNG,
    SVG,
    WORKER_STATUSES,
    download_headers,
    file_stem,
    in_worker,
)
from service.routes.resource_routes import position_of
from service.routes.sweeps import Known
from service.state import Parts, State
from service.storage.tables import ItemRow, SweepRow
from service.sweeps.results import (
    Columns,
    Pages,
    compare_designs,
    csv_table,
    pareto_front,
    parquet_table,
)
from service.sweeps.store import UNDER_WAY
from service.sweeps.views import (
    ItemStatus,
    ParetoAxis,
    ParetoFront,
    SweepItem,
    SweepItemPage,
    item_of,
)
from service.wire.conditional import IN_PARTS, not_modified, tag_of
from service.wire.errors import ProblemType
from synthesis.exporters.diagrams.tradeoff import Aim, TradeOff, trade_off
from synthesis.exporters.drawing.raster import rasterise
from synthesis.exporters.options import Colours, PixelColours, PixelWidth

router = APIRouter(prefix="/v1/sweeps/{sweep_id}", tags=["sweeps"])
MEDIA_TYPES = {"csv": "text/csv; charset=utf-8", "parquet": "application/vnd.apache.parquet"}
MAX_FRONT, MAX_DRAWN = 2000, 4


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
    where = [ItemRow.sequence > after]
    if status is not None:
        where.append(ItemRow.status == status)
    rows = await parts.sweeps.store.items(sweep.sequence, *where, size=limit + 1)
    shown = rows[:limit]
    over = len(rows) <= limit and sweep.state not in UNDER_WAY
    following = None if over else str(shown[-1].sequence if shown else after)
    return SweepItemPage(items=[item_of(sweep, row) for row in shown], next=following)


@router.get("/items/{number}", summary="One item", responses=problems(404, 422))
async def get_sweep_item(sweep: Known, number: int, parts: Parts) -> SweepItem:
    """Its values, status and quantities, and the address of its design."""
    row = None
    if 0 <= number < sweep.size:
        row = await parts.sweeps.store.item(sweep.sequence, number)
    if row is None:
        raise ProblemType.UNKNOWN_SWEEP(
            f"Item {number} of sweep {sweep.id} is not finished, or there is none: "
            f"they are numbered from 0 to {sweep.size - 1}."
        )
    return item_of(sweep, row)


def _add_table(
    extension: str,
    schema: dict[str, str],
    write: Callable[[Columns, Pages], AsyncIterator[bytes]],
    title: str,
    text: str,
    *statuses: int,
) -> None:
    """Add the route of a table; ``statuses``: what may go wrong besides."""
    media_type = MEDIA_TYPES[extension]

    async def handler(request: Request, sweep: Known, parts: Parts) -> Response:
        def body() -> AsyncIterator[bytes]:
            return write(Columns(sweep), parts.sweeps.store.pages(sweep.sequence))

        name = f'attachment; filename="{file_stem(sweep.name)}-items.{extension}"'
        headers = {"Content-Disposition": name}
        tag = _tag(sweep, extension)
        if tag is not None:
            known = not_modified(request, tag)
            if known is not None:
                return known
            headers |= {"ETag": f'"{tag}"', **IN_PARTS}
            if "range" in request.headers:  # Content-Range needs the total: written once to count
                headers["Content-Length"] = str(sum([len(chunk) async for chunk in body()]))
        return StreamingResponse(body(), 200, headers, media_type)

    router.add_api_route(
        f"/items.{extension}", handler, name=f"get_sweep_items_{extension}", summary=title,
        description=text, response_class=StreamingResponse,
        responses={
            **in_parts(description="The table.", content={media_type: {"schema": schema}}),
            **problems(404, *statuses),
        },
    )  # fmt: skip


_add_table(
    "csv", {"type": "string"}, csv_table, "Finished items as CSV",
    "A row for each item, by number: status, axes, quantities, gap, seconds, design, problem.\n\n"
    "Once the sweep has ended, it has a tag, and parts of it can be requested.",
)  # fmt: skip
_add_table(
    "parquet", {"type": "string", "format": "binary"}, parquet_table, "Finished items as Parquet",
    "The same table for data frames; axes of numbers and quantities are doubles.", 501,
)  # fmt: skip


QUANTITIES = 8  # that one front may be of


def _axes(
    minimise: Annotated[
        list[str],
        Query(max_length=QUANTITIES, description="Quantity to minimise; may be repeated."),
    ] = [],  # noqa: B006 (never changed)
    maximise: Annotated[
        list[str],
        Query(max_length=QUANTITIES, description="Quantity to maximise; may be repeated."),
    ] = [],  # noqa: B006
) -> list[ParetoAxis]:
    return [
        *(ParetoAxis(quantity=name, direction="minimise") for name in minimise),
        *(ParetoAxis(quantity=name, direction="maximise") for name in maximise),
    ]


Axes = Annotated[list[ParetoAxis], Depends(_axes)]


@router.get("/pareto", summary="The Pareto front", responses=problems(404, 422))
async def get_sweep_pareto(
    sweep: Known,
    parts: Parts,
    axes: Axes,
    limit: Annotated[int, Query(ge=1, le=MAX_FRONT, description="Most items of the front.")] = 500,
) -> ParetoFront:
    """The certified designs that are not dominated by another in the quantities named.

    `quantities` of the sweep says what can be named. `size` is the number of designs on the front,
    which may be more than `limit`.
    """
    return await pareto_front(parts.sweeps.store, sweep, axes, limit)


@router.get(
    "/pareto.svg",
    response_class=Response,
    responses={
        **tagged(description="The drawing.", content={SVG: {"schema": {"type": "string"}}}),
        **problems(404, 422),
    },
    summary="The Pareto front as a drawing",
)
async def get_sweep_pareto_svg(
    request: Request,
    sweep: Known,
    parts: Parts,
    axes: Axes,
    theme: Annotated[Colours, Query()] = "auto",
) -> Response:
    """The front among all certified designs: two to four quantities, a panel for every pair.

    Items that are not shown, such as infeasible designs, are counted. It has a tag once the
    sweep has ended.
    """

    async def paint(drawn: TradeOff) -> bytes:
        return await asyncio.to_thread(trade_off, drawn, theme)

    file = ("pareto.svg", SVG)
    return await _drawn(request, sweep, parts, axes, file, (theme,), paint)


@router.get(
    "/pareto.png",
    response_class=Response,
    responses={
        **tagged(
            description="The picture.",
            content={PNG: {"schema": {"type": "string", "format": "binary"}}},
        ),
        **problems(404, 422, *WORKER_STATUSES),
    },
    summary="The Pareto front as pixels",
)
async def get_sweep_pareto_png(
    request: Request,
    sweep: Known,
    parts: Parts,
    axes: Axes,
    theme: Annotated[PixelColours, Query()] = "light",
    width_px: Annotated[PixelWidth, Query()] = 1600,
) -> Response:
    """The drawing, painted. Needs the optional part plots; without it the answer is 501."""

    async def paint(drawn: TradeOff) -> bytes:
        return await in_worker(parts, partial(rasterise, trade_off(drawn, theme), width_px))

    file, options = ("pareto.png", PNG), (theme, str(width_px))
    return await _drawn(request, sweep, parts, axes, file, options, paint)


async def _drawn(
    request: Request,
    sweep: SweepRow,
    parts: State,
    axes: list[ParetoAxis],
    file: tuple[str, str],
    options: tuple[str, ...],
    paint: Callable[[TradeOff], Awaitable[bytes]],
) -> Response:
    """A picture of the front, or 304."""
    if not 2 <= len(axes) <= MAX_DRAWN:
        raise ProblemType.INVALID_PARAMETER(
            f"minimise, maximise: {len(axes)} named. Name two to {MAX_DRAWN} quantities to draw."
        )
    name, media_type = file
    headers = download_headers(sweep.name, name, media_type)
    tag = _tag(sweep, name, repr(axes), *options)
    if tag is not None:
        known = not_modified(request, tag)
        if known is not None:
            return known
        headers |= {"ETag": f'"{tag}"'}
    comparison = await compare_designs(parts.sweeps.store, sweep, axes)
    aims = [Aim(axis.quantity, axis.direction == "maximise") for axis in axes]
    drawn = TradeOff(
        sweep.name, aims, comparison.numbers, comparison.values, comparison.front,
        comparison.left_out,
    )  # fmt: skip
    return Response(await paint(drawn), 200, headers, media_type)


def _tag(sweep: SweepRow, *made_by: str) -> str | None:
    """Tag of what is made of a sweep's items; None until the sweep has ended."""
    if sweep.state in UNDER_WAY:
        return None
    return tag_of(sweep.id, sweep.created.isoformat(), str(sweep.done), *made_by)
