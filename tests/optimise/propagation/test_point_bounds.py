"""What lies between the nodes of a hull, against motions whose third derivative is capped."""

from itertools import pairwise

import numpy as np
import pytest

from synthesis.optimise.propagation.point_bounds import CLOSEST_NODES, PointBounds

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
        nodes, parts, ANGLE, 3, BEND, 0, at - slack[0], at + slack[1], (e - 0.4, e + 1.1)
    )
    assert not hull.is_empty
    inside = (x >= 0.2) & (x <= 0.75)
    low, high = hull.at(x[inside])
    for value, least, most in zip((height, speed - e), low, high, strict=False):
        assert np.all(value[inside] >= least - 1e-6)
        assert np.all(value[inside] <= most + 1e-6)
    assert low[2] == pytest.approx(e - 0.4)
    assert high[2] == pytest.approx(e + 1.1)
    # and to what is said with more nodes, of which none lies beyond a part
    closer = hull.with_closer_nodes()
    assert len(closer.nodes) > len(nodes)
    assert set(nodes) <= set(closer.nodes)
    assert all(any(a <= node <= b for a, b in parts) for node in closer.nodes)
    low, high = closer.at(x[inside])
    for value, least, most in zip((height, speed - e), low, high, strict=False):
        assert np.all(value[inside] >= least - 1e-6)
        assert np.all(value[inside] <= most + 1e-6)


@pytest.mark.parametrize("order", [2, 3])
def test_nodes_lie_so_close_that_little_is_left_open_between_them(order):
    nodes, width = np.array([0.2, 0.3, 0.6, 0.7]), 2.0
    cap = 80.0 if order == 2 else 4000.0
    low, high = np.zeros((2, 4)), np.full((2, 4), width)
    hull = PointBounds(nodes, ((0.2, 0.3), (0.6, 0.7)), ANGLE, order, cap, 0, low, high, (0, 0))
    closer = hull.with_closer_nodes()
    for a, b in hull.parts:
        own = ANGLE * np.diff(closer.nodes[(closer.nodes >= a) & (closer.nodes <= b)])
        left_open = cap * own / 2.0 if order == 2 else cap * own**2 / 8.0
        # a tenth of the bounds at the nodes, unless nodes would be closer than they may
        assert np.all((left_open <= 0.1001 * width) | (own <= 2.0 * ANGLE * CLOSEST_NODES))
    assert closer.with_closer_nodes().nodes[1] == pytest.approx(closer.nodes[1])  # known: no wider
    assert not np.any((closer.nodes > 0.3) & (closer.nodes < 0.6))


@pytest.mark.parametrize("seed", range(6))
def test_further_parts_are_open_and_leave_what_is_known(seed: int) -> None:
    """A part that overlaps a known one, one between two, and one by itself."""
    x, height, speed = motion(seed)
    nodes = np.array([0.2, 0.31, 0.42, 0.7, 0.75])
    at = np.stack([np.interp(nodes, x, each) for each in (height, speed)])
    parts = ((0.2, 0.42), (0.7, 0.75))
    hull = PointBounds(nodes, parts, ANGLE, 3, BEND, 0, at - 1.0, at + 1.0, (0.0, 0.0))
    wider = hull.with_parts([(0.4, 0.5), (0.9, 0.97), (0.75, 0.78)], 0.05, 1e9)
    assert wider.parts == ((0.2, 0.5), (0.7, 0.78), (0.9, 0.97))
    known = np.isin(wider.nodes, nodes)
    assert np.array_equal(wider.nodes[known], nodes)
    assert np.array_equal(wider.low[:, known], hull.low)
    assert np.array_equal(wider.high[:, known], hull.high)
    assert np.all(wider.high[:, ~known] == 1e9)
    assert np.all(wider.low[:, ~known] == -1e9)
    for low, high in wider.parts:
        own = wider.nodes[(low <= wider.nodes) & (wider.nodes <= high)]
        assert (own[0], own[-1]) == (low, high)
    assert all(any(a <= node <= b for a, b in wider.parts) for node in wider.nodes)
    added = wider.nodes[(wider.nodes >= 0.42) & (wider.nodes <= 0.5)]
    assert np.all(np.diff(added) <= 0.05 * (1.0 + 1e-9))
    # what motions that keep to the nodes do in between is still said of them, open or not
    for low_end, high_end in wider.parts:
        inside = (x >= low_end) & (x <= high_end)
        low, high = wider.at(x[inside])
        for value, least, most in zip((height, speed), low, high, strict=False):
            assert np.all(value[inside] >= least - 1e-6)
            assert np.all(value[inside] <= most + 1e-6)
    assert hull.with_parts([(0.2, 0.3)], 0.5, 1e9).parts == parts


@pytest.mark.parametrize("seed", range(6))
def test_accelerations_between_nodes_are_those_that_a_capped_third_derivative_allows(seed):
    x, height, speed = motion(seed)
    bend = np.gradient(speed, x * ANGLE)
    nodes = np.array([0.1, 0.33, 0.4, 0.9])
    at = np.stack([np.interp(nodes, x, each) for each in (height, speed, bend)])
    slack = np.random.default_rng(seed).uniform(0.0, 2.0, (2, 3, len(nodes)))
    hull = PointBounds(
        nodes, ((0.1, 0.9),), ANGLE, 3, BEND, 0, at - slack[0], at + slack[1], (0.0, 0.0)
    )
    inside = (x >= 0.1) & (x <= 0.9)
    low, high = hull.acceleration_bounds(x[inside])
    step = BEND * ANGLE / 4000  # of the differences
    assert np.all(bend[inside] >= low - 2.0 * step)
    assert np.all(bend[inside] <= high + 2.0 * step)
    here = hull.acceleration_bounds(nodes)  # as narrow as they are known
    assert np.all(here[0] >= at[2] - slack[0][2] - 1e-9)
    assert np.all(here[1] <= at[2] + slack[1][2] + 1e-9)
    between = 0.125 * BEND * (ANGLE * np.diff(nodes)) ** 2  # by which u may leave its chord
    assert hull.width == pytest.approx(np.mean(slack[:, :2].sum(axis=0)) + np.mean(between))
    wide = PointBounds(nodes, ((0.1, 0.9),), ANGLE, 3, BEND, 0, at[:2], at[:2], (0.0, 0.0))
    assert [float(each[0]) for each in wide.acceleration_bounds(x[:1])] == [-np.inf, np.inf]


@pytest.mark.parametrize("room", [(0.0, 0.0), (0.0, 5.0), (5.0, 0.0)])
@pytest.mark.parametrize("cap", [0.0, -300.0, 300.0])
@pytest.mark.parametrize("bend", [-40.0, 40.0])
def test_between_exact_nodes_lies_a_motion_at_its_cap_itself(bend, cap, room):
    """Its third derivative is at the cap everywhere, so that no narrower bounds would hold."""
    nodes, x = np.array([0.0, 0.3, 0.8, 1.0]), np.linspace(0.0, 1.0, 201)

    def at(where):
        t = ANGLE * where
        height = 60.0 + 9.0 * t + 0.5 * bend * t**2 + cap * t**3 / 6.0
        return np.stack([height, 9.0 + bend * t + 0.5 * cap * t**2])

    ends = at(nodes) - room[0], at(nodes) + room[1]
    hull = PointBounds(nodes, ((0.0, 1.0),), ANGLE, 3, abs(cap), 0, *ends, (0.0, 0.0))
    low, high = hull.at(x)
    assert np.all(low[:2] <= at(x) + 1e-9)
    assert np.all(high[:2] >= at(x) - 1e-9)
    for said, known in zip(hull.at(nodes), ends, strict=True):
        assert said[1] == pytest.approx(known[1])


@pytest.mark.parametrize("room", [(0.0, 0.0), (0.0, 5.0), (5.0, 0.0)])
@pytest.mark.parametrize("switch", [0.05, 0.3, 0.47, 2.0])
@pytest.mark.parametrize("cap", [-40.0, 40.0])
def test_of_capped_accelerations_all_along_spans(cap, switch, room):
    """The acceleration is at its cap, and switches within a span: nothing narrower would hold."""
    nodes = np.array([0.0, 0.3, 0.8, 1.0])
    spans = np.array([[0.03, 0.12], [0.12, 0.5], [0.5, 0.95]])  # two of them across nodes

    def at(where):
        t, late = ANGLE * where, ANGLE * np.maximum(where - switch, 0.0)
        height = 60.0 - 9.0 * t + cap * (0.5 * t**2 - late**2)
        return np.stack([height, -9.0 + cap * (t - 2.0 * late)])

    ends = at(nodes) - room[0], at(nodes) + room[1]
    hull = PointBounds(nodes, ((0.0, 1.0),), ANGLE, 2, abs(cap), 0, *ends, (-1.0, 2.0))
    for span, low, high in zip(spans, *(each.T for each in hull.along(spans)), strict=True):
        x = np.linspace(*span, 101)
        assert np.all(low[:2, None] <= at(x) + 1e-9)
        assert np.all(high[:2, None] >= at(x) - 1e-9)
        assert (low[2], high[2]) == (-1.0, 2.0)
        # as narrow as at the single points of the span
        points = hull.at(x)
        assert np.all(low <= points[0].min(axis=1) + 1e-9)
        assert np.all(points[0].min(axis=1) - low <= 0.7 * abs(cap) * ANGLE * np.ptp(span) * 2.0)
    assert hull.acceleration_bounds(nodes)[1] == pytest.approx(abs(cap))
    # what lies between spans that are apart widens neither
    apart = hull.along(spans[[0, 2]])
    for near, far in zip(apart, hull.along(spans), strict=True):
        np.testing.assert_array_equal(near, far[:, [0, 2]])


def test_one_that_can_only_rise_is_narrower():
    nodes = np.array([0.0, 0.5])
    low, high = np.array([[50.0, 60.0], [-6.0, -7.0]]), np.array([[51.0, 62.0], [40.0, 30.0]])
    x = np.array([0.25])
    either, up = (
        PointBounds(nodes, ((0.0, 0.5),), ANGLE, 3, BEND, sense, low, high, (5.0, 6.0)).at(x)
        for sense in (0, 1)
    )
    assert up[0][0] > either[0][0]
    assert up[0][0] >= 50.0
    assert up[1][0] <= 62.0


def test_one_that_can_only_fall_is_its_mirror_image():
    nodes = np.array([0.0, 0.5])
    low, high = np.array([[50.0, 60.0], [-6.0, -7.0]]), np.array([[51.0, 62.0], [40.0, 30.0]])
    x = np.linspace(0.0, 0.5, 21)
    up = PointBounds(nodes, ((0.0, 0.5),), ANGLE, 3, BEND, 1, low, high, (5.0, 6.0)).at(x)
    down = PointBounds(nodes, ((0.0, 0.5),), ANGLE, 3, BEND, -1, -high, -low, (-6.0, -5.0)).at(x)
    assert down[0] == pytest.approx(-up[1])
    assert down[1] == pytest.approx(-up[0])


def test_crossed_bounds_leave_nothing():
    nodes, low = np.array([0.0, 0.5]), np.array([[50.0, 60.0], [-6.0, -7.0]])
    hull = PointBounds(nodes, ((0.0, 0.5),), ANGLE, 3, BEND, 1, low, low + 1.0, (5.0, 6.0))
    assert not hull.is_empty
    assert PointBounds(nodes, hull.parts, ANGLE, 3, BEND, 1, low, low - 1.0, (5.0, 6.0)).is_empty
    assert PointBounds(nodes, hull.parts, ANGLE, 3, BEND, 1, low, low + 1.0, (6.0, 5.0)).is_empty


@pytest.mark.parametrize("seed", range(4))
def test_motions_of_a_capped_mean_square_keep_to_what_is_said_between(seed):
    """What a motion has of ∫ (s^(m))² dθ between two nodes alone is all that it may have there."""
    x, height, speed = motion(seed)
    bend = np.gradient(speed, x * ANGLE)
    nodes, step = np.array([0.2, 0.25, 0.31, 0.42, 0.75]), ANGLE / 4000
    at = np.stack([np.interp(nodes, x, each) for each in (height, speed, bend)])
    inside = (x >= 0.2) & (x <= 0.75)
    for order, control in ((2, bend), (3, np.gradient(bend, x * ANGLE))):
        square = max(
            float(np.sum(control[(x >= a) & (x <= b)] ** 2) * step) for a, b in pairwise(nodes)
        )
        hull = PointBounds(
            nodes, ((0.2, 0.75),), ANGLE, order, np.inf, 0, at[:order], at[:order], (0.0, 0.0),
            1.02 * square,
        )  # fmt: skip
        for bounds in (hull, hull.with_closer_nodes()):
            low, high = bounds.at(x[inside])
            for value, least, most in zip((height, speed), low, high, strict=False):
                assert np.all(value[inside] >= least - 1e-6)
                assert np.all(value[inside] <= most + 1e-6)
            low, high = bounds.acceleration_bounds(x[inside])
            assert np.all(bend[inside] >= low - 2.0 * BEND * step)
            assert np.all(bend[inside] <= high + 2.0 * BEND * step)


@pytest.mark.parametrize("order", [2, 3])
def test_nodes_lie_as_close_where_a_mean_square_is_capped(order):
    nodes, width = np.array([0.2, 0.7]), 2.0
    square = 5.0 if order == 2 else 4000.0
    ends = np.zeros((2, 2)), np.full((2, 2), width)
    hull = PointBounds(nodes, ((0.2, 0.7),), ANGLE, order, np.inf, 0, *ends, (0, 0), square)
    closer = hull.with_closer_nodes()
    own = ANGLE * np.diff(closer.nodes)
    left_open = np.sqrt(square * own / 2.0 if order == 2 else square * own**3 / 48.0)
    assert np.all((left_open <= 0.1001 * width) | (own <= 2.0 * ANGLE * CLOSEST_NODES))
    assert len(closer.nodes) > 2
