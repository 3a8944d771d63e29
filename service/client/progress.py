"""How far a sweep is, shown where its client runs: in a notebook, or in a line of a terminal."""

from __future__ import annotations

import html
import sys
from collections.abc import Callable, Mapping
from typing import Any

STATES = ("optimal", "feasible", "unsolved", "infeasible", "failed")
Show = Callable[[Mapping[str, Any]], None]


def shown() -> Show:
    """What shows a sweep's summary each time that it is called with one.

    A notebook has one display that is changed, a terminal one line; elsewhere nothing is shown.
    """
    if _in_notebook():
        from IPython.display import HTML, display

        first = display(HTML(""), display_id=True)
        return lambda summary: first.update(HTML(as_html(summary)))
    if sys.stderr.isatty():
        return _in_terminal
    return lambda _: None


def _in_notebook() -> bool:
    """Whether a kernel runs this: IPython in a terminal has none."""
    ipython = sys.modules.get("IPython")
    shell = None if ipython is None else ipython.get_ipython()
    return hasattr(shell, "kernel")


def _in_terminal(summary: Mapping[str, Any]) -> None:
    over = summary["state"] not in ("accepted", "running")
    # from the beginning of the line, and what is left of the text before is erased
    sys.stderr.write(f"\r{as_text(summary)}\x1b[K" + "\n" * over)
    sys.stderr.flush()


def as_text(summary: Mapping[str, Any]) -> str:
    """State, items and the time that is left, in a line."""
    counts, left = summary["counts"], summary["time_left_s"]
    results = [f"{counts[name]} {name}" for name in STATES if counts[name]]
    remaining = [] if left is None else [f"{left:.0f} s left"]
    done = f"{summary['state']}: {counts['done']} of {counts['items']} items"
    return ", ".join([done, *results, *remaining])


def as_html(summary: Mapping[str, Any]) -> str:
    """The same with its name and a bar."""
    name = html.escape(summary["name"] or "Sweep")
    bar = f'<progress max="100" value="{summary["progress"]:.6g}"></progress>'
    return f"<div><b>{name}</b> {bar} {html.escape(as_text(summary))}</div>"
