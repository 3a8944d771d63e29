"""The page docs/benchmarks, its diagrams, and the table of docs/overview.md that quotes it."""

from __future__ import annotations

import os
import platform
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

from benchmarks.section import Section, Table

PACKAGES = ("numpy", "scipy", "clarabel", "highspy", "casadi", "cvxpy-base")
BEGIN, END = "<!-- figures: written by make bench -->", "<!-- figures end -->"
HEAD = """# Speed and accuracy

Written by `make bench`, all in one run; `python -m benchmarks NAME` repeats one part. Measured on
{machine}.
{load}

Times are medians, with the quartiles behind them in brackets, or as bars in the diagrams. What is
compared took turns in one loop, so compare ratios rather than times, and read each time together
with the error or gap in its row. Errors are against closed forms, calculations in forty digits or a
reference computed by another method; where a figure is a *proven gap* it says so."""


def machine() -> str:
    """Cores, system, versions; nothing that tells one machine of the kind from another."""
    cores = os.cpu_count() or 1
    packages = ", ".join(f"{name} {version(name)}" for name in PACKAGES)
    kind = f"{platform.system()} on {platform.machine()}"
    return (
        f"{cores} core{'s' if cores > 1 else ''}, {kind}, {platform.python_implementation()} "
        f"{platform.python_version()}, {packages}"
    )


def load() -> str:
    """Whether other programs ran too; the benchmarks keep one core busy."""
    if not hasattr(os, "getloadavg"):
        return "Other programs may have been running."
    return f"In the last five minutes {os.getloadavg()[1]:.1f} programs at a time wanted a core."


def front(sections: Sequence[Section]) -> str:
    """The table in short: a few rows of the sections."""
    rows = [row for section in sections for row in section.front]
    return Table(("", ">time", "error or gap"), rows).markdown()


def markdown(sections: Sequence[Section]) -> str:
    """The whole page."""
    parts = [HEAD.format(machine=machine(), load=load()), "## In short", front(sections)]
    return "\n\n".join([*parts, *(section.markdown() for section in sections)]) + "\n"


def write(sections: Sequence[Section], folder: Path, readme: Path) -> None:
    """Write page and diagrams into a folder, and the table in short into a README.

    Drawings in the folder that the page no longer shows are removed.

    Raises:
        ValueError: the README has no place for the table.
    """
    quoted = _quoting(readme.read_text(encoding="utf-8"), front(sections))
    files = {name: data for section in sections for name, data in section.files().items()}
    folder.mkdir(parents=True, exist_ok=True)
    for old in set(folder.glob("*.svg")) - {folder / name for name in files}:
        old.unlink()
    for name, data in files.items():
        (folder / name).write_bytes(data)
    (folder / "README.md").write_text(markdown(sections), encoding="utf-8")
    readme.write_text(quoted, encoding="utf-8")


def quoted(readme: str) -> str:
    """The table that a README quotes.

    Raises:
        ValueError: it quotes none.
    """
    _, begin, rest = readme.partition(BEGIN)
    table, end, _ = rest.partition(END)
    if not begin or not end:
        raise ValueError(f"The README has no lines {BEGIN} and {END}; put them where its table is.")
    return table.strip()


def _quoting(readme: str, table: str) -> str:
    """The README with this table in place of the one it quotes."""
    old = quoted(readme)
    at = readme.index(old, readme.index(BEGIN)) if old else readme.index(END)
    rest = readme[at + len(old) :].lstrip("\n")
    return f"{readme[:at]}{table}\n{rest}"
