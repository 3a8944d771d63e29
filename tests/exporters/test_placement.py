"""A cam's place on a shaft: points turned about the axis and shifted along it."""

from __future__ import annotations

import io
import json
import math

import numpy as np
import pytest

from synthesis.design.design import Design
from synthesis.errors import InputError
from synthesis.exporters import PROFILE_FORMATS, PointOptions, ProfileOptions
from synthesis.exporters.tables import JsonOptions

TURN, Z = -63.7, 12.125


def loaded(design: Design, options: ProfileOptions) -> np.ndarray:
    return np.loadtxt(
        io.BytesIO(
            PROFILE_FORMATS["txt"].write(design, PROFILE_FORMATS["txt"].options_like(options))
        )
    )


def table(design: Design, options: ProfileOptions) -> np.ndarray:
    data = PROFILE_FORMATS["csv"].write(design, options).decode()
    return np.genfromtxt(io.StringIO(data), delimiter=",", names=True)


@pytest.mark.parametrize("sampling", [{}, {"tolerance_um": 2.0}, {"curve": "pitch"}], ids=str)
def test_points_are_turned_by_the_angle(cam: Design, sampling: dict) -> None:
    """Polar coordinates, not the rotation matrix that the file is made with."""
    plain = loaded(cam, ProfileOptions(**sampling))
    turned = loaded(cam, ProfileOptions(**sampling, turn_deg=TURN, z_mm=Z))
    assert plain.shape == turned.shape
    np.testing.assert_allclose(
        np.hypot(*turned[:, :2].T), np.hypot(*plain[:, :2].T), rtol=0.0, atol=2e-10
    )
    by = np.arctan2(turned[:, 1], turned[:, 0]) - np.arctan2(plain[:, 1], plain[:, 0])
    off = (by - math.radians(TURN) + math.pi) % (2.0 * math.pi) - math.pi
    np.testing.assert_allclose(off, 0.0, rtol=0.0, atol=1e-11)
    assert np.all(plain[:, 2] == 0.0)
    assert np.all(turned[:, 2] == Z)


def test_tables_and_point_files_agree(cam: Design) -> None:
    options = ProfileOptions(3.0, turn_deg=TURN, z_mm=Z)
    rows = table(cam, options)
    points = np.column_stack([rows["x_mm"], rows["y_mm"], rows["z_mm"]])
    for point in loaded(cam, ProfileOptions(1.0, turn_deg=TURN, z_mm=Z))[::17]:
        assert np.min(np.max(np.abs(points - point), axis=1)) < 3e-10
    tables = PROFILE_FORMATS["json"]
    columns = {
        column["name"]: column
        for column in json.loads(tables.write(cam, tables.options_like(options)))["columns"]
    }
    assert columns["x_mm"]["values"] == rows["x_mm"].tolist()
    assert columns["z_mm"]["values"] == rows["z_mm"].tolist()
    assert "turned by -63.7°" in columns["x_mm"]["meaning"]


def test_what_belongs_to_the_cam_is_not_turned(cam: Design) -> None:
    plain, turned = table(cam, ProfileOptions()), table(cam, ProfileOptions(turn_deg=TURN))
    for name in plain.dtype.names:
        same = np.array_equal(plain[name], turned[name], equal_nan=True)
        assert same == (name not in ("x_mm", "y_mm")), name


def test_without_a_place_nothing_changes(cam: Design) -> None:
    assert "z_mm" not in table(cam, ProfileOptions()).dtype.names
    frame = json.loads(PROFILE_FORMATS["json"].write(cam, JsonOptions()))["frame"]
    turned = json.loads(PROFILE_FORMATS["json"].write(cam, JsonOptions(turn_deg=TURN)))["frame"]
    assert "turned" not in frame
    assert turned == f"{frame} The points are turned from there by -63.7° about z, " + (
        "counter-clockwise positive."
    )


@pytest.mark.parametrize("quarter", [90.0, 180.0, -90.0, 270.0])
def test_quarters_of_a_turn_are_exact(cam: Design, quarter: float) -> None:
    plain, turned = table(cam, ProfileOptions()), table(cam, ProfileOptions(turn_deg=quarter))
    x, y = plain["x_mm"], plain["y_mm"]
    right = {90.0: (-y, x), 180.0: (-x, -y), -90.0: (y, -x), 270.0: (y, -x)}[quarter]
    np.testing.assert_array_equal(turned["x_mm"], right[0])
    np.testing.assert_array_equal(turned["y_mm"], right[1])


def test_negative_zero_is_not_written(cam: Design) -> None:
    data = PROFILE_FORMATS["txt"].write(cam, PointOptions(z_mm=-1e-12))
    assert b" -0.0000000000" not in data


@pytest.mark.parametrize("field", ["turn_deg", "z_mm"])
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_places_that_make_no_sense(field: str, value: float) -> None:
    with pytest.raises(InputError) as caught:
        ProfileOptions(**{field: value})
    assert caught.value.field == f"/{field}"
