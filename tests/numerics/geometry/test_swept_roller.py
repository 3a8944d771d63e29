"""Walls that swept rollers leave: meshing, tangents, and touch by rollers that know no contacts."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from synthesis.catalogue.laws import LAWS
from synthesis.numerics.geometry.swept_roller import (
    Contacts,
    FollowerState,
    Joint,
    Roller,
    SweptRoller,
    rotate,
)

Array = NDArray[np.float64]
DISTANCE, INDEX, TURN, ROLLERS = 181.3, math.radians(60.0), math.radians(118.0), 6
CYLINDER, CROWNED = Roller(23.7, 71.9, 102.4), Roller(23.7, 71.9, 102.4, 151.0)
X, Y, Z = np.eye(3)
RHO = np.linspace(72.3, 102.1, 7)
CASES = [
    (roller, hand, sense) for roller in (CYLINDER, CROWNED) for hand in (1, -1) for sense in (1, -1)
]
STARTS = [math.pi / ROLLERS - 2.0 * math.pi * i / ROLLERS for i in range(3)]


def place(theta: Array, start: float, sense: int) -> FollowerState:
    """A roller that indexes by the cycloidal law from θ = 0 on, and rests before and after."""
    g = LAWS["cycloidal"].curve("rise").derivatives(np.clip(theta / TURN, 0.0, 1.0), 2)
    moving = (theta > 0.0) & (theta < TURN)
    way = sense * INDEX
    return FollowerState(
        start + way * g[0], way / TURN * g[1] * moving, way / TURN**2 * g[2] * moving
    )


def globoidal(distance: float, roller: Roller, hand: int = 1) -> SweptRoller:
    centre, joint = np.array([distance, 0.0, 0.0]), Joint.pivot(np.zeros(3), Z)
    return SweptRoller(centre, Y, joint, np.zeros(3), X, roller, hand)


def drum(distance: float, roller: Roller, hand: int = 1) -> SweptRoller:
    """A cylindrical cam about z, its follower on an arm that swings about a line across it."""
    joint = Joint.pivot(np.array([61.3, 17.7, -3.1]), X)
    return SweptRoller(np.zeros(3), Z, joint, np.array([0.0, 1.9, 2.3]), X, roller, hand)


def slide(distance: float, roller: Roller, hand: int = 1) -> SweptRoller:
    """A cylindrical cam about z, its follower in a guide along it."""
    return SweptRoller(
        np.zeros(3), Z, Joint.guide(31.0 * Z), np.array([0.0, 3.1, 0.0]), X, roller, hand
    )


MACHINES = {each.__name__: each for each in (globoidal, drum, slide)}


def on_cam(
    cam: SweptRoller, theta: Array, rho: Array, start: float, sense: int, side: int
) -> Array:
    return cam.on_cam(theta, cam.contacts(place(theta, start, sense), rho, side).point)


def all_contacts(cam: SweptRoller, sense: int) -> list[tuple[Array, float, int, Contacts]]:
    theta = np.linspace(-0.4, TURN + 0.4, 71)
    return [
        (theta, start, side, cam.contacts(place(theta, start, sense), RHO, side))
        for start in STARTS
        for side in (1, -1)
    ]


@pytest.mark.parametrize("machine", MACHINES)
@pytest.mark.parametrize(("roller", "hand", "sense"), CASES)
def test_nothing_moves_along_the_normal(
    machine: str, roller: Roller, hand: int, sense: int
) -> None:
    for *_, found in all_contacts(MACHINES[machine](DISTANCE, roller, hand), sense):
        assert np.abs((found.normal * found.slip).sum(axis=0)).max() < 1e-12 * DISTANCE
        assert np.abs((found.normal**2).sum(axis=0) - 1.0).max() < 1e-14


@pytest.mark.parametrize("machine", MACHINES)
@pytest.mark.parametrize(("roller", "hand", "sense"), CASES)
def test_the_normal_is_across_the_wall_s_own_differences(
    machine: str, roller: Roller, hand: int, sense: int
) -> None:
    cam, h = MACHINES[machine](DISTANCE, roller, hand), 1e-5
    theta = np.linspace(0.05, TURN - 0.05, 23)
    for start in STARTS:
        for side in (1, -1):
            here = (start, sense, side)
            found = cam.contacts(place(theta, start, sense), RHO, side)
            normal = rotate(found.normal, -hand * theta, cam.axis)
            by_theta = (on_cam(cam, theta + h, RHO, *here) - on_cam(cam, theta - h, RHO, *here)) / (
                2 * h
            )
            by_rho = (on_cam(cam, theta, RHO + h, *here) - on_cam(cam, theta, RHO - h, *here)) / (
                2 * h
            )
            assert np.abs((normal * by_theta).sum(axis=0)).max() < 1e-6
            assert np.abs((normal * by_rho).sum(axis=0)).max() < 1e-7
            area = (np.cross(by_theta, by_rho, axis=0) * normal).sum(axis=0)
            assert area == pytest.approx(found.regular * axis_area(cam, theta, here), abs=1e-4)


def axis_area(cam: SweptRoller, theta: Array, here: tuple[float, int, int]) -> Array:
    """Of the surface that feet of normals sweep, by differences of a roller of no radius."""
    h, thin = 1e-5, replace(cam, roller=Roller(0.0, cam.roller.inner, cam.roller.outer))
    radius, slope, _ = cam.roller.profile(RHO)
    foot = RHO + radius * slope
    ahead, behind = (on_cam(thin, theta + step, foot, *here) for step in (h, -h))
    beyond = on_cam(thin, theta, foot + 1.0, *here) - on_cam(thin, theta, foot, *here)
    start, sense, side = here
    found = cam.contacts(place(theta, start, sense), RHO, side)
    across = found.point - thin.contacts(place(theta, start, sense), RHO, side).point
    normal = rotate(across / radius, -cam.hand * theta, cam.axis)
    return (np.cross((ahead - behind) / (2 * h), beyond, axis=0) * normal).sum(axis=0)


def axis_distance(cam: SweptRoller, points: Array, theta: Array, psi: Array) -> tuple[Array, Array]:
    """Distance of n points of the cam from a roller's axis at m angles, and their place on it.

    Both (m, n).
    """
    there = rotate(points[:, None, :], cam.hand * theta, Y) + cam.centre[:, None, None]
    u = np.stack([np.cos(psi), np.sin(psi), np.zeros_like(psi)])[:, :, None]
    along = (u * there).sum(axis=0)
    return np.linalg.norm(there - u * along, axis=0), along


@pytest.mark.parametrize("hand", [1, -1])
@pytest.mark.parametrize("roller", [CYLINDER, CROWNED])
def test_no_roller_comes_closer_than_its_radius(roller: Roller, hand: int) -> None:
    """Over a full index, with all rollers of the turret and points of both walls of one groove."""
    cam = globoidal(DISTANCE, roller, hand)
    theta = np.linspace(0.02, TURN - 0.02, 31)
    start = STARTS[1]
    touched = []
    for side in (1, -1):
        found = cam.contacts(place(theta, start, 1), RHO, side)
        assert found.regular.min() > 0.2
        points = cam.on_cam(theta, found.point).reshape(3, -1)
        least = np.full(points.shape[1], np.inf)
        t = np.linspace(0.0, TURN, 1501)
        for i in range(ROLLERS):
            psi = place(t, 0.0, 1).q + math.pi / ROLLERS + 2.0 * math.pi * i / ROLLERS
            faces = np.cos(psi) >= 0.3
            away, along = axis_distance(cam, points, t[faces], psi[faces])
            inside = (along > roller.inner) & (along < roller.outer)
            radius = roller.profile(np.where(inside, along, roller.middle))[0]
            gap = np.where(inside, away - radius, np.inf)
            least = np.minimum(least, gap.min(axis=0, initial=np.inf))
        touched.append(least)
        assert least.min() > -1e-9
    assert max(least.max() for least in touched) < 2e-3  # between two of the angles tried


def test_the_pressure_angle_is_that_of_the_formula() -> None:
    cam, theta = globoidal(DISTANCE, CYLINDER), np.linspace(0.0, TURN, 41)
    at = place(theta, STARTS[1], 1)
    found = cam.contacts(at, RHO, 1).pressure_angle
    expected = np.arctan(np.abs(at.q1)[:, None] * RHO / (DISTANCE - RHO * np.cos(at.q)[:, None]))
    assert np.abs(found - expected).max() < 1e-14


def test_a_roller_too_large_for_the_way_undercuts() -> None:
    """A hundredth below and above the radius at which the wall's area vanishes somewhere."""
    theta = np.linspace(0.02, TURN - 0.02, 401)

    def least(radius: float) -> float:
        cam = globoidal(DISTANCE, Roller(radius, 71.9, 102.4))
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
    cam = globoidal(DISTANCE, Roller(1e-9, 71.9, 102.4))

    def axis(t: Array, rho: Array) -> Array:
        return cam.on_cam(t, cam.contacts(place(t, STARTS[1], 1), rho, 1).point)

    p = axis(theta, RHO)
    normal = rotate(cam.contacts(place(theta, STARTS[1], 1), RHO, 1).normal, -theta, Y)
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
