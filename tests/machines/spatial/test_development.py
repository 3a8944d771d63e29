"""The unrolled walls: on the cylinder, on the walls, and beside the offset that is drawn flat."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial import KDTree

from synthesis.machines.spatial.files.developed import offset_errors, wall_curve
from tests.machines.spatial.drums import OUTER, RADIUS, SAMPLES, Array, least_gap

DEEP = 50.9
SLIDES_AND_ARMS = [name for name in SAMPLES if name != "turret"]


@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize("radius", [OUTER - 0.7, DEEP])
@pytest.mark.parametrize("name", SLIDES_AND_ARMS)
def test_its_curves_are_touched_by_rollers_and_not_cut(
    name: str, radius: float, rotation: str
) -> None:
    sample, turns = SAMPLES[name], 1 if rotation == "ccw" else -1
    cam = sample.cam(rotation=rotation)
    for each in cam.walls:
        line = wall_curve(cam, each.seat, each.side, np.linspace(0.1, 6.2, 43), radius)
        angle = -turns * line.phi
        points = np.stack([radius * np.cos(angle), radius * np.sin(angle), line.z])
        gap = least_gap(sample, points, turns, 0.0)
        assert gap.min() > -1e-9
        assert gap.max() < 2e-3  # between two of the angles tried


@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize("name", ["slide astride a rib", "arm astride a rib"])
def test_paths_are_where_the_rollers_axes_are(name: str, rotation: str) -> None:
    sample, turns = SAMPLES[name], 1 if rotation == "ccw" else -1
    cam, theta = sample.cam(rotation=rotation), np.linspace(0.1, 6.2, 43)
    # the first roller is the one ahead
    for each, (y, z) in zip(cam.walls, reversed(sample.ways(theta)), strict=True):
        line = wall_curve(cam, each.seat, 0, theta, DEEP)
        there = DEEP * np.exp(1j * turns * (theta - line.phi))
        assert there.imag == pytest.approx(y, abs=1e-9)
        assert there.real == pytest.approx(line.rho, abs=1e-9)
        assert line.z == pytest.approx(z, abs=1e-9)


@pytest.mark.parametrize("drawn", [OUTER, DEEP])
@pytest.mark.parametrize("name", ["slide in a groove", "arm in a groove"])
def test_departures_are_distances_from_the_curve_drawn(name: str, drawn: float) -> None:
    """By brute force: a cloud of points 3 mm inside the drawn curve."""
    cam = SAMPLES[name].cam()
    t = np.linspace(-0.3, 6.5, 100_001)
    for each in cam.walls:
        axis = wall_curve(cam, each.seat, 0, t, drawn).plane(drawn)
        curve = axis + each.side * RADIUS * normals(axis, t)
        curve[0] *= DEEP / drawn
        cloud = curve - each.side * 3.0 * normals(curve, t)
        line = wall_curve(cam, each.seat, each.side, np.linspace(0.1, 6.2, 67), DEEP)
        away = KDTree(cloud.T).query(line.plane(DEEP).T)[0]
        assert offset_errors(cam, line, drawn, DEEP) == pytest.approx(away - 3.0, abs=2e-6)


def normals(curve: Array, t: Array) -> Array:
    slope = np.gradient(curve, t, axis=1, edge_order=2)
    return np.asarray(np.stack([-slope[1], slope[0]]) / np.hypot(*slope))


@pytest.mark.parametrize("rotation", ["ccw", "cw"])
def test_a_helix_departs_by_the_closed_form(rotation: str) -> None:
    """At a constant slope k every curve is straight: α(ρ) = atan k/ρ at all of its points."""
    steps = [
        {"kind": "rise", "angle_deg": 157.0, "lift_mm": 91.3, "law": {"kind": "constant_velocity"}},
        {"kind": "return", "angle_deg": 203.0, "lift_mm": 91.3, "law": {"kind": "cycloidal"}},
    ]
    cam = SAMPLES["slide in a groove"].cam(program=steps, rotation=rotation)
    k = 91.3 / math.radians(157.0)
    rho = DEEP
    for _ in range(60):
        rho = math.sqrt(DEEP**2 - (RADIUS * math.sin(math.atan(k / rho))) ** 2)
    alpha, beta, outer = math.atan(k / rho), math.atan(k / DEEP), math.atan(k / OUTER)
    across = DEEP * math.asin(RADIUS * math.sin(alpha) / DEEP)
    true = across * math.sin(beta) + RADIUS * math.cos(alpha) * math.cos(beta)
    for each in cam.walls:
        line = wall_curve(cam, each.seat, each.side, np.array([1.2, 1.5]), DEEP)
        found = offset_errors(cam, line, DEEP, DEEP)
        assert found == pytest.approx(true - RADIUS, abs=1e-10)
        wrapped = RADIUS * math.cos(beta) / math.cos(outer)
        assert offset_errors(cam, line, OUTER, DEEP) == pytest.approx(true - wrapped, abs=1e-10)
    assert 0.003 < true - RADIUS < 0.1 < true - wrapped


def test_a_roller_that_does_not_reach_the_cylinder_leaves_nothing_there() -> None:
    """The turret's first roller passes 3.3 mm beside the axis where it rests, then farther."""
    cam = SAMPLES["turret"].cam()
    first = next(each for each in cam.walls if each.seat.number == 1)
    at_rest, farther = wall_curve(cam, first.seat, 0, np.array([0.0, 1.5]), 8.1).z
    assert np.isnan(farther)
    assert np.isnan(wall_curve(cam, first.seat, first.side, np.array([1.5]), 8.1).z).all()
    assert at_rest == pytest.approx(103.7 * math.sin(math.radians(22.5)))
