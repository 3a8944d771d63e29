"""How sweeps and their items look on the wire."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field, JsonValue

from service.sweeps.progress import Progress
from service.sweeps.store import UNDER_WAY, ItemRow, SweepRow
from synthesis.sweeps import SweepSpec

SweepState = Literal["accepted", "running", "successful", "failed", "dismissed"]
ItemStatus = Literal["optimal", "feasible", "infeasible", "failed"]
FILES = ("items.csv", "items.parquet")


class Counts(BaseModel):
    """How many items are done, and what came out."""

    items: Annotated[int, Field(description="All of them.")]
    done: Annotated[int, Field(description="Finished, whatever came out.")]
    optimal: Annotated[int, Field(description="Certified, gap within the tolerance.")]
    feasible: Annotated[int, Field(description="Certified.")]
    infeasible: Annotated[int, Field(description="No cam fits; the design says why.")]
    failed: Annotated[int, Field(description="Without a design: `problem` says why.")]


class SweepSummary(BaseModel):
    """A sweep: how it stands."""

    id: Annotated[str, Field(description="Hash of the spec and the engine's version.")]
    name: Annotated[str, Field(description="As in the spec.")]
    state: Annotated[
        SweepState,
        Field(
            description="`accepted`, `running`; `successful`: gone through to the end; `failed`: "
            "not one item has a design, or the service could not go on; `dismissed`: stopped."
        ),
    ]
    created: Annotated[datetime, Field(description="When it was accepted, UTC.")]
    started: Annotated[datetime | None, Field(description="When its first item was sent.")]
    finished: Annotated[datetime | None, Field(description="When it came to its end.")]
    progress: Annotated[float, Field(ge=0, le=100, description="Share that is done [%].")]
    counts: Annotated[Counts, Field(description="How many, and what came out.")]
    rate_per_s: Annotated[
        float | None, Field(description="Items a second just now; null where none are made.")
    ]
    time_left_s: Annotated[float | None, Field(description="What is left, at that rate [s].")]
    axes: Annotated[list[str], Field(description="The fields that it varies.")]
    quantities: Annotated[
        list[str], Field(description="What its designs have been measured for so far, with unit.")
    ]
    links: Annotated[dict[str, str], Field(description="Items, files, trade-offs, events.")]


class Sweep(SweepSummary):
    """A sweep and what was asked."""

    spec: Annotated[SweepSpec, Field(description="The question.")]


class SweepPage(BaseModel):
    """Sweeps, the newest first."""

    items: Annotated[list[SweepSummary], Field(description="The newest first.")]
    next: Annotated[str | None, Field(description="`cursor` of the next page; null at the end.")]


class SweepItem(BaseModel):
    """One finished item of a sweep."""

    number: Annotated[int, Field(description="Which: 0 upwards, the last axis changes fastest.")]
    status: Annotated[ItemStatus, Field(description="As the design's, or `failed`.")]
    values: Annotated[dict[str, JsonValue], Field(description="Value of every axis, by pointer.")]
    quantities: Annotated[
        dict[str, float],
        Field(description="Dimensions, objectives and what else the sweep measures, with unit."),
    ]
    gap: Annotated[float | None, Field(description="Relative distance to the bound.")]
    seconds: Annotated[float, Field(description="Time in the core.")]
    problem: Annotated[
        dict[str, Any] | None,
        Field(description="Why it failed, or ended before its tolerance: a problem document."),
    ]
    links: Annotated[dict[str, str], Field(description="The item, and the design with its files.")]


class SweepItemPage(BaseModel):
    """Finished items, in the order in which they were finished."""

    items: Annotated[list[SweepItem], Field(description="In the order they were finished.")]
    next: Annotated[
        str | None,
        Field(
            description="`cursor` of what follows; null once the sweep is over and nothing does. "
            "While it runs, ask again with it for what is finished by then."
        ),
    ]


class ParetoAxis(BaseModel):
    """One of the quantities that are traded."""

    quantity: Annotated[str, Field(description="Its name.")]
    direction: Annotated[Literal["minimise", "maximise"], Field(description="Which way is better.")]


class ParetoFront(BaseModel):
    """The designs that no other design of the sweep beats in everything that was named."""

    axes: Annotated[list[ParetoAxis], Field(description="What is traded.")]
    considered: Annotated[int, Field(description="Certified designs that have every quantity.")]
    left_out: Annotated[int, Field(description="Finished items that are none, or lack one.")]
    size: Annotated[int, Field(description="How many are on the front.")]
    items: Annotated[
        list[SweepItem], Field(description="The front, ascending in the first quantity.")
    ]


def at(name: str) -> str:
    """Address of a sweep."""
    return f"/v1/sweeps/{name}"


def summary_of(row: SweepRow, progress: Progress | None) -> SweepSummary:
    """A sweep as a line of the list."""
    return SweepSummary(**_fields(row, progress))


def sweep_of(row: SweepRow, progress: Progress | None) -> Sweep:
    """A sweep with its spec."""
    return Sweep(**_fields(row, progress), spec=SweepSpec.model_validate_json(row.spec))


def _fields(row: SweepRow, progress: Progress | None) -> dict[str, Any]:
    under_way = row.state in UNDER_WAY
    rate = progress.rate_per_s if progress is not None and under_way else None
    left = row.size - row.done
    self = at(row.id)
    return {
        "id": row.id,
        "name": row.name,
        "state": row.state,
        "created": _utc(row.created),
        "started": _utc(row.started),
        "finished": _utc(row.finished),
        "progress": 100.0 * row.done / row.size,
        "counts": Counts(
            items=row.size, done=row.done, optimal=row.optimal, feasible=row.feasible,
            infeasible=row.infeasible, failed=row.failed,
        ),
        "rate_per_s": rate,
        "time_left_s": left / rate if rate else None,
        "axes": row.axes,
        "quantities": row.quantities,
        "links": {
            "self": self,
            **{name: f"{self}/{name}" for name in ("items", *FILES, "pareto", "events")},
        },
    }  # fmt: skip


def item_of(sweep: SweepRow, row: ItemRow) -> SweepItem:
    """One finished item."""
    links = {"self": f"{at(sweep.id)}/items/{row.number}"}
    if row.design_id is not None:
        links["design"] = f"/v1/designs/{row.design_id}"
    return SweepItem(
        number=row.number,
        status=row.status,  # type: ignore[arg-type]
        values=dict(zip(sweep.axes, row.axis_values, strict=True)),
        quantities=row.quantities,
        gap=row.gap,
        seconds=row.seconds,
        problem=row.problem,
        links=links,
    )


def items_of(sweep: SweepRow, rows: Sequence[ItemRow]) -> list[SweepItem]:
    """Several."""
    return [item_of(sweep, row) for row in rows]


def _utc(moment: datetime | None) -> datetime | None:
    if moment is None or moment.tzinfo is not None:
        return moment
    return moment.replace(tzinfo=UTC)
