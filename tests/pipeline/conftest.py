"""What all tests of the pipeline share."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import inf

import pytest

from synthesis.pipeline import conflict
from synthesis.pipeline.relaxable import relaxable_numbers


@pytest.fixture(scope="module")
def diagnosis_without_a_clock() -> Iterator[None]:
    """Conflicts are found to their end, however busy the machine is.

    Values that suffice end within one part in a hundred of the way: four trials fewer for each.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(conflict, "DIAGNOSIS_S", inf)
        patch.setattr(conflict, "ACCURACY", 1e-2)
        yield


@pytest.fixture
def explain_only(
    diagnosis_without_a_clock: None, monkeypatch: pytest.MonkeyPatch
) -> Callable[[str], None]:
    """Sets the field that conflicts are explained by: each number takes a search of its own."""

    def only(field: str) -> None:
        monkeypatch.setattr(
            conflict, "relaxable_numbers",
            lambda spec: [n for n in relaxable_numbers(spec) if field in n.paths],
        )  # fmt: skip

    return only


@pytest.fixture
def unexplained(explain_only: Callable[[str], None]) -> None:
    """Of a spec without a cam that is told alone, with its proof, and none of its numbers tried."""
    explain_only("")
