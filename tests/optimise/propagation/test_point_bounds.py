"""What lies between the nodes of a hull, against motions whose third derivative is capped."""

import numpy as np
import pytest

from synthesis.optimise.propagation.improving_region import PointBounds

ANGLE, BEND = 1.1, 700.0


def motion(seed: int) -> tuple[np.ndarray, ...]:
    """X, X' and X'' of a motion with a random capped third derivative, on a fine grid of x."""
    draw = np.random.default_rng(seed)
    x = np.linspace(0.0, 1.0, 4001)
    jerk = np.repeat(draw.uniform(-BEND, BEND, 40), 100)
    step = ANGLE / 4000
    a = draw.uniform(-40, 40) + np.concatenate([[0.0], np.cumsum(jerk * step)])
    v = 25.0 + np.concatenate([[0.0], np.cumsum(step * a[:-1] + step**2 / 2 * jerk)])
    s = 60.0 + np.concatenate(
        [[0.0], np.cumsum(step * v[:-1] + step**2 / 2 * a[:-1] + step**3 / 6 * jerk)]
    )
    return x, s, v


@pytest.mark.parametrize("seed", range(6))
def test_motions_that_keep_to_the_nodes_keep_to_what_is_said_between(seed):
    x, height, speed = motion(seed)
    e = 7.3
    nodes = np.array([0.2, 0.25, 0.31, 0.42, 0.7, 0.75])
    at = np.stack([np.interp(nodes, x, height), np.interp(nodes, x, speed) - e])
    slack = np.random.default_rng(seed).uniform(0.0, 2.0, (2, 2, len(nodes)))
    parts = ((0.2, 0.42), (0.7, 0.75))
    hull = PointBounds(
        nodes, parts, ANGLE, BEND, 0, at - slack[0], at + slack[1], (e - 0.4, e + 1.1)
    )
    assert not hull.is_empty
    inside = (x >= 0.2) & (x <= 0.75)
    low, high = hull.at(x[inside])
    for value, least, most in zip((height, speed - e), low, high, strict=False):
        assert np.all(value[inside] >= least - 1e-6)
        assert np.all(value[inside] <= most + 1e-6)
    assert low[2] == pytest.approx(e - 0.4)
    assert high[2] == pytest.approx(e + 1.1)


def test_one_that_can_only_rise_is_narrower():
    nodes = np.array([0.0, 0.5])
    low, high = np.array([[50.0, 60.0], [-6.0, -7.0]]), np.array([[51.0, 62.0], [40.0, 30.0]])
    x = np.array([0.25])
    either, up = (PointBounds(nodes, ((0.0, 0.5),), ANGLE, BEND, sense, low, high, (5.0, 6.0)).at(x)
                  for sense in (0, 1))  # fmt: skip
    assert up[0][0] > either[0][0]
    assert up[0][0] >= 50.0
    assert up[1][0] <= 62.0


def test_crossed_bounds_leave_nothing():
    nodes, low = np.array([0.0, 0.5]), np.array([[50.0, 60.0], [-6.0, -7.0]])
    hull = PointBounds(nodes, ((0.0, 0.5),), ANGLE, BEND, 1, low, low + 1.0, (5.0, 6.0))
    assert not hull.is_empty
    assert PointBounds(nodes, hull.parts, ANGLE, BEND, 1, low, low - 1.0, (5.0, 6.0)).is_empty
    assert PointBounds(nodes, hull.parts, ANGLE, BEND, 1, low, low + 1.0, (6.0, 5.0)).is_empty
