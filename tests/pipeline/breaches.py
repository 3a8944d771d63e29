"""Which limits a given cam breaks, by the judge of analyses alone.

An analysis also looks for what would mend the cam, which takes seconds where curvature or an arm's
pressure angle binds; tests of that are in tests/analysis.
"""

from __future__ import annotations

from synthesis.analysis import given
from synthesis.answer import judged
from synthesis.spec import DesignSpec


def broken(spec: DesignSpec) -> list[str]:
    """Their names, as an analysis lists them."""
    return [extreme.limit for extreme in judged(spec, given(spec)) if not extreme.holds]
