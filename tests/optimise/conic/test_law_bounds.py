"""What is known of a law between nodes, and of rows on given laws, against laws themselves."""

from __future__ import annotations

import math

import numpy as np
import pytest

from synthesis.catalogue.constraints import LinearInequality, SlideCoordinates
from synthesis.catalogue.laws import LAWS
from synthesis.catalogue.motion import PlacedSegment
from synthesis.optimise.conic.law_bounds import LawBounds
from synthesis.optimise.conic.linear_rows import row_excess
from synthesis.optimise.relaxation.size_rows import _box

NODES, X = np.array([0.0, 0.3, 0.8, 1.0]), np.linspace(0.0, 1.0, 201)


@pytest.mark.parametrize("room", [(0.0, 0.0), (0.0, 0.2), (0.2, 0.0)])
@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("top", [-7.0, 7.0])
def test_a_law_at_its_cap_is_within_what_its_nodes_leave(
    room: tuple[float, float], order: int, top: float
) -> None:
    """g^(order) is ±7 all along, so that no narrower bounds would hold."""
    poly = np.polynomial.Polynomial([0.1, 0.4, 0.9])
    poly = poly + top * np.polynomial.Polynomial([0.0] * order + [1.0 / (2.0, 6.0)[order - 2]])
    if order == 2:
        poly = poly - np.polynomial.Polynomial([0.0, 0.0, 0.9])
    slope = poly.deriv()
    at = poly(NODES), slope(NODES)
    bounds = LawBounds(
        NODES, at[0] - room[0], at[0] + room[1], at[1] - room[0], at[1] + room[1], order, 7.0
    )  # fmt: skip
    for (low, high), law in (
        (bounds.position_bounds(X), poly), (bounds.speed_bounds(X), slope),
    ):  # fmt: skip
        assert np.all(low <= law(X) + 1e-12)
        assert np.all(high >= law(X) - 1e-12)
    for said, known in zip(bounds.speed_bounds(NODES), (-room[0], room[1]), strict=True):
        assert said == pytest.approx(at[1] + known)


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("seed", [3, 11])
def test_a_law_of_a_capped_mean_square_is_within_what_its_nodes_leave(
    order: int, seed: int
) -> None:
    """Between two nodes nothing is known but ∫ (g^(order))² dx, of which this law has it all."""
    poly = np.polynomial.Polynomial(np.random.default_rng(seed).normal(size=8))
    slope, control = poly.deriv(), poly.deriv(order)
    whole = (control**2).integ()
    square = whole(1.0) - whole(0.0)
    values = poly(NODES), slope(NODES)
    ends = values[0], values[0], values[1], values[1]
    bounds = LawBounds(NODES, *ends, order, math.inf, square)
    for (low, high), law in (
        (bounds.position_bounds(X), poly), (bounds.speed_bounds(X), slope),
    ):  # fmt: skip
        assert np.all(low <= law(X) + 1e-12)
        assert np.all(high >= law(X) - 1e-12)


@pytest.mark.parametrize("order", [2, 3])
def test_no_narrower_bounds_of_a_capped_mean_square_would_hold(order: int) -> None:
    """The law that goes farthest: g' reaches the bound at the place it is made for."""
    at, t = 0.3, np.linspace(0.0, 1.0, 20_001)
    # g'' = 1 up to there; of order 3 Green's function of u'' = f for u = g', u(0) = u(1) = 0
    influence = 1.0 * (t < at) if order == 2 else np.where(t < at, t * (1.0 - at), at * (1.0 - t))
    square = np.trapezoid(influence**2, t)
    reached = np.trapezoid(influence * influence, t)
    nodes, zero = np.array([0.0, 1.0]), np.zeros(2)
    wide = zero + 9.0
    slow, fast = (zero, zero) if order == 3 else (np.array([0.0, -9.0]), np.array([0.0, 9.0]))
    bounds = LawBounds(nodes, -wide, wide, slow, fast, order, math.inf, square)
    low, high = bounds.speed_bounds(np.array([at]))
    assert high[0] == pytest.approx(reached, rel=1e-4)
    assert low[0] == pytest.approx(-reached, rel=1e-4)


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("squared", [False, True])
def test_a_law_goes_no_farther_between_nodes_than_is_said(order: int, *, squared: bool) -> None:
    """g' is 0 at both ends and at its fastest in between; the place is known at the start alone."""
    x = np.linspace(0.0, 1.0, 2001)
    control = np.where(x < 0.5, 1.0, -1.0) if order == 2 else -1.0 + 0.0 * x
    speed = np.minimum(x, 1.0 - x) if order == 2 else 0.5 * x * (1.0 - x)
    place = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1])) * x[1]])
    caps = (math.inf, np.trapezoid(control**2, x)) if squared else (1.0, math.inf)
    zero, unknown = np.zeros(2), np.array([0.0, 9.0])
    bounds = LawBounds(np.array([0.0, 1.0]), -unknown, unknown, zero, zero, order, *caps)
    low, high = bounds.position_bounds(x)
    assert np.all(low <= place + 1e-12)
    assert np.all(high >= place - 1e-12)
    assert high[-1] <= 3.0 * place[-1]


@pytest.mark.parametrize(("part", "at"), [((0.2, 0.8), 0.5), ((0.1, 0.3), 0.3), ((0.3, 0.3), 0.3)])
def test_the_worst_of_a_window_is_in_the_window(part: tuple[float, float], at: float) -> None:
    """The velocity of a cycloidal rise is (1 − cos 2πx) h/β."""
    lift, angle = 7.0, 1.3
    segment = PlacedSegment(0, "rise", 0.4, angle, 2.0, 2.0 + lift, LAWS["cycloidal"].curve("rise"))
    velocity = (1.0 - np.cos(2.0 * np.pi * at)) * lift / angle
    row = LinearInequality((0.0, 1.0, 0.0, 0.0), (2.0,), 11.0, interval=part)
    assert row_excess(row, segment, (1.5,)) == pytest.approx(velocity + 3.0 - 11.0)
    held = LinearInequality((0.0, 1.0, 0.0, 0.0), (), 2.0, interval=part, equality=True)
    ends = [(1.0 - np.cos(2.0 * np.pi * x)) * lift / angle for x in (*part, at)]
    assert row_excess(held, segment, ()) == pytest.approx(max(abs(v - 2.0) for v in ends))


def test_a_box_of_sizes_is_seen_from_corner_to_corner() -> None:
    seen = SlideCoordinates(1, (0.3, -0.2, 0.1), ((0.4, 1.0), (-1.0, 0.2), (1.0, 0.0)))
    s = np.random.default_rng(3).uniform(0.0, 9.0, (3, 4))
    boxes = np.array([[[-3.0, 1.0], [2.0, 1.5]], [[20.0, 30.0], [25.0, 44.0]]])  # (d, 2, b)
    low, high = _box(seen, np.repeat(s, 2, axis=1), np.tile(boxes, 4))
    for k in range(2):
        ends = boxes[:, :, k]
        corners = [(a, b) for a in ends[0] for b in ends[1]]
        values = np.array([np.stack(seen.evaluate(s, z)) for z in corners])  # (4, 3, n)
        assert low.reshape(3, 4, 2)[:, :, k] == pytest.approx(values.min(axis=0))
        assert high.reshape(3, 4, 2)[:, :, k] == pytest.approx(values.max(axis=0))
