"""The B-spline of a closed curve against curves whose distance is known in other ways."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ellipe

from synthesis.errors import InputError
from synthesis.numerics.geometry.closed_curve import ClosedCurve, CurvePoints
from synthesis.numerics.geometry.closed_spline import ClosedSpline, fit_closed_spline

A, B, SPLIT = 37.3, 21.9, 2.13


class Ellipse(ClosedCurve):
    """In two spans of its excentric angle, counter-clockwise."""

    @property
    def span_sizes(self) -> np.ndarray:
        return np.array([SPLIT, 2.0 * np.pi - SPLIT])

    def at(self, span: np.ndarray, fraction: np.ndarray) -> CurvePoints:
        width = self.span_sizes[span]
        t = np.array([0.0, SPLIT])[span] + width * fraction
        x, y, dx, dy = A * np.cos(t), B * np.sin(t), -A * np.sin(t), B * np.cos(t)
        speed = np.hypot(dx, dy)
        tangent = np.column_stack([dx, dy]) / speed[:, None]
        return CurvePoints(np.column_stack([x, y]), tangent, A * B / speed**3, speed * width)


class Stadium(ClosedCurve):
    """Two half circles and two straight lines: the curvature jumps four times, here and there."""

    radius, straight = 11.3, 29.7

    @property
    def span_sizes(self) -> np.ndarray:
        return np.array([1.0, np.pi, 1.0, np.pi])

    def at(self, span: np.ndarray, fraction: np.ndarray) -> CurvePoints:
        far = np.where(span >= 2, np.pi, 0.0)  # the second half is the first, turned
        bent = span % 2 == 1
        turn = np.where(bent, np.pi * fraction, 0.0)
        x = np.where(bent, self.straight + self.radius * np.sin(turn), self.straight * fraction)
        x, y = x - 0.5 * self.straight, -self.radius * np.cos(turn)
        cos, sin = np.cos(far), np.sin(far)
        points = np.column_stack([cos * x - sin * y, sin * x + cos * y])
        tangent = np.column_stack([np.cos(turn + far), np.sin(turn + far)])
        bend = np.where(bent, 1.0 / self.radius, 0.0)
        return CurvePoints(
            points, tangent, bend, np.where(bent, np.pi * self.radius, self.straight)
        )


def from_ellipse(points: np.ndarray) -> np.ndarray:
    """Distance from it, by Newton's method on the foot of the perpendicular."""
    x, y = points.T
    t = np.arctan2(y / B, x / A)
    for _ in range(8):
        ox, oy = A * np.cos(t) - x, B * np.sin(t) - y
        dx, dy = -A * np.sin(t), B * np.cos(t)
        t = t - (ox * dx + oy * dy) / (dx * dx + dy * dy - ox * A * np.cos(t) - oy * B * np.sin(t))
    return np.hypot(A * np.cos(t) - x, B * np.sin(t) - y)


def along(spline: ClosedSpline, count: int = 40_001) -> np.ndarray:
    return np.linspace(spline.knots[0], spline.knots[-1], count)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9])
def test_the_error_told_is_the_largest_there_is(tolerance: float) -> None:
    spline = fit_closed_spline(Ellipse(), tolerance)
    found = float(np.max(from_ellipse(spline.at(along(spline)))))
    assert spline.error <= tolerance
    assert found <= spline.error
    assert found > 0.9 * spline.error - 5e-14 * A
    assert spline.length == pytest.approx(4.0 * A * ellipe(1.0 - (B / A) ** 2), rel=1e-13)


def test_few_control_points_are_enough() -> None:
    assert len(fit_closed_spline(Ellipse(), 1e-6).points) < 90
    assert len(fit_closed_spline(Ellipse(), 1e-9).points) < 260


def test_it_is_closed_and_has_four_derivatives() -> None:
    spline = fit_closed_spline(Ellipse(), 1e-6)
    np.testing.assert_array_equal(spline.points[0], spline.points[-1])
    _, times = np.unique(spline.knots, return_counts=True)
    assert sorted(times.tolist())[-3:] == [1, 6, 6]
    ends = spline.at(np.array([0.0, spline.length]), 1)
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-12)
    ends = spline.at(np.array([0.0, spline.length]), 2)
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-12)


def test_a_jump_of_curvature_stays_one_and_nothing_rings_beside_it() -> None:
    curve = Stadium()
    spline = fit_closed_spline(curve, 1e-7)
    _, times = np.unique(spline.knots, return_counts=True)
    assert sorted(times[1:-1].tolist())[-3:] == [4, 4, 4]
    x, y = spline.at(along(spline)).T
    beyond = np.maximum(np.abs(x) - 0.5 * curve.straight, 0.0)
    off = np.where(beyond > 0.0, np.hypot(beyond, y), np.abs(y)) - curve.radius
    assert np.max(np.abs(off)) <= spline.error <= 1e-7
    bend = np.hypot(*spline.at(along(spline), 2).T)
    assert np.all((bend < 1e-6) | (np.abs(bend * curve.radius - 1.0) < 1e-3))
    assert spline.length == pytest.approx(2 * (curve.straight + np.pi * curve.radius), rel=1e-14)


def test_no_tolerance_below_rounding() -> None:
    with pytest.raises(InputError, match="rounding alone") as caught:
        fit_closed_spline(Ellipse(), 1e-13)
    assert caught.value.field == "/tolerance_um"


class Wavy(ClosedCurve):
    """A circle with waves in many spans, as a law of many knots has them; curvature goes on."""

    def __init__(self, spans: int, kink: float = 0.0) -> None:
        self.spans, self.kink = spans, kink

    @property
    def span_sizes(self) -> np.ndarray:
        return np.full(self.spans, 2.0 * np.pi / self.spans)

    def at(self, span: np.ndarray, fraction: np.ndarray) -> CurvePoints:
        # r(t) = 40 + kink · b(t), b of class C² with jumps of b''' at each end of a span
        width = 2.0 * np.pi / self.spans
        t, u, k = width * (span + fraction), fraction, self.kink
        b = [(u * (1 - u)) ** 3, 3 * (u * (1 - u)) ** 2 * (1 - 2 * u), None]
        b[2] = 6 * u * (1 - u) * (1 - 2 * u) ** 2 - 6 * (u * (1 - u)) ** 2
        r, r1, r2 = 40.0 + k * b[0], k * b[1] / width, k * b[2] / width**2
        cos, sin = np.cos(t), np.sin(t)
        speed = np.hypot(r, r1)
        points = np.column_stack([r * cos, r * sin])
        tangent = np.column_stack([r1 * cos - r * sin, r1 * sin + r * cos]) / speed[:, None]
        bend = (r * r + 2.0 * r1 * r1 - r * r2) / speed**3
        return CurvePoints(points, tangent, bend, speed * width)


def test_spans_between_which_nothing_happens_cost_nothing() -> None:
    many, one = fit_closed_spline(Wavy(96), 1e-7), fit_closed_spline(Wavy(1), 1e-7)
    assert len(many.points) == len(one.points) < 60
    _, times = np.unique(many.knots, return_counts=True)
    assert set(times[1:-1].tolist()) == {1}


@pytest.mark.parametrize("kink", [1e-8, 3e-2, 1.0])
def test_spans_are_joined_as_far_as_the_tolerance_bears_it(kink: float) -> None:
    curve = Wavy(96, kink)
    spline = fit_closed_spline(curve, 1e-6)
    x, y = spline.at(along(spline)).T
    t = np.arctan2(y, x) % (2.0 * np.pi)
    span = np.minimum((t * 96 / (2.0 * np.pi)).astype(int), 95)
    true = curve.at(span, t * 96 / (2.0 * np.pi) - span).points
    assert np.max(np.hypot(true[:, 0] - x, true[:, 1] - y)) <= 1.02 * spline.error
    assert spline.error <= 1e-6
    _, times = np.unique(spline.knots, return_counts=True)
    assert np.max(times[1:-1]) == (1 if kink < 1e-5 else 3)  # curvature goes on
    assert (len(spline.points) < 100) == (kink < 1e-5)
