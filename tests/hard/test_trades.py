"""A cam of each of twenty trades: nothing severe is said but what was judged to be right."""

import pytest

from synthesis import DesignSpec, synthesise
from tests.hard.trades import EACH, JUDGED, TRADES, scenes

NUMBER = 3  # of each trade: among them harmonics between dwells, a pointed tappet, 42.8° of an arm


@pytest.mark.parametrize("name", [f"{trade.__name__} {NUMBER}" for trade in TRADES])
def test_no_wrong_caution(name: str) -> None:
    design = synthesise(DesignSpec.model_validate(dict(scenes())[name]))
    severe = {one.code for one in design.warnings if one.severity != "note"}
    assert severe <= JUDGED.get(name.split()[0], set()), design.warnings


def test_all_scenes_differ() -> None:
    bodies = [str(spec) for _, spec in scenes()]
    assert len(set(bodies)) == EACH * len(TRADES) == 300
