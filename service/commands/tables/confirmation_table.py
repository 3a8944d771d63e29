"""A confirmation as a terminal shows it."""

from __future__ import annotations

from typing import Final

from rich import box
from rich.table import Table

from synthesis.certify.second import Confirmation

WIDTH: Final = 120
WORDS: Final = {True: "yes", False: "NO", None: "–"}
VERDICTS: Final = {
    "confirmed": "every line of the certificate agrees",
    "contradicted": "the certificate is wrong in what is marked NO",
    "incomplete": "what could be measured agrees; lines marked – could not be",
}


def headline(found: Confirmation) -> str:
    """The verdict in one line."""
    return f"{found.verdict}: {VERDICTS[found.verdict]} ({found.bits} bits)"


def table(found: Confirmation) -> Table:
    """Line by line: value to 25 digits, how far the certificate is from it, whether it agrees."""
    shown = Table(box=box.SIMPLE)
    for name in ("limit", "value", "unit", "certificate less value", "holds", "agrees"):
        right = name in ("value", "certificate less value")
        shown.add_column(name, justify="right" if right else "left", no_wrap=True)
    for line in found.lines:
        apart = "–" if line.difference is None else f"{-line.difference:.1e}"
        shown.add_row(
            line.limit, line.value or "–", line.unit, apart, WORDS[line.holds], WORDS[line.agrees]
        )
    return shown
