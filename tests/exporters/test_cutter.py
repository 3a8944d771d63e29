"""The path of a cutter's centre: at its radius from the flank, and never into the cam."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from synthesis import Design, DesignSpec, synthesise
from synthesis.errors import InputError
from synthesis.exporters import PROFILE_FORMATS, ProfileOptions
from synthesis.exporters.samples.cutting import checked_cam, largest_cutter
from tests.exporters.test_flanks import CLOSURES, question
from tests.exporters.test_points import away, points


@pytest.fixture(scope="module")
def designs() -> dict[str, Design]:
    found = {name: synthesise(question(closure, "cw")) for name, closure in CLOSURES.items()}
    flat = question(CLOSURES["ring"], "ccw").model_dump(mode="json", exclude_none=True)
    flat["follower"] = {"kind": "translating_flat_face"}
    flat["limits"] = []
    return {**found, "flat": synthesise(DesignSpec.model_validate(flat))}


@pytest.mark.parametrize(
    ("name", "flank", "path", "diameter", "outside"),
    [
        ("ring", "profile", "cutter", 25.3, False),
        ("groove", "inner", "cutter", 11.1, True),
        ("groove", "outer", "outer_cutter", 14.5, False),  # as wide as the groove
        ("pair", "main", "cutter", 62.7, True),
        ("pair", "counter", "counter_cutter", 9.7, True),
        ("flat", "profile", "cutter", 311.0, True),
    ],
)
def test_the_centre_stays_at_its_radius(
    designs, name: str, flank: str, path: str, diameter: float, outside: bool
) -> None:
    fine = {"points_per_degree": 8.0}
    cam = points(designs[name], curve=flank, **fine)
    centres = points(designs[name], curve=path, cutter_diameter_mm=diameter, points=397)
    np.testing.assert_allclose(away(centres, cam), 0.5 * diameter, rtol=0, atol=2e-3)
    assert (np.min(np.hypot(*centres.T)) > np.min(np.hypot(*cam.T))) == outside


def test_the_largest_cutter_of_a_hollow_is_its_radius(build) -> None:
    """Radii of hollows from the circles through three neighbours of a fine ring."""
    design = build(limits=[], prime=43.7)
    ring = points(design, points_per_degree=10.0)
    a, b, c = ring, np.roll(ring, -1, axis=0), np.roll(ring, -2, axis=0)
    (ux, uy), (vx, vy) = (b - a).T, (c - b).T
    lengths = [np.hypot(*(p - q).T) for p, q in ((a, b), (b, c), (a, c))]
    bend = -2.0 * (ux * vy - uy * vx) / np.prod(lengths, axis=0)  # the ring runs clockwise
    largest = -2.0 / np.min(bend)
    fit = largest_cutter(checked_cam(design, ProfileOptions()))
    assert 2.0 * fit.radius == pytest.approx(largest, rel=2e-3)
    at = ring[int(np.argmin(bend))]
    assert np.hypot(at[0] - fit.x, at[1] - fit.y) < 0.5
    reported = {"curve": "cutter", "points": 40}
    points(design, cutter_diameter_mm=0.999 * largest, **reported)
    with pytest.raises(InputError, match=rf"cam angle {fit.angle_deg:.6g}°.*{2 * fit.radius:.6g}"):
        points(design, cutter_diameter_mm=1.005 * largest, **reported)


def test_a_groove_is_as_wide_as_it_is(designs) -> None:
    for options in ({"curve": "cutter"}, {"curve": "outer_cutter"}):
        with pytest.raises(InputError, match=r"no cutter larger than 14\.5 mm") as caught:
            points(designs["groove"], cutter_diameter_mm=14.6, **options)
        assert caught.value.field == "/cutter_diameter_mm"


def test_tables_hold_the_path_too(designs) -> None:
    options: dict[str, Any] = {"curve": "cutter", "cutter_diameter_mm": 25.3}
    for name in ("csv", "json"):
        exporter = PROFILE_FORMATS[name]
        data = exporter.write(designs["ring"], exporter.options(**options))
        assert data != exporter.write(designs["ring"], exporter.options())
    assert b"path of the centre of a cutter of 25.3 mm diameter" in data
