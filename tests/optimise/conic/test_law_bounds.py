"""What is known of a law between nodes, and of rows on given laws, against laws themselves."""

from __future__ import annotations

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
