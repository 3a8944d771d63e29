"""P4: a globoidal indexing cam, written down here a second time from the literature's meshing.

Six rollers that know their axes and no contacts run over it through a whole turn; and the source's
own equation, with the speed ratio upside down, leaves a cam that they would not fit into.
"""

from __future__ import annotations

import runpy
from math import pi, radians
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from service.contract.examples import examples
from synthesis import SpatialCamSpec, SpatialDesign, synthesise_spatial

Array = NDArray[np.float64]
DOCS = Path(__file__).resolve().parents[2] / "docs" / "reference"
C, RR, INNER, OUTER = 180.0, 30.0, 72.0, 102.0
INDEX, TURN, ROLLERS, HALF_WIDTH = radians(60.0), radians(120.0), 6, 50.0
FLANKS = {"1L": 30.0, "2L": -30.0, "2R": -30.0, "3R": -90.0}  # start angles of their rollers [deg]
POINTS = 101


def law(x: Array) -> tuple[Array, Array]:
    """CV50, half-sine pulses, from the pulse a = (8π/3) sin 4πx on [0, 1/4]: s and s'."""
    x = np.clip(x, 0.0, 1.0)
    y = np.minimum(x, 1.0 - x)
    pulse = y < 0.25
    s = np.where(pulse, 2 / 3 * (y - np.sin(4 * pi * y) / (4 * pi)), 1 / 6 + 4 / 3 * (y - 0.25))
    v = np.where(pulse, 2 / 3 * (1.0 - np.cos(4 * pi * y)), 4 / 3)
    return np.where(x < 0.5, s, 1.0 - s), v


def turret(theta: Array, start: float) -> tuple[Array, Array]:
    """ψ and ψ' of the roller that starts at an angle [deg]; θ of one turn."""
    s, v = law(theta / TURN)
    return radians(start) + INDEX * s, INDEX / TURN * v * (theta < TURN)


def flank(name: str, theta: Array, rho: Array, *, inverted: bool = False) -> Array:
    """Points (3, n, m) of a flank in the cam's frame; ``inverted``: as the source prints it."""
    psi, ratio = (each[:, None] for each in turret(theta, FLANKS[name]))
    if inverted:
        ratio = 1.0 / np.where(ratio == 0.0, np.inf, ratio)
    eta = np.arctan(rho * ratio / (C - rho * np.cos(psi)))  # left hand: the cam turns about +y
    side = 1.0 if name.endswith("R") else -1.0
    x = rho * np.cos(psi) - side * RR * np.cos(eta) * np.sin(psi)
    y = rho * np.sin(psi) + side * RR * np.cos(eta) * np.cos(psi)
    z = side * RR * np.sin(eta)
    t = theta[:, None]
    return np.stack([np.cos(t) * (x - C) - np.sin(t) * z, y, np.sin(t) * (x - C) + np.cos(t) * z])


def nearest(points: Array, angles: Array) -> tuple[Array, Array]:
    """How near any roller's axis comes to points (3, j) of the cam, and at which angle: (j,) each.

    Only where the point is beside the roller, between its two ends.
    """
    best, when = np.full(points.shape[1], np.inf), np.zeros(points.shape[1])
    for t in angles:
        x = C + np.cos(t) * points[0] + np.sin(t) * points[2]
        z = -np.sin(t) * points[0] + np.cos(t) * points[2]
        start = 30.0 - 60.0 * np.arange(ROLLERS)
        psi = np.radians(start) + INDEX * law(np.array(t / TURN))[0]
        u = np.stack([np.cos(psi), np.sin(psi)])
        along = u[0, :, None] * x + u[1, :, None] * points[1]
        across = -u[1, :, None] * x + u[0, :, None] * points[1]
        beside = (along > INNER - 1e-9) & (along < OUTER + 1e-9)
        away = np.where(beside, np.hypot(across, z), np.inf).min(axis=0)
        when = np.where(away < best, t, when)
        best = np.minimum(best, away)
    return best, when


@pytest.fixture(scope="module")
def p4() -> SpatialDesign:
    value = examples("spatial-cams")["p4"]["value"]
    return synthesise_spatial(SpatialCamSpec.model_validate(value))


def test_the_flanks_are_those_of_the_source(p4: SpatialDesign) -> None:
    assert [wall.name for wall in p4.walls] == ["1L", "2L", "2R", "3R"]
    assert p4.status == "feasible"


@pytest.mark.parametrize("name", FLANKS)
def test_every_flank_and_edge_is_the_literature_s_curve(p4: SpatialDesign, name: str) -> None:
    """101 points of the index on either edge, to 1e-10 mm."""
    cam = p4.cam
    wall = next(wall for wall in cam.walls if wall.name == name)
    theta, edges = np.linspace(0.0, TURN, POINTS), np.array([INNER, OUTER])
    points, outward = cam.surface(wall, theta, edges)
    assert points.shape == (3, POINTS, 2)
    assert np.abs(points - flank(name, theta, edges)).max() < 1e-10
    found = cam.contacts(wall, theta, edges)
    along = (found.normal * found.slip).sum(axis=0)
    assert np.abs(along).max() <= 1e-12 * C
    assert np.abs((outward**2).sum(axis=0) - 1.0).max() < 1e-14


def contacts(*, inverted: bool = False) -> tuple[Array, Array]:
    """Points of all flanks that are within the cam, and the angles of their contacts."""
    rho, found, angles = np.linspace(INNER, OUTER, 5), [], []
    theta = np.linspace(0.0, 2.0 * pi, 2401)[:-1:24]
    for name in FLANKS:
        points = flank(name, theta, rho, inverted=inverted)
        inside = np.abs(points[1]) < HALF_WIDTH
        found.append(points[:, inside])
        angles.append(np.broadcast_to(theta[:, None], inside.shape)[inside])
    return np.concatenate(found, axis=1), np.concatenate(angles)


def test_over_a_whole_turn_no_roller_cuts_any_flank_and_each_point_is_touched() -> None:
    points, angles = contacts()
    assert points.shape[1] > 900
    best, _ = nearest(points, np.linspace(0.0, 2.0 * pi, 2401)[:-1])
    assert best.min() >= RR - 1e-9
    assert best.max() <= RR + 1e-9  # the angles tried are among those of the contacts
    assert len(np.unique(angles)) > 90


def test_the_source_s_equation_leaves_a_cam_that_its_rollers_cut() -> None:
    """Its tan η has ω1/ω2 where ω2/ω1 belongs: off by 11 mm in the middle of the index."""
    points, _ = contacts(inverted=True)
    best, _ = nearest(points, np.linspace(0.0, 2.0 * pi, 601)[:-1])
    assert best.min() < RR - 5.0
    theta, rho = np.array([0.5 * TURN]), np.array([OUTER])
    apart = flank("2R", theta, rho, inverted=True) - flank("2R", theta, rho)
    assert np.linalg.norm(apart) == pytest.approx(11.5, abs=0.2)


def test_what_is_told_of_it(p4: SpatialDesign) -> None:
    """Largest pressure angle: tan α = ρ ψ'/(C − ρ) where the middle roller is at ψ = 0."""
    found = {each.quantity: each for each in p4.extremes}
    ratio = 4.0 / 3.0 * INDEX / TURN
    steepest = np.degrees(np.arctan(OUTER * ratio / (C - OUTER)))
    assert found["pressure_angle"].value == pytest.approx(steepest, abs=1e-9)
    assert found["pressure_angle"].angle_deg == pytest.approx(60.0, abs=1e-3)
    assert found["velocity"].value == pytest.approx(4.0 / 3.0 * 60.0 / 1.5, rel=1e-9)
    assert found["acceleration"].value == pytest.approx(8.0 * pi / 3.0 * 60.0 / 1.5**2, rel=1e-9)
    assert found["jerk"].value == pytest.approx(32.0 * pi**2 / 3.0 * 60.0 / 1.5**3, rel=1e-9)
    assert found["roller_gap"].value == pytest.approx(72.0 - 60.0 * np.cos(pi / 6.0))


def test_the_page_is_what_its_command_prints(capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(str(DOCS / "p4.py"), run_name="__main__")
    printed = capsys.readouterr().out.strip()
    page = (DOCS / "p4.md").read_text(encoding="utf-8")
    for table in printed.split("\n\n"):
        assert table in page, table
