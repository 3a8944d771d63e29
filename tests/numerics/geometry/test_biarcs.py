"""Arcs without corners against curves whose distance is known in other ways."""

from __future__ import annotations

import numpy as np
import pytest

from synthesis.numerics.geometry.biarcs import Arcs, fit_biarcs
from tests.numerics.geometry.test_closed_spline import Ellipse, Stadium, from_ellipse


def drawn(arcs: Arcs, count: int = 60) -> tuple[np.ndarray, np.ndarray]:
    """Points of every arc from its bulge alone, as a reader of the format draws it; tangents."""
    points, tangents = [], []
    for a, b, bulge in zip(arcs.points, np.roll(arcs.points, -1, axis=0), arcs.bulges, strict=True):
        chord = complex(*(b - a))
        sweep = 4.0 * np.arctan(bulge)
        turn = np.exp(1j * sweep * (np.linspace(0.0, 1.0, count) - 0.5))
        if sweep == 0.0:
            along = np.linspace(0.0, 1.0, count) * chord
            ends = np.array([chord, chord])
        else:
            along = chord * (turn - turn[0]) / (turn[-1] - turn[0])
            ends = chord * turn[[0, -1]]
        points.append(complex(*a) + along)
        tangents.append(ends / np.abs(ends))
    flat = np.concatenate(points)
    return np.column_stack([flat.real, flat.imag]), np.array(tangents)


@pytest.mark.parametrize(("tolerance", "most"), [(1e-2, 40), (1e-3, 80), (1e-4, 170)])
def test_arcs_keep_their_tolerance_and_have_no_corner(tolerance: float, most: int) -> None:
    arcs = fit_biarcs(Ellipse(), tolerance)
    points, tangents = drawn(arcs)
    found = float(np.max(from_ellipse(points)))
    assert found <= arcs.error <= tolerance
    assert found > 0.9 * arcs.error
    assert len(arcs.points) <= most
    np.testing.assert_allclose(tangents[:, 1], np.roll(tangents[:, 0], -1), rtol=0, atol=1e-12)
    assert np.all(arcs.bulges > 0.0)  # convex, counter-clockwise


def test_arcs_and_straight_lines_are_found_as_such() -> None:
    curve = Stadium()
    arcs = fit_biarcs(curve, 1e-3)
    assert arcs.error < 1e-12
    flat = arcs.bulges == 0.0
    assert np.sum(flat) == 4
    assert np.sum(4.0 * np.arctan(arcs.bulges)) == pytest.approx(2.0 * np.pi, rel=1e-14)
    x, y = drawn(arcs)[0].T
    beyond = np.maximum(np.abs(x) - 0.5 * curve.straight, 0.0)
    np.testing.assert_allclose(np.hypot(beyond, y)[beyond > 0.0], curve.radius, rtol=1e-13)
