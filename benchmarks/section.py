"""What a benchmark hands over: a section of the page, made of tables and diagrams."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol


class Part(Protocol):
    """A table or a diagram."""

    def markdown(self) -> str:
        """As the page shows it."""
        ...

    def files(self) -> Mapping[str, bytes]:
        """Files that the page links to, by name."""
        ...


@dataclass(frozen=True)
class Table:
    """Columns of texts.

    Attributes:
        head: names of the columns; those that begin with ``>`` stand to the right.
        rows: as many cells each. note: what one must know to read it.
    """

    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""

    def __post_init__(self) -> None:
        wrong = [row for row in self.rows if len(row) != len(self.head)]
        if wrong:
            raise ValueError(f"{len(self.head)} columns, but a row of {len(wrong[0])}: {wrong[0]}")

    def markdown(self) -> str:
        names = [name.removeprefix(">") for name in self.head]
        marks = ["--:" if name.startswith(">") else "---" for name in self.head]
        lines = [_line(names), f"|{'|'.join(marks)}|", *map(_line, self.rows)]
        return "\n".join([*([self.note, ""] if self.note else []), *lines])

    def files(self) -> Mapping[str, bytes]:
        return {}


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


@dataclass(frozen=True)
class Section:
    """One benchmark's part of the page.

    Attributes:
        title: its heading. text: what was measured, and how its errors are known.
        parts: tables and diagrams. front: rows for the short table of
            docs/overview.md: what
            was asked, its time, its error or gap.
    """

    title: str
    text: str
    parts: Sequence[Part]
    front: Sequence[tuple[str, str, str]] = field(default=())

    def markdown(self) -> str:
        """With its heading."""
        shown = [f"## {self.title}", self.text, *(part.markdown() for part in self.parts)]
        return "\n\n".join(text for text in shown if text)

    def files(self) -> dict[str, bytes]:
        """All files of its parts."""
        return {name: data for part in self.parts for name, data in part.files().items()}
