"""Finished items as rows of a table, written page by page: memory does not grow with the sweep."""

from __future__ import annotations

import csv
import io
import json
from abc import ABC, abstractmethod
from collections.abc import AsyncIterator, Sequence
from typing import Any

from pydantic import JsonValue

from service.sweeps.store import ItemRow, SweepRow, SweepStore
from service.wire.errors import FormatMissing
from synthesis.sweeps import SweepSpec

PAGE = 500
BEFORE = (("number", "int"), ("status", "text"))
AFTER = (("gap", "number"), ("seconds", "number"), ("design", "text"), ("problem", "text"))


class Columns:
    """What stands in which column: the axes by their pointers, the quantities by their names."""

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
        """One item; None where it has nothing to say."""
        pairs = zip(item.axis_values, self._numeric, strict=True)
        values = [float(value) if numeric else _text(value) for value, numeric in pairs]
        quantities = [item.quantities.get(name) for name in self._quantities]
        problem = None if item.problem is None else item.problem["detail"]
        own = [item.gap, item.seconds, item.design_id, problem]
        return [item.number, item.status, *values, *quantities, *own]


class Writer(ABC):
    """Turns rows into bytes."""

    @abstractmethod
    def begun(self) -> bytes:
        """What stands before all rows."""

    @abstractmethod
    def rows(self, rows: Sequence[list[Any]]) -> bytes:
        """Some rows."""

    @abstractmethod
    def ended(self) -> bytes:
        """What stands after all rows."""


class CsvWriter(Writer):
    """Comma-separated values, RFC 4180, UTF-8."""

    def __init__(self, columns: Columns) -> None:
        self._names = [name for name, _ in columns.kinds]

    def begun(self) -> bytes:
        return self.rows([self._names])

    def rows(self, rows: Sequence[list[Any]]) -> bytes:
        text = io.StringIO()
        csv.writer(text).writerows(rows)
        return text.getvalue().encode()

    def ended(self) -> bytes:
        return b""


class ParquetWriter(Writer):
    """Apache Parquet, a row group a page. Raises FormatMissing where pyarrow is not installed."""

    def __init__(self, columns: Columns) -> None:
        try:
            import pyarrow as pa
            from pyarrow.parquet import ParquetWriter as Parquet
        except ImportError:
            raise FormatMissing(
                "Parquet needs the extra `parquet` of Camwright, which this server was installed "
                "without. Take items.csv, or ask for pyarrow to be installed."
            ) from None
        types = {"int": pa.int64(), "number": pa.float64(), "text": pa.string()}
        self._pa, self._sink = pa, io.BytesIO()
        self._schema = pa.schema([(name, types[kind]) for name, kind in columns.kinds])
        self._written = 0
        self._parquet = Parquet(pa.PythonFile(_Forward(self._sink), mode="w"), self._schema)

    def begun(self) -> bytes:
        return self._drained()

    def rows(self, rows: Sequence[list[Any]]) -> bytes:
        columns = [
            self._pa.array(column, field.type)
            for column, field in zip(zip(*rows, strict=True), self._schema, strict=True)
        ]
        self._parquet.write_table(self._pa.Table.from_arrays(columns, schema=self._schema))
        return self._drained()

    def ended(self) -> bytes:
        self._parquet.close()
        return self._drained()

    def _drained(self) -> bytes:
        found = self._sink.getvalue()
        self._sink.seek(0)
        self._sink.truncate()
        return found


class _Forward(io.RawIOBase):
    """A file that only grows, and of which nothing is kept but what was not fetched yet."""

    def __init__(self, sink: io.BytesIO) -> None:
        self._sink, self._at = sink, 0

    def writable(self) -> bool:
        return True

    def write(self, data: Any) -> int:
        self._at += len(data)
        return self._sink.write(data)

    def tell(self) -> int:
        return self._at


async def written(
    store: SweepStore, sweep: SweepRow, columns: Columns, writer: Writer
) -> AsyncIterator[bytes]:
    """The whole table, in the order of the items' numbers."""
    yield writer.begun()
    above = -1
    while found := await store.numbered(sweep.sequence, above, PAGE):
        yield writer.rows([columns.row(item) for item in found])
        above = found[-1].number
    yield writer.ended()


def _text(value: JsonValue) -> str:
    return value if isinstance(value, str) else json.dumps(value)
