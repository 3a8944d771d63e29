"""What tests of analyses share."""

import pytest


@pytest.fixture
def unmended(monkeypatch: pytest.MonkeyPatch) -> None:
    """Analyses do not search for what mends a cam: that takes a design for each size."""
    monkeypatch.setattr("synthesis.studies.analyse.find_remedy", lambda *_: None)
