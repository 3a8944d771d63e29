"""Walls of a globoidal cam: meshing, tangents, touch by rollers that know nothing of contacts."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from synthesis.geometry.globoidal import Contacts, Globoidal, Place, Roller, turned
from synthesis.laws import LAWS

Array = NDArray[np.float64]
DISTANCE, INDEX, TURN, ROLLERS = 181.3, math.radians(60.0), math.radians(118.0), 6
CYLINDER, CROWNED = Roller(23.7, 71.9, 102.4), Roller(23.7, 71.9, 102.4, 151.0)
RHO = np.linspace(72.3, 102.1, 7)
CASES = [
    (roller, hand, sense) for roller in (CYLINDER, CROWNED) for hand in (1, -1) for sense in (1, -1)
]
STARTS = [math.pi / ROLLERS - 2.0 * math.pi * i / ROLLERS for i in range(3)]


def place(theta: Array, start: float, sense: int) -> Place:
    """A roller that indexes by the cycloidal law from θ = 0 on, and rests before and after."""
    g = LAWS["cycloidal"].curve("rise").derivatives(np.clip(theta / TURN, 0.0, 1.0), 2)
    moving = (theta > 0.0) & (theta < TURN)
    way = sense * INDEX
    return Place(start + way * g[0], way / TURN * g[1] * moving, way / TURN**2 * g[2] * moving)


def on_cam(cam: Globoidal, theta: Array, rho: Array, start: float, sense: int, side: int) -> Array:
    return cam.on_cam(theta, cam.contacts(place(theta, start, sense), rho, side).point)


def all_contacts(cam: Globoidal, sense: int) -> list[tuple[Array, float, int, Contacts]]:
    theta = np.linspace(-0.4, TURN + 0.4, 71)
    return [
        (theta, start, side, cam.contacts(place(theta, start, sense), RHO, side))
        for start in STARTS
        for side in (1, -1)
    ]


@pytest.mark.parametrize(("roller", "hand", "sense"), CASES)
def test_nothing_moves_along_the_normal(roller: Roller, hand: int, sense: int) -> None:
    for *_, found in all_contacts(Globoidal(DISTANCE, roller, hand), sense):
        assert np.abs((found.normal * found.slip).sum(axis=0)).max() < 1e-12 * DISTANCE
        assert np.abs((found.normal**2).sum(axis=0) - 1.0).max() < 1e-14


@pytest.mark.parametrize(("roller", "hand", "sense"), CASES)
def test_the_normal_is_across_the_wall_s_own_differences(
    roller: Roller, hand: int, sense: int
) -> None:
    cam, h = Globoidal(DISTANCE, roller, hand), 1e-5
    theta = np.linspace(0.05, TURN - 0.05, 23)
    for start in STARTS:
        for side in (1, -1):
            here = (start, sense, side)
            found = cam.contacts(place(theta, start, sense), RHO, side)
            normal = turned(found.normal, -hand * theta)
            by_theta = (on_cam(cam, theta + h, RHO, *here) - on_cam(cam, theta - h, RHO, *here)) / (
                2 * h
            )
            by_rho = (on_cam(cam, theta, RHO + h, *here) - on_cam(cam, theta, RHO - h, *here)) / (
                2 * h
            )
            assert np.abs((normal * by_theta).sum(axis=0)).max() < 1e-6
            assert np.abs((normal * by_rho).sum(axis=0)).max() < 1e-7
            area = (np.cross(by_theta, by_rho, axis=0) * normal).sum(axis=0)
            assert (
                np.sign(area / area[0, 0]) == np.sign(found.regular / found.regular[0, 0])
            ).all()


def axis_distance(cam: Globoidal, points: Array, theta: float, psi: float) -> tuple[Array, Array]:
    """Distance (n,) of points of the cam from a roller's axis, and their place along it."""
    there = turned(points[:, None, :], np.array([cam.hand * theta]))[:, 0, :]
    there = there + np.array([cam.distance, 0.0, 0.0])[:, None]
    u = np.array([math.cos(psi), math.sin(psi), 0.0])
    along = u @ there
    return np.linalg.norm(there - np.outer(u, along), axis=0), along


@pytest.mark.parametrize("hand", [1, -1])
@pytest.mark.parametrize("roller", [CYLINDER, CROWNED])
def test_no_roller_comes_closer_than_its_radius(roller: Roller, hand: int) -> None:
    """Over a full index, with all rollers of the turret and points of both walls of one groove."""
    cam = Globoidal(DISTANCE, roller, hand)
    theta = np.linspace(0.02, TURN - 0.02, 31)
    start = STARTS[1]
    touched = []
    for side in (1, -1):
        found = cam.contacts(place(theta, start, 1), RHO, side)
        assert found.regular.min() > 0.2
        points = cam.on_cam(theta, found.point).reshape(3, -1)
        least = np.full(points.shape[1], np.inf)
        for t in np.linspace(0.0, TURN, 1501):
            at = place(np.array([t]), 0.0, 1).psi[0]
            for i in range(ROLLERS):
                psi = at + math.pi / ROLLERS + 2.0 * math.pi * i / ROLLERS
                if math.cos(psi) < 0.3:
                    continue
                away, along = axis_distance(cam, points, t, psi)
                inside = (along > roller.inner) & (along < roller.outer)
                radius = roller.profile(np.where(inside, along, roller.middle))[0]
                least = np.where(inside, np.minimum(least, away - radius), least)
        touched.append(least)
        assert least.min() > -1e-9
    assert max(least.max() for least in touched) < 2e-3  # between two of the angles tried


def test_the_pressure_angle_is_that_of_the_formula() -> None:
    cam, theta = Globoidal(DISTANCE, CYLINDER), np.linspace(0.0, TURN, 41)
    at = place(theta, STARTS[1], 1)
    found = cam.contacts(at, RHO, 1).pressure_angle
    expected = np.arctan(
        np.abs(at.psi1)[:, None] * RHO / (DISTANCE - RHO * np.cos(at.psi)[:, None])
    )
    assert np.abs(found - expected).max() < 1e-14


def test_a_roller_too_large_for_the_way_undercuts() -> None:
    """A hundredth below and above the radius at which the wall's area vanishes somewhere."""
    theta = np.linspace(0.02, TURN - 0.02, 401)

    def least(radius: float) -> float:
        cam = Globoidal(DISTANCE, Roller(radius, 71.9, 102.4))
        return min(
            float(cam.contacts(place(theta, STARTS[1], 1), RHO, side).regular.min())
            for side in (1, -1)
        )

    low, high = 5.0, 90.0
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if least(middle) > 0.0 else (low, middle)
    assert least(0.99 * low) > 0.0 > least(1.01 * low)
    # principal curvatures of the axis's own surface, by differences, say the same radius
    h = 1e-4
    cam = Globoidal(DISTANCE, Roller(1e-9, 71.9, 102.4))

    def axis(t: Array, rho: Array) -> Array:
        return cam.on_cam(t, cam.contacts(place(t, STARTS[1], 1), rho, 1).point)

    p = axis(theta, RHO)
    normal = turned(cam.contacts(place(theta, STARTS[1], 1), RHO, 1).normal, -theta)
    pt = (axis(theta + h, RHO) - axis(theta - h, RHO)) / (2 * h)
    pr = (axis(theta, RHO + h) - axis(theta, RHO - h)) / (2 * h)
    ptt = (axis(theta + h, RHO) - 2 * p + axis(theta - h, RHO)) / h**2
    ptr = (
        axis(theta + h, RHO + h) - axis(theta + h, RHO - h)
        - axis(theta - h, RHO + h) + axis(theta - h, RHO - h)
    ) / (4 * h**2)  # fmt: skip
    e, f, g = ((a * b).sum(axis=0) for a, b in ((pr, pr), (pr, pt), (pt, pt)))
    m, n = (ptr * normal).sum(axis=0), (ptt * normal).sum(axis=0)
    w = e * g - f**2
    mean, gauss = (n * e - 2 * m * f) / (2 * w), -(m**2) / w
    root = np.sqrt(np.maximum(mean**2 - gauss, 0.0))
    largest = max(float((mean + root).max()), float((root - mean).max()))
    assert 1.0 / largest == pytest.approx(low, rel=2e-3)
