"""A spec keeps what follows from its program; a changed copy of it keeps nothing of that."""

from __future__ import annotations

from functools import cached_property

from synthesis import DesignSpec, synthesise
from synthesis.catalogue.fields import Range
from synthesis.spec.design_spec import DERIVED
from tests.hard.cases import ANGLES, jerk, scene


def test_all_that_a_spec_keeps_is_named() -> None:
    kept = {name for name, value in vars(DesignSpec).items() if isinstance(value, cached_property)}
    assert kept == set(DERIVED)


def test_a_changed_copy_is_laid_out_anew() -> None:
    spec = DesignSpec.model_validate(scene(ANGLES, jerk(48.0)))
    levels = [segment.s_end for segment in spec.placed_segments()]
    assert spec.placed_segments() is spec.placed_segments()
    assert spec.with_values([]) is spec
    program = [
        segment.model_copy(update={"lift_mm": 1.7 * segment.lift_mm})
        if segment.kind in ("rise", "return")
        else segment
        for segment in spec.program
    ]
    larger = spec.model_copy(update={"program": program})
    assert [segment.s_end for segment in larger.placed_segments()] == [
        1.7 * level for level in levels
    ]
    assert larger.stroke() == 1.7 * spec.stroke()
    assert larger == DesignSpec.model_validate(larger.model_dump())
    assert spec == DesignSpec.model_validate(spec.model_dump())
    raised = spec.model_copy(update={"base_radius_mm": Range(min=3.0 * levels[0])})
    assert synthesise(raised).id == synthesise(DesignSpec.model_validate(raised.model_dump())).id
