"""What the benchmarks hold to be true is."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks import density, knots, profile_points, solvers, truth
from benchmarks.truth import SCENES, Scene
from synthesis import synthesise


def test_the_reference_is_what_its_own_method_gives() -> None:
    assert truth.prime_radius(400) == pytest.approx(truth.PRIME, abs=1.5 * truth.PRIME_KNOWN_TO)


@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.name)
def test_value_and_bound_lie_on_either_side(scene: Scene) -> None:
    proof = synthesise(scene.spec(tolerance=2e-3)).certificate
    assert proof.value is not None
    assert proof.lower_bound is not None
    assert proof.value >= scene.exact * (1.0 - scene.known_to - 1e-9)
    assert proof.lower_bound <= scene.exact * (1.0 + scene.known_to + 1e-9)
    assert proof.value - proof.lower_bound <= 2e-3 * proof.value


def test_points_read_back_are_the_textbook_cam() -> None:
    book, file = density.textbook(60), density.written(density.cam(), 4.0)
    reading = density.read(file)
    form, curvature, acceleration = reading.errors(book)
    assert form <= 1e-7
    assert max(curvature, acceleration) <= 5e-4
    assert reading.chords(book) <= 1e-3
    true = book.acceleration(book.curvature)
    moving = 2.0 * np.pi * np.where(book.degrees < 60.0, book.degrees, book.degrees - 90.0) / 60.0
    cycloid = np.sin(moving) * density.PEAK
    cycloid = np.where(book.degrees < 60.0, cycloid, -cycloid)
    still = (book.degrees > 150.0) | ((book.degrees > 60.0) & (book.degrees < 90.0))
    np.testing.assert_allclose(true, np.where(still, 0.0, cycloid), atol=1e-9 * density.PEAK)
    moved = density.Reading(reading.degrees, reading.places + np.array([1e-3, 0.0]))
    assert 0.9e-3 <= moved.errors(book)[0] <= 1e-3 + 1e-7


def test_profile_points_are_the_textbook_s() -> None:
    place, curvature = profile_points.errors(40)
    assert 0.0 < place <= 1e-12
    assert 0.0 < curvature <= 1e-12


def test_all_solvers_end_at_the_same_cam() -> None:
    scene = solvers.posed(13)
    ways = (solvers.by_clarabel, solvers.by_cvxpy, solvers.by_ipopt, solvers.by_slsqp)
    for way in ways:
        assert scene.error(way(scene, 1e-8)) <= 1e-6, way.__name__
    assert scene.error(scene.start()) > 1e-2


def test_more_knots_are_nearer_to_the_truth() -> None:
    scene = truth.PEAK_ACCELERATION
    values = []
    for intervals in (13, 43):
        once = knots._posed(scene, 2, False, intervals)()
        assert once is not None
        values.append(once)
    exact = knots._in_problem_units(scene, knots._posed(scene, 2, False, 13).problem)
    for value, lower, _ in values:
        assert lower <= exact * (1.0 + 1e-9)
        assert value >= exact * (1.0 - 1e-9)
    assert values[1][0] - exact <= 0.15 * (values[0][0] - exact)
