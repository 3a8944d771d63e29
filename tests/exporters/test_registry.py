"""What holds for every format: names, determinism, and what cannot be written."""

from __future__ import annotations

import pytest

from synthesis.design import Design
from synthesis.errors import InputError
from synthesis.exporters import (
    MOTION_FORMATS,
    PICTURES,
    PROFILE_FORMATS,
    MotionOptions,
    PictureOptions,
    ProfileOptions,
)

FILES = [(exporter, ProfileOptions()) for exporter in PROFILE_FORMATS.values()]
FILES += [(exporter, MotionOptions()) for exporter in MOTION_FORMATS.values()]
FILES += [(exporter, PictureOptions()) for exporter in PICTURES.values()]
NAMED = pytest.mark.parametrize(
    ("exporter", "options"), FILES, ids=lambda v: getattr(v, "name", type(v).__name__)
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


@pytest.mark.parametrize("density", [0.0, -4.0, float("nan"), float("inf"), 1000.5])
@pytest.mark.parametrize("options", [ProfileOptions, MotionOptions])
def test_densities_that_make_no_sense(options, density: float) -> None:
    with pytest.raises(InputError) as caught:
        options(points_per_degree=density)
    error = caught.value
    assert error.field == "/points_per_degree"
    assert error.value is density
    assert "1000" in error.rule
    assert error.way_out


@pytest.mark.parametrize("options", [ProfileOptions, MotionOptions, PictureOptions])
def test_an_unknown_theme(options) -> None:
    with pytest.raises(InputError, match=r"'pink'.*auto, light, dark, print"):
        options(theme="pink")


@pytest.mark.parametrize("tolerance", [0.0, -1.0, float("nan"), float("inf")])
def test_tolerances_that_make_no_sense(tolerance: float) -> None:
    with pytest.raises(InputError) as caught:
        ProfileOptions(tolerance_um=tolerance)
    assert caught.value.field == "/tolerance_um"
    assert caught.value.way_out


def test_an_unknown_curve() -> None:
    with pytest.raises(InputError, match=r"cutter.*profile, pitch"):
        ProfileOptions(curve="cutter")  # type: ignore[arg-type]


@pytest.mark.parametrize("name", list(PROFILE_FORMATS))
def test_a_tolerance_beyond_all_points(name: str, p1: Design) -> None:
    with pytest.raises(InputError, match="360000 points"):
        PROFILE_FORMATS[name].write(p1, ProfileOptions(tolerance_um=1e-9))
