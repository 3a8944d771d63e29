"""Finished items as a table, written page by page: memory does not grow with the sweep."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import AsyncIterator, Iterable, Sequence
from typing import Any

from service.sweeps.store import ItemRow, SweepRow
from service.wire.errors import ProblemType
from synthesis.studies.sweeps import SweepSpec

BEFORE = (("number", "int"), ("status", "text"))
AFTER = (("gap", "number"), ("seconds", "number"), ("design", "text"), ("problem", "text"))
Pages = AsyncIterator[Sequence[ItemRow]]


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
        file = _AppendOnly()
        with ParquetWriter(pa.PythonFile(file, mode="w"), schema) as parquet:
            async for page in pages:
                cells = zip(*map(columns.row, page), strict=True)
                arrays = [
                    pa.array(column, field.type)
                    for column, field in zip(cells, schema, strict=True)
                ]
                parquet.write_table(pa.Table.from_arrays(arrays, schema=schema))
                yield file.take()
        yield file.take()

    return written()


class _AppendOnly(io.RawIOBase):
    """A file that is only appended to; keeps what was not taken yet."""

    def __init__(self) -> None:
        self._bytes, self._at = bytearray(), 0

    def writable(self) -> bool:
        return True

    def write(self, data: Any) -> int:
        self._bytes += data
        self._at += len(data)
        return len(data)

    def tell(self) -> int:
        return self._at

    def take(self) -> bytes:
        """What was written since the last time."""
        taken, self._bytes = bytes(self._bytes), bytearray()
        return taken


def _text(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value)
