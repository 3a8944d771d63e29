"""What comes out of sweeps: their state and items on the wire, events, tables, the Pareto front.

Items are read page by page: memory does not grow with the sweep, but for the numbers of a front.
"""

from __future__ import annotations

import asyncio
import contextlib
import csv
import io
import json
from collections import Counter
from collections.abc import AsyncIterator, Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any, Literal

import numpy as np
from fastapi.sse import ServerSentEvent
from pydantic import BaseModel, Field, JsonValue

from service.storage.tables import ItemRow, SweepRow, in_utc
from service.sweeps.store import PAGE, STATUSES, UNDER_WAY, SweepStore
from service.sweeps.sweeps import Sweeps, spec_of
from service.wire.errors import ProblemType
from service.work import POLL_S
from service.workers.tasks import links_to
from synthesis.design.warnings import Severity
from synthesis.errors import ExtraMissing
from synthesis.exporters.diagrams.tradeoff import Aim, TradeOff
from synthesis.studies.sweeps import SweepSpec
from synthesis.studies.sweeps.pareto import distinct_front, non_dominated
from synthesis.studies.sweeps.spec import SweepAxis

SweepState = Literal["accepted", "running", "successful", "failed", "dismissed"]
ItemStatus = Literal["optimal", "feasible", "unsolved", "infeasible", "failed"]
FILES = ("items", "items.csv", "items.parquet", "pareto", "events")
PATH = "/v1/sweeps"
# Columns of tables before and after those of axes and quantities.
BEFORE = (("number", "int"), ("status", "text"), ("severity", "text"))
AFTER = (("gap", "number"), ("seconds", "number"), ("design", "text"), ("problem", "text"))
Pages = AsyncIterator[Sequence[ItemRow]]


class Counts(BaseModel):
    """How many items are done, by status."""

    items: int = Field(description="All of them.")
    done: int = Field(description="Finished, with any status.")
    optimal: int = Field(description="Certified, gap within the tolerance.")
    feasible: int = Field(description="Certified.")
    unsolved: int = Field(description="No cam was found, and none is excluded.")
    infeasible: int = Field(description="Proven that no cam fits; the design says why.")
    failed: int = Field(description="Without a design: `problem` says why.")


class SweepSummary(BaseModel):
    """A sweep and its progress."""

    id: str = Field(description="Hash of the spec and the engine's number.")
    engine: int = Field(
        description="Number of the engine that made its items; where `/v1/version` has a "
        "later one, POST the spec again for a sweep by that."
    )
    name: str = Field(description="As in the spec.")
    state: SweepState = Field(
        description="`accepted`, `running`; `successful`: gone through to the end; `failed`: "
        "no item has a design, or the service could not continue; `dismissed`: stopped."
    )
    created: datetime = Field(description="When it was accepted, UTC.")
    started: datetime | None = Field(description="When its first item was sent.")
    finished: datetime | None = Field(description="When it ended.")
    progress: float = Field(ge=0, le=100, description="Share that is done [%].")
    counts: Counts = Field(description="How many items, by status.")
    rate_per_s: float | None = Field(
        description="Current rate of finished items [1/s]; null where it is not running."
    )
    time_left_s: float | None = Field(description="Remaining time at that rate [s].")
    axes: list[str] = Field(description="The fields that it varies.")
    quantities: list[str] = Field(description="Quantities of its designs so far, with unit.")
    links: dict[str, str] = Field(description="Items, files, trade-offs, events.")


class Sweep(SweepSummary):
    """A sweep with its spec."""

    spec: SweepSpec = Field(description="The question.")


class SweepPage(BaseModel):
    """Sweeps, the newest first."""

    items: list[SweepSummary] = Field(description="The newest first.")
    next: str | None = Field(description="`cursor` of the next page; null at the end.")


class SweepItem(BaseModel):
    """One finished item of a sweep."""

    number: int = Field(description="Which: 0 upwards, the last axis changes fastest.")
    status: ItemStatus = Field(description="As the design's, or `failed`.")
    severity: Severity = Field("none", description="That of the design's worst warning.")
    values: dict[str, JsonValue] = Field(description="Value of every axis, by pointer.")
    quantities: dict[str, float] = Field(
        description="Dimensions, objectives and what else the sweep measures, with unit."
    )
    gap: float | None = Field(description="Relative distance to the bound.")
    seconds: float = Field(description="Time in the core.")
    problem: dict[str, Any] | None = Field(
        description="Why it failed, or ended before its tolerance: a problem document."
    )
    links: dict[str, str] = Field(description="The item, and the design with its files.")


class SweepItemPage(BaseModel):
    """Finished items, in the order in which they were finished."""

    items: list[SweepItem] = Field(description="In the order they were finished.")
    next: str | None = Field(
        description="`cursor` of what follows; null once the sweep has ended and nothing does. "
        "While it runs, request this again for the items finished by then."
    )


class ParetoAxis(BaseModel):
    """A quantity and its direction."""

    quantity: str = Field(description="Its name.")
    direction: Literal["minimise", "maximise"] = Field(description="Which way is better.")


class ParetoFront(BaseModel):
    """The non-dominated designs of a sweep in the quantities named."""

    axes: list[ParetoAxis] = Field(description="The quantities.")
    compared: int = Field(description="Certified designs that have every quantity.")
    excluded: int = Field(
        description="Other finished items: not certified, or without one of the quantities."
    )
    size: int = Field(description="How many are on the front.")
    indistinct: int = Field(
        description="Others that no design beats, but that are not better than one of the front "
        "by more than what does not count: see `tolerance`."
    )
    items: list[SweepItem] = Field(description="The front, ascending in the first quantity.")


def sweep_path(id: str) -> str:
    """Path of a sweep."""
    return f"{PATH}/{id}"


def summary_of(row: SweepRow, sweeps: Sweeps) -> SweepSummary:
    """A sweep as a line of the list."""
    progress = sweeps.progress(row.id)
    rate = progress.rate_per_s if progress is not None and row.state in UNDER_WAY else None
    counts = {name: getattr(row, name) for name in ("done", *STATUSES)}
    same = ("id", "engine", "name", "state", "axes", "quantities")
    times = ("created", "started", "finished")
    fields: dict[str, Any] = {name: getattr(row, name) for name in same}
    fields |= {name: in_utc(getattr(row, name)) for name in times}
    return SweepSummary(
        **fields,
        progress=100.0 * row.done / row.size,
        counts=Counts(items=row.size, **counts),
        rate_per_s=rate,
        time_left_s=(row.size - row.done) / rate if rate else None,
        links=links_to(PATH, row.id, FILES),
    )


def sweep_of(row: SweepRow, sweeps: Sweeps) -> bytes:
    """A sweep with its spec, as ``Sweep`` in JSON; the spec is as it was stored."""
    summary = summary_of(row, sweeps).model_dump_json().encode()
    return summary.removesuffix(b"}") + b',"spec":' + row.spec + b"}"


def item_of(sweep: SweepRow, row: ItemRow) -> SweepItem:
    """A finished item with its addresses."""
    names = ("number", "status", "severity", "quantities", "gap", "seconds", "problem")
    links = {"self": f"{sweep_path(sweep.id)}/items/{row.number}"}
    if row.design_id is not None:
        links["design"] = f"/v1/designs/{row.design_id}"
    return SweepItem(
        **{name: getattr(row, name) for name in names},
        values=dict(zip(sweep.axes, row.axis_values, strict=True)),
        links=links,
    )


async def events(
    sweeps: Sweeps, row: SweepRow, after: int, items: bool
) -> AsyncIterator[ServerSentEvent]:
    """The events of a sweep until it ends: of its items after a sequence number, and progress."""
    last: SweepSummary | None = None
    while True:
        progress = sweeps.progress(row.id)
        # Taken before the sweep is read, so that no change after that is missed.
        change = progress.next_change if progress else asyncio.Event()
        now = await sweeps.store.find(row.id, row.belongs_to)
        if now is None:
            return
        while items and (
            rows := await sweeps.store.items(now.sequence, ItemRow.sequence > after, size=PAGE)
        ):
            for each in rows:
                yield ServerSentEvent(data=item_of(now, each), event="item", id=str(each.sequence))
            after = rows[-1].sequence
        summary = summary_of(now, sweeps)
        if now.state not in UNDER_WAY:
            yield ServerSentEvent(data=summary, event="end")
            return
        if summary != last:
            yield ServerSentEvent(data=summary, event="progress")
            last = summary
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(change.wait(), POLL_S)


class Columns:
    """The columns of a table: the axes by their pointers, the quantities by their names."""

    def __init__(self, sweep: SweepRow, axes: Sequence[SweepAxis]) -> None:
        self._quantities = sweep.quantities
        self._numeric = [axis.numeric for axis in axes]
        self.kinds: list[tuple[str, str]] = [
            *BEFORE,
            *((axis.pointer, "number" if axis.numeric else "text") for axis in axes),
            *((name, "number") for name in sweep.quantities),
            *AFTER,
        ]

    def row(self, item: ItemRow) -> list[Any]:
        """The cells of one item; None where a cell is empty."""
        values = [
            float(value) if numeric else value if isinstance(value, str) else json.dumps(value)
            for value, numeric in zip(item.axis_values, self._numeric, strict=True)
        ]
        quantities = [item.quantities.get(name) for name in self._quantities]
        problem = None if item.problem is None else item.problem["detail"]
        own = [item.gap, item.seconds, item.design_id, problem]
        return [item.number, item.status, item.severity, *values, *quantities, *own]


async def csv_table(columns: Columns, pages: Pages) -> AsyncIterator[bytes]:
    """The bytes of comma-separated values, RFC 4180, UTF-8."""

    def lines(rows: Iterable[list[Any]]) -> bytes:
        text = io.StringIO()
        csv.writer(text).writerows(rows)
        return text.getvalue().encode()

    yield lines([[name for name, _ in columns.kinds]])
    async for page in pages:
        yield lines(map(columns.row, page))


def parquet_table(columns: Columns, pages: Pages) -> AsyncIterator[bytes]:
    """The bytes of Apache Parquet, a row group a page; ExtraMissing without pyarrow."""
    try:
        import pyarrow as pa
        from pyarrow.parquet import ParquetWriter
    except ImportError as error:
        raise ExtraMissing("A table in Parquet", "parquet") from error
    types = {"int": pa.int64(), "number": pa.float64(), "text": pa.string()}
    schema = pa.schema([(name, types[kind]) for name, kind in columns.kinds])

    async def written() -> AsyncIterator[bytes]:
        # The writer only appends, and counts its bytes itself: what was sent can be dropped.
        file = io.BytesIO()
        with ParquetWriter(pa.PythonFile(file, mode="w"), schema) as parquet:
            async for page in pages:
                cells = zip(*map(columns.row, page), strict=True)
                arrays = [
                    pa.array(each, field.type) for each, field in zip(cells, schema, strict=True)
                ]
                parquet.write_table(pa.Table.from_arrays(arrays, schema=schema))
                yield file.getvalue()
                file.seek(0)
                file.truncate()
        yield file.getvalue()

    return written()


@dataclass(frozen=True)
class TradeOffQuestion:
    """What is traded for what.

    Attributes:
        aims: the quantities. tolerance: relative difference that counts in none of them. None: in
            the objective the gap of each design does not count, up to the sweep's tolerance: its
            true optimum may be better by so much.
    """

    aims: Sequence[Aim]
    tolerance: float | None


async def objective_of(sweep: SweepRow) -> tuple[str, float]:
    """The quantity that items have a proven gap in, and the tolerance of the sweep.

    "" where an axis replaces the objective: then items have gaps in several quantities.
    """
    spec = await spec_of(sweep)
    if any(axis.pointer.startswith("/objective") for axis in spec.axes):
        return "", 0.0
    machine = spec.base.machine()
    return spec.base.objectives()[0].name_on_wire(machine), spec.base.tolerance


async def compare_designs(store: SweepStore, sweep: SweepRow, traded: TradeOffQuestion) -> TradeOff:
    """Compare the certified designs of a sweep that have all these quantities.

    ServiceError where no quantity is named, or one that no design of the sweep has.
    """
    axes, tolerance = traded.aims, traded.tolerance
    _check(sweep, [axis.quantity for axis in axes])
    signs = np.array([-1.0 if axis.maximise else 1.0 for axis in axes])
    objective, allowed = await objective_of(sweep) if tolerance is None else ("", 0.0)
    proven = [axis.quantity == objective and not axis.maximise for axis in axes]
    numbers: list[int] = []
    values: list[list[float]] = []
    gaps: list[float] = []
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
                gaps.append(min(item.gap or 0.0, allowed))
    table = np.array(values).reshape(len(values), len(axes))
    shares = np.outer(gaps, proven) if tolerance is None else np.full_like(table, tolerance)
    costs = table * signs
    strict = await asyncio.to_thread(non_dominated, costs)
    best = (costs - shares * np.abs(table))[strict]
    front = strict[await asyncio.to_thread(distinct_front, costs[strict], best)]
    return TradeOff(sweep.name, axes, numbers, table, front, left_out, strict)


async def pareto_front(
    store: SweepStore, sweep: SweepRow, traded: TradeOffQuestion, most: int
) -> ParetoFront:
    """The non-dominated designs of a sweep in these quantities; see ``compare_designs``."""
    comparison = await compare_designs(store, sweep, traded)
    best = [comparison.numbers[index] for index in comparison.front]
    shown = await store.items(sweep.sequence, ItemRow.number.in_(best[:most]))
    rows = {item.number: item for item in shown}
    return ParetoFront(
        axes=[
            ParetoAxis(
                quantity=axis.quantity, direction="maximise" if axis.maximise else "minimise"
            )
            for axis in traded.aims
        ],
        compared=len(comparison.numbers),
        excluded=sweep.done - len(comparison.numbers),
        size=len(best),
        indistinct=len(comparison.edge) - len(best),
        items=[item_of(sweep, rows[number]) for number in best[:most] if number in rows],
    )


def _check(sweep: SweepRow, names: Sequence[str]) -> None:
    known = ", ".join(sweep.quantities) or "nothing so far"
    fault = None if names else f"name at least one quantity. Measured in this sweep: {known}."
    for name in names:
        if names.count(name) > 1:
            fault = f"{name!r} is named twice. Name it once."
        elif name not in sweep.quantities:
            fault = (
                f"{name[:80]!r} is not measured on any design of this sweep. Measured are: "
                f"{known}. The field `quantities` of a sweep's spec adds to these."
            )
    if fault is not None:
        raise ProblemType.INVALID_PARAMETER(f"minimise, maximise: {fault}")
