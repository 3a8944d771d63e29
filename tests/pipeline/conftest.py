"""What all tests of the pipeline share."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf

import pytest

from synthesis.pipeline import conflict


@pytest.fixture(scope="module")
def diagnosis_without_a_clock() -> Iterator[None]:
    """Conflicts are found to their end, however busy the machine is."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(conflict, "DIAGNOSIS_S", inf)
        yield
