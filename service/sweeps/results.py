"""What is made of the finished items of a sweep: tables, and the Pareto front.

Items are read page by page: memory does not grow with the sweep, but for the numbers of a front.
"""

from __future__ import annotations

import asyncio
import csv
import io
import json
from collections import Counter
from collections.abc import AsyncIterator, Iterable, Sequence
from typing import Any

import numpy as np

from service.storage.tables import ItemRow, SweepRow
from service.sweeps.store import SweepStore
from service.sweeps.views import ParetoAxis, ParetoFront, item_of
from service.wire.errors import ProblemType
from synthesis.exporters.diagrams.tradeoff import Aim, TradeOff
from synthesis.studies.sweeps import SweepSpec
from synthesis.studies.sweeps.pareto import non_dominated

BEFORE = (("number", "int"), ("status", "text"))
AFTER = (("gap", "number"), ("seconds", "number"), ("design", "text"), ("problem", "text"))
Pages = AsyncIterator[Sequence[ItemRow]]


class Columns:
    """The columns of a table: the axes by their pointers, the quantities by their names."""

    def __init__(self, sweep: SweepRow) -> None:
        axes = SweepSpec.model_validate_json(sweep.spec).axes
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
        return [item.number, item.status, *values, *quantities, *own]


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
    """The bytes of Apache Parquet, a row group a page.

    Raises:
        ServiceError: pyarrow is not installed.
    """
    try:
        import pyarrow as pa
        from pyarrow.parquet import ParquetWriter
    except ImportError:
        raise ProblemType.FORMAT_MISSING(
            "Parquet needs the extra `parquet` of Camwright, which is not installed on this "
            "server. Take items.csv, or ask the operator to install pyarrow."
        ) from None
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


async def compare_designs(store: SweepStore, sweep: SweepRow, axes: Sequence[Aim]) -> TradeOff:
    """Compare the certified designs of a sweep that have all these quantities.

    Raises:
        ServiceError: no quantity is named, or one that no design of the sweep has.
    """
    _check(sweep, [axis.quantity for axis in axes])
    signs = np.array([-1.0 if axis.maximise else 1.0 for axis in axes])
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
    return TradeOff(sweep.name, axes, numbers, table, front, left_out)


async def pareto_front(
    store: SweepStore, sweep: SweepRow, axes: Sequence[Aim], most: int
) -> ParetoFront:
    """The non-dominated designs of a sweep in these quantities; see ``compare_designs``."""
    comparison = await compare_designs(store, sweep, axes)
    best = [comparison.numbers[index] for index in comparison.front]
    shown = await store.items(sweep.sequence, ItemRow.number.in_(best[:most]))
    rows = {item.number: item for item in shown}
    return ParetoFront(
        axes=[
            ParetoAxis(
                quantity=axis.quantity, direction="maximise" if axis.maximise else "minimise"
            )
            for axis in axes
        ],
        compared=len(comparison.numbers),
        excluded=sweep.done - len(comparison.numbers),
        size=len(best),
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
