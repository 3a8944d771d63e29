"""A sweep as its client holds it: the document of the wire, and what can be asked about it."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from service.client.progress import as_html, shown

if TYPE_CHECKING:
    import pandas
    import pyarrow

    from service.client import Client

Json = dict[str, Any]
BEFORE, AFTER = ("number", "status", "severity"), ("gap", "seconds", "design", "problem")
"""Columns before and after those of axes and quantities, as in items.csv."""


class Sweep(dict[str, Any]):
    """A sweep as on the wire; `wait` brings it up to date.

    `to_pandas` and `to_arrow` give its finished items as a table: a row an item, by number, with
    the columns of items.csv.
    """

    def __init__(self, client: Client, document: Mapping[str, Any]) -> None:
        super().__init__(document)
        self._client = client

    def wait(self, progress: Callable[[Json], None] | bool = True) -> Sweep:
        """Wait until it ends, and show how far it is, in a notebook or on a terminal.

        ``progress``: called with the sweep's summary instead; False: nothing is shown.
        """
        show = (shown() if progress else _nothing) if isinstance(progress, bool) else progress
        show(self)
        for event in self._client.watch(self["id"], items=False):
            show(event.data)
        self.update(self._client.get(self["links"]["self"]))
        return self

    def finished(self, *, status: str | None = None) -> Iterator[Json]:
        """Its finished items, in the order in which they were finished."""
        return self._client.items(self["id"], status=status)

    def pareto(
        self,
        *,
        minimise: Sequence[str] = (),
        maximise: Sequence[str] = (),
        tolerance: float | None = None,
    ) -> Json:
        """The Pareto front in these quantities; see ``AsyncClient.pareto``."""
        return self._client.pareto(
            self["id"], minimise=minimise, maximise=maximise, tolerance=tolerance
        )

    def columns(self) -> dict[str, list[Any]]:
        """The table of its finished items, by the names of its columns."""
        now = self._client.get(self["links"]["self"])
        return table_of(now, sorted(self.finished(), key=lambda item: item["number"]))

    def to_pandas(self) -> pandas.DataFrame:
        """The table as a data frame of pandas."""
        return _library("pandas", "pandas").DataFrame(self.columns())

    def to_arrow(self) -> pyarrow.Table:
        """The table as one of Apache Arrow."""
        return _library("pyarrow", "parquet").table(self.columns())

    def _repr_html_(self) -> str:
        """What notebooks show."""
        return as_html(self)


def table_of(sweep: Mapping[str, Any], items: Sequence[Json]) -> dict[str, list[Any]]:
    """Items as columns; axes of other values than numbers and texts are texts of JSON."""
    names = (*BEFORE, *sweep["axes"], *sweep["quantities"], *AFTER)
    table: dict[str, list[Any]] = {name: [] for name in names}
    for item in items:
        design = item["links"].get("design")
        row = {
            **item,
            **item["values"],
            **item["quantities"],
            "design": None if design is None else design.rpartition("/")[2],
            "problem": None if item["problem"] is None else item["problem"]["detail"],
        }
        for name, column in table.items():
            column.append(row.get(name))
    for axis in sweep["axes"]:  # numbers are of one type, as the libraries ask for it
        if all(type(value) in (int, float) for value in table[axis]):
            table[axis] = [float(value) for value in table[axis]]
        else:
            table[axis] = [v if isinstance(v, str) else json.dumps(v) for v in table[axis]]
    return table


def _library(name: str, extra: str) -> Any:
    from importlib import import_module

    try:
        return import_module(name)
    except ImportError as error:
        raise ImportError(
            f"{name} is not installed here. Install it with: pip install 'camwright[{extra}]'"
        ) from error


def _nothing(_: Json) -> None:
    pass
