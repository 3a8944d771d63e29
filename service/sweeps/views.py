"""Sweeps and their items on the wire."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator
from datetime import datetime
from typing import Any, Literal

from fastapi.sse import ServerSentEvent
from pydantic import BaseModel, Field, JsonValue

from service.storage.tables import ItemRow, SweepRow, in_utc
from service.sweeps.store import STATUSES, UNDER_WAY
from service.sweeps.sweeps import Sweeps
from service.workers.tasks import links_to
from synthesis.studies.sweeps import SweepSpec

SweepState = Literal["accepted", "running", "successful", "failed", "dismissed"]
ItemStatus = Literal["optimal", "feasible", "infeasible", "failed"]
BATCH = 200  # items read at once for a stream of events
POLL_S = 1.0  # between reads of a sweep that another process works on
FILES = ("items", "items.csv", "items.parquet", "pareto", "events")
PATH = "/v1/sweeps"


class Counts(BaseModel):
    """How many items are done, by status."""

    items: int = Field(description="All of them.")
    done: int = Field(description="Finished, with any status.")
    optimal: int = Field(description="Certified, gap within the tolerance.")
    feasible: int = Field(description="Certified.")
    infeasible: int = Field(description="No cam fits; the design says why.")
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
    items: list[SweepItem] = Field(description="The front, ascending in the first quantity.")


def sweep_path(id: str) -> str:
    """Path of a sweep."""
    return f"{PATH}/{id}"


def summary_of(row: SweepRow, sweeps: Sweeps) -> SweepSummary:
    """A sweep as a line of the list."""
    return SweepSummary(**_fields(row, sweeps))


def sweep_of(row: SweepRow, sweeps: Sweeps) -> Sweep:
    """A sweep with its spec."""
    return Sweep(**_fields(row, sweeps), spec=SweepSpec.model_validate_json(row.spec))


def _fields(row: SweepRow, sweeps: Sweeps) -> dict[str, Any]:
    progress = sweeps.progress(row.id)
    rate = progress.rate_per_s if progress is not None and row.state in UNDER_WAY else None
    counts = {name: getattr(row, name) for name in ("done", *STATUSES)}
    return {
        **{name: getattr(row, name) for name in ("id", "engine", "name", "axes", "quantities")},
        **{name: in_utc(getattr(row, name)) for name in ("created", "started", "finished")},
        "state": row.state,
        "progress": 100.0 * row.done / row.size,
        "counts": Counts(items=row.size, **counts),
        "rate_per_s": rate,
        "time_left_s": (row.size - row.done) / rate if rate else None,
        "links": links_to(PATH, row.id, FILES),
    }


def item_of(sweep: SweepRow, row: ItemRow) -> SweepItem:
    """A finished item with its addresses."""
    names = ("number", "status", "quantities", "gap", "seconds", "problem")
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
        now = await sweeps.store.find(row.id)
        if now is None:
            return
        while items and (
            rows := await sweeps.store.items(now.sequence, ItemRow.sequence > after, size=BATCH)
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
