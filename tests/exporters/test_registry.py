"""What holds for every format: names, determinism, and what cannot be written."""

from __future__ import annotations

import pytest

from synthesis.design.design import Design
from synthesis.errors import InputError
from synthesis.exporters import (
    MOTION_FORMATS,
    PICTURES,
    PROFILE_FORMATS,
    MotionOptions,
    PictureOptions,
    ProfileOptions,
)
from synthesis.exporters.options import CurveOptions
from tests.exporters.written import coarse

ALL = [*PROFILE_FORMATS.values(), *MOTION_FORMATS.values(), *PICTURES.values()]
FILES = [(exporter, coarse(exporter)) for exporter in ALL]
NAMED = pytest.mark.parametrize(
    ("exporter", "options"), FILES, ids=lambda v: getattr(v, "extension", type(v).__name__)
)


def test_names_are_keys_and_endings() -> None:
    for formats in (PROFILE_FORMATS, MOTION_FORMATS):
        for name, exporter in formats.items():
            assert exporter.name == name
            assert exporter.extension == f".{name}"
            assert exporter.title
            assert "/" in exporter.media_type
    for name, exporter in PICTURES.items():
        assert exporter.name == name
        assert name.endswith(exporter.extension)


@NAMED
def test_same_design_same_bytes(exporter, options, unspecial: Design) -> None:
    first = exporter.write(unspecial, options)
    again = exporter.write(Design.model_validate_json(unspecial.model_dump_json()), options)
    assert first == again
    assert len(first) > 1000


@NAMED
def test_an_infeasible_design_has_nothing_to_write(exporter, options, build) -> None:
    if exporter.without_cam:
        assert b"infeasible" in exporter.write(build(status="infeasible"), options)
        return
    with pytest.raises(InputError, match=r"infeasible.*conflict"):
        exporter.write(build(status="infeasible"), options)


@NAMED
def test_a_cam_that_breaks_its_limits_can_be_looked_at(exporter, options, p1: Design) -> None:
    broken = p1.model_copy(update={"status": "infeasible"})
    assert len(exporter.write(broken, options)) > 1000


@pytest.mark.parametrize("density", [0.0, -4.0, float("nan"), float("inf"), 100.5])
@pytest.mark.parametrize("options", [ProfileOptions, MotionOptions])
def test_densities_that_make_no_sense(options, density: float) -> None:
    with pytest.raises(InputError) as caught:
        options(points_per_degree=density)
    error = caught.value
    assert error.field == "/points_per_degree"
    assert error.value is density
    assert "above 0 and at most 100." in error.rule
    assert error.remedy


@pytest.mark.parametrize("tolerance", [0.0, -1.0, float("nan"), float("inf")])
def test_tolerances_that_make_no_sense(tolerance: float) -> None:
    with pytest.raises(InputError) as caught:
        ProfileOptions(tolerance_um=tolerance)
    assert caught.value.field == "/tolerance_um"
    assert caught.value.remedy


def test_an_unknown_theme() -> None:
    with pytest.raises(InputError, match=r"'pink'.*auto, light, dark, print"):
        PictureOptions(theme="pink")  # type: ignore[arg-type]


def test_numbers_of_points_that_make_no_sense() -> None:
    for wrong in (0, -5, 35, 36_001, 10**9):
        with pytest.raises(InputError, match="a whole number, at least 36 and at most 36000"):
            ProfileOptions(points=wrong)


def test_an_unknown_curve() -> None:
    with pytest.raises(InputError, match=r"shadow.*profile, pitch"):
        ProfileOptions(curve="shadow")  # type: ignore[arg-type]


def test_a_cutter_and_its_diameter_go_together() -> None:
    for wrong in ({"curve": "cutter"}, {"cutter_diameter_mm": 12.5}):
        with pytest.raises(InputError, match="both curve=cutter and cutter_diameter_mm"):
            ProfileOptions(**wrong)


SAMPLED = [name for name, each in PROFILE_FORMATS.items() if issubclass(each.options, CurveOptions)]


@pytest.mark.parametrize("name", SAMPLED)
def test_a_tolerance_beyond_all_points(name: str, p1: Design) -> None:
    exporter = PROFILE_FORMATS[name]
    with pytest.raises(InputError, match=r"36000 points|no straight line|Rounding alone"):
        exporter.write(p1, exporter.options_like(ProfileOptions(tolerance_um=1e-4)))
