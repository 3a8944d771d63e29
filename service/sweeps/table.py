"""Finished items as a table, written page by page: memory does not grow with the sweep."""

from __future__ import annotations

import csv
import io
import json
from abc import ABC, abstractmethod
from collections.abc import AsyncIterator, Sequence
from typing import Any

from pydantic import JsonValue

from service.sweeps.store import ItemRow, SweepRow, SweepStore
from service.wire.errors import ProblemType
from synthesis.studies.sweeps import SweepSpec

PAGE = 500
BEFORE = (("number", "int"), ("status", "text"))
AFTER = (("gap", "number"), ("seconds", "number"), ("design", "text"), ("problem", "text"))


class Columns:
    """The columns: the axes by their pointers, the quantities by their names."""

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
        pairs = zip(item.axis_values, self._numeric, strict=True)
        values = [float(value) if numeric else _text(value) for value, numeric in pairs]
        quantities = [item.quantities.get(name) for name in self._quantities]
        problem = None if item.problem is None else item.problem["detail"]
        own = [item.gap, item.seconds, item.design_id, problem]
        return [item.number, item.status, *values, *quantities, *own]


class Writer(ABC):
    """Turns rows into bytes."""

    @abstractmethod
    def header(self) -> bytes:
        """The bytes before all rows."""

    @abstractmethod
    def rows(self, rows: Sequence[list[Any]]) -> bytes:
        """The bytes of some rows."""

    @abstractmethod
    def footer(self) -> bytes:
        """The bytes after all rows."""


class CsvWriter(Writer):
    """Comma-separated values, RFC 4180, UTF-8."""

    def __init__(self, columns: Columns) -> None:
        self._names = [name for name, _ in columns.kinds]

    def header(self) -> bytes:
        return self.rows([self._names])

    def rows(self, rows: Sequence[list[Any]]) -> bytes:
        text = io.StringIO()
        csv.writer(text).writerows(rows)
        return text.getvalue().encode()

    def footer(self) -> bytes:
        return b""


class ParquetWriter(Writer):
    """Apache Parquet, a row group a page. Raises ServiceError where pyarrow is not installed."""

    def __init__(self, columns: Columns) -> None:
        try:
            import pyarrow as pa
            from pyarrow.parquet import ParquetWriter as Parquet
        except ImportError:
            raise ProblemType.FORMAT_MISSING(
                "Parquet needs the extra `parquet` of Camwright, which is not installed on this "
                "server. Take items.csv, or ask the operator to install pyarrow."
            ) from None
        types = {"int": pa.int64(), "number": pa.float64(), "text": pa.string()}
        self._pa, self._sink = pa, io.BytesIO()
        self._schema = pa.schema([(name, types[kind]) for name, kind in columns.kinds])
        self._written = 0
        self._parquet = Parquet(pa.PythonFile(_AppendOnly(self._sink), mode="w"), self._schema)

    def header(self) -> bytes:
        return self._take_written()

    def rows(self, rows: Sequence[list[Any]]) -> bytes:
        columns = [
            self._pa.array(column, field.type)
            for column, field in zip(zip(*rows, strict=True), self._schema, strict=True)
        ]
        self._parquet.write_table(self._pa.Table.from_arrays(columns, schema=self._schema))
        return self._take_written()

    def footer(self) -> bytes:
        self._parquet.close()
        return self._take_written()

    def _take_written(self) -> bytes:
        found = self._sink.getvalue()
        self._sink.seek(0)
        self._sink.truncate()
        return found


class _AppendOnly(io.RawIOBase):
    """A file that is only appended to; keeps what was not taken yet."""

    def __init__(self, sink: io.BytesIO) -> None:
        self._sink, self._at = sink, 0

    def writable(self) -> bool:
        return True

    def write(self, data: Any) -> int:
        self._at += len(data)
        return self._sink.write(data)

    def tell(self) -> int:
        return self._at


async def write_table(
    store: SweepStore, sweep: SweepRow, columns: Columns, writer: Writer
) -> AsyncIterator[bytes]:
    """The whole table, in the order of the items' numbers, in pieces."""
    yield writer.header()
    above = -1
    while found := await store.items_by_number(sweep.sequence, above, PAGE):
        yield writer.rows([columns.row(item) for item in found])
        above = found[-1].number
    yield writer.footer()


def _text(value: JsonValue) -> str:
    return value if isinstance(value, str) else json.dumps(value)
