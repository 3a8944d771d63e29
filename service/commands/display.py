"""A table as it is printed, and what is printed in inches."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.table import Table as RichTable

Cell = str | float | None
MM_PER_INCH = 25.4  # mm: by definition of the inch
LEAST_DIGITS = 4  # significant, of a length in inches: a thousandth of an inch of ten
LENGTH = r"mm(?P<power>[²³⁴])?(?P<rate>/s[²³]?)?"
NUMBER = re.compile(r"-?\d+(\.\d+)?(e[+-]?\d+)?")
NUMBERS = re.compile(rf"±?{NUMBER.pattern}((, | to ){NUMBER.pattern})*")
VALUE = re.compile(rf"(?P<numbers>({NUMBER.pattern} to )?{NUMBER.pattern}) {LENGTH}(?![\w/·])")
NAMED = re.compile(rf"(?<=_)mm(?P<rest>(_per_s\d?)?) (?P<number>{NUMBER.pattern})")
UNIT = re.compile(rf"{LENGTH}")
IN_HEADING = re.compile(rf"(?:^|(?<= )){LENGTH}$")


@dataclass(frozen=True)
class Table:
    """A table, its first column to the left and the others, of numbers, to the right."""

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[Cell]]

    def drawn(self) -> RichTable:
        """For a terminal: numbers have six digits; a dash stands where there is none."""
        from rich.box import SIMPLE_HEAD
        from rich.table import Table as RichTable

        drawn = RichTable(title=self.title, title_justify="left", box=SIMPLE_HEAD)
        for i, column in enumerate(self.columns):
            drawn.add_column(column, justify="left" if i == 0 else "right", no_wrap=True)
        for row in self.rows:
            drawn.add_row(*map(_cell, row))
        return drawn


def _cell(cell: Cell) -> str:
    return "–" if cell is None else f"{cell:.6g}" if isinstance(cell, float) else cell


def in_inches(part: str | Table) -> str | Table:
    """What is printed with lengths, areas and volumes in inches, and their rates in in/s."""
    if isinstance(part, str):
        text = VALUE.sub(lambda of: f"{_scale_numbers(of['numbers'], of)} {_unit(of)}", part)
        return NAMED.sub(
            lambda found: f"in{found['rest']} {_digits(found['number'], MM_PER_INCH)}", text
        )
    # The unit of a number stands in its row, or in the heading of its column.
    of_rows = part.columns.index("unit") if "unit" in part.columns else None
    headings = [IN_HEADING.search(column) for column in part.columns]
    rows = []
    for row in part.rows:
        own = None if of_rows is None else UNIT.fullmatch(str(row[of_rows]))
        cells = []
        for place, cell in enumerate(row):
            is_count = isinstance(cell, str) and cell.isdigit()  # as of jumps
            unit = headings[place] or (None if is_count else own)
            cells.append(_convert_cell(cell, place, unit, part.columns[place]))
        if own is not None and of_rows is not None:
            cells[of_rows] = _unit(own)
        rows.append(cells)
    named = [
        IN_HEADING.sub(_unit(found), column) if found else column
        for column, found in zip(part.columns, headings, strict=True)
    ]
    return Table(part.title, named, rows)


def _convert_cell(cell: Cell, place: int, unit: re.Match[str] | None, column: str) -> Cell:
    """A cell whose unit is known; labels and angles stay."""
    if unit is None or place == 0 or "°" in column or cell is None:
        return cell
    if isinstance(cell, float):
        return cell / _factor(unit)
    if NUMBERS.fullmatch(cell) is None:
        return cell
    return _scale_numbers(cell, unit)


def _factor(unit: re.Match[str]) -> float:
    return MM_PER_INCH ** {None: 1, "²": 2, "³": 3, "⁴": 4}[unit["power"]]


def _unit(unit: re.Match[str]) -> str:
    return f"in{unit['power'] or ''}{unit['rate'] or ''}"


def _scale_numbers(text: str, unit: re.Match[str]) -> str:
    """A text with each of its numbers in inches."""
    return NUMBER.sub(lambda found: _digits(found[0], _factor(unit)), text)


def _digits(number: str, factor: float) -> str:
    """A number over a factor, with as many significant digits as it was written with."""
    written = number.partition("e")[0].replace(".", "").lstrip("-0")
    return f"{float(number) / factor:.{max(len(written), LEAST_DIGITS)}g}"
