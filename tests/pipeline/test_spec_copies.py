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


def test_a_copy_keeps_what_does_not_follow_from_the_changed_fields() -> None:
    """Every field changed: what the copy has is what a spec made anew computes."""
    body = scene(ANGLES, jerk(48.0))
    changes = {
        "speed_rpm": 71.0, "base_radius_mm": {"min": 31.0}, "continuity": 3, "tolerance": 0.03,
        "rotation": "cw", "limits": [ANGLES], "name": "another", "proof": "thorough",
        "objective": {"kind": "peak_jerk"}, "time_budget_s": 7.0,
        "follower": {**body["follower"], "roller_radius_mm": 7.3},
        "load": {
            "kind": "slide", "moving_mass_kg": 1.3,
            "spring": {"rate_n_per_mm": 9.0, "preload_n": 700.0},
        },
        "program": [body["program"][0], *reversed(body["program"][1:])],
    }  # fmt: skip
    for field, value in changes.items():
        spec = DesignSpec.model_validate(body)
        expected = DesignSpec.model_validate({**body, field: value})
        for name in DERIVED:
            getattr(spec, name)  # computed before the copy is made
        copy = spec.model_copy(update={field: getattr(expected, field)})
        for name in DERIVED:
            assert repr(getattr(copy, name)) == repr(getattr(expected, name)), (field, name)
