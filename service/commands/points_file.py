"""Measured points in a text file: csv or columns, with or without a header."""

from __future__ import annotations

import re
from pathlib import Path

from synthesis.errors import InputError

SEPARATORS = re.compile(r"[,;\s]+")
COLUMNS = (("x_mm", "x"), ("y_mm", "y"))  # what a header may call them


def points_in(path: Path) -> list[list[float]]:
    """x and y of every row [mm]; further columns are left alone.

    A header names the columns; without one they are the first two. Rows may be separated by
    commas, semicolons or blanks; empty lines and what follows a # do not count.

    Raises:
        InputError: a row that is no row of numbers, with its line. OSError: no such file.
    """
    places = (0, 1)
    found: list[list[float]] = []
    for number, line in enumerate(path.read_text(encoding="utf-8-sig").splitlines(), start=1):
        cells = [cell for cell in SEPARATORS.split(line.partition("#")[0].strip()) if cell]
        if not cells:
            continue
        try:
            found.append([float(cells[place]) for place in places])
        except (ValueError, IndexError):
            if found:
                raise InputError(
                    f"{path.name}, line {number}", line[:80], "This is no row of numbers.",
                    "Give x and y in mm in every row, with decimal points.",
                ) from None  # fmt: skip
            places = _places([cell.strip('"').lower() for cell in cells])
    return found


def _places(header: list[str]) -> tuple[int, int]:
    """Where x and y stand; the first two columns where the header says nothing of them."""
    named = [next((header.index(n) for n in names if n in header), None) for names in COLUMNS]
    x, y = named
    return (0, 1) if x is None or y is None else (x, y)
