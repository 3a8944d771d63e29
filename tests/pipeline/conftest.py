"""What tests of the pipeline share."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from synthesis.optimise.parameters import search


@pytest.fixture(scope="module")
def coarse_search(request: pytest.FixtureRequest) -> Iterator[None]:
    """Searches over free numbers with the constants that the test's module names in ``SEARCH``."""
    with pytest.MonkeyPatch.context() as patch:
        for name, value in request.module.SEARCH.items():
            patch.setattr(search, name, value)
        yield
