"""How near to each other a value that suffices and one that is proven impossible come."""

from __future__ import annotations

import pytest

from synthesis import synthesise
from synthesis.catalogue.fields import Range
from synthesis.design.design import Conflict
from synthesis.pipeline import conflict
from synthesis.pipeline.relaxable import Relaxable, relaxable_numbers
from synthesis.spec.design_spec import DesignSpec
from tests.optimise.scenes import PLAIN, angles, jerk, scene

NEAR = 2e-3  # of the way from the request


@pytest.fixture(autouse=True)
def changes_of_the_program_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """They have tests of their own, and take as many questions again."""
    monkeypatch.setattr(conflict, "program_numbers", lambda *_: ())


def why(spec: DesignSpec) -> Conflict:
    found = synthesise(spec).conflict
    assert found is not None
    return found


def test_the_least_cap_on_jerk_is_that_of_the_closed_form() -> None:
    """32 h/β³, made the objective, which bounds it as well."""
    (found,) = why(scene(PLAIN, jerk(31.0, 71.7), base={"min": 4.3})).relaxations
    least = 32.0 / 31.0 * found.requested
    assert found.needed is not None
    assert found.at_least is not None
    assert found.at_least <= least <= found.needed
    assert found.needed - found.at_least < 2e-4 * least


def test_both_ends_come_near_where_the_smallest_cam_is_too_large() -> None:
    spec = scene(PLAIN, angles(20.0, 30.0), jerk(47.0, 71.7), base={"max": 30.0})
    relaxations = why(spec).relaxations
    assert len(relaxations) == 3
    for each in relaxations:
        assert each.needed is not None
        assert each.at_least is not None
        assert 0.0 <= (each.needed - each.at_least) / (each.needed - each.requested) < NEAR


def dimensions(spec: DesignSpec) -> list[Relaxable]:
    """Its dimensions alone: each limit would take as many questions again."""
    return [number for number in relaxable_numbers(spec) if number.dimension]


def test_the_spec_says_how_near(monkeypatch: pytest.MonkeyPatch) -> None:
    """``proof`` buys accuracy: a finer tolerance brings both ends nearer."""
    monkeypatch.setattr(conflict, "relaxable_numbers", dimensions)
    spec = scene(PLAIN, angles(31.0, 43.0), jerk(47.0, 71.7), base={"max": 1e3})
    radius = synthesise(spec).dimensions["base_radius_mm"]
    apart = list[float]()
    for proof in ("quick", "thorough"):
        changes = {"base_radius_mm": Range(max=0.998 * radius), "proof": proof}
        found = why(spec.model_copy(update=changes)).relaxations[-1]
        assert found.field == "base_radius_mm/max"
        assert found.needed is not None
        assert found.at_least is not None
        apart.append((found.needed - found.at_least) / (found.needed - found.requested))
    assert apart[1] < 0.8 * apart[0]
    assert apart[1] < 5e-3
