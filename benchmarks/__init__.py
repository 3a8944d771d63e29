"""Measurements of speed and of error. Each benchmark is a module with ``run(effort) -> Section``.

``python -m benchmarks`` runs them all, ``python -m benchmarks name …`` some of them,
``python -m benchmarks --list`` says which there are, and ``--write`` writes the page
docs/benchmarks with its diagrams and the table in docs/overview.md that quotes it.
"""

from benchmarks.timing import Timing, timed

__all__ = ["Timing", "timed"]
