"""Linear relaxation of a bound on the pitch curve's curvature, for a trace point on a slide.

With the point's height X, its offset e and u = X' − e (of a roller X = s0 + s) the bound σκ ≤ k,
κ = [X² + u(2u + e) − X X''] / (X² + u²)^{3/2}, reads for X > 0

    σ X'' ≥ σ [X + 2(u + e/4)²/X] − σ e²/(8X) − k (X² + u²)^{3/2}/X

Each of the four terms is convex or concave in (X, u, e) as a whole: squares over X, and
(X² + u²)^{3/2}/X, are convex. So the right side is a difference A − B of convex functions, and over
a box it is nowhere below the tangent of A anywhere, less the lowest plane of a given slope that is
above B at every corner: linear in X, X', X'' and e. The narrower the box, the less is lost.

What presses the roller leaves less: (k − σκ) φ cos α ≥ Λ with Λ linear in the motion, cos α =
X/√(X² + u²) and φ ≤ a + b u/X adds Λ Q to the right side, Q = (X + u²/X)²/(a + b u/X). That is
convex: X² times the square of h(q) = (1 + q²)/√(a + bq) at q = u/X, and X h(u/X) is convex and
positive as h is (of h'' the sign is that of 2A² − 2bqA + ¾b²(1 + q²), A = a + bq > 0, which has no
real root). Where Λ and Q lie between Λ1 and Λ2, Q1 and Q2,

    Λ Q ≥ Λ1 Q + Q1 (Λ − Λ1),    Λ Q ≥ Λ2 Q + Q2 (Λ − Λ2)        (McCormick)

which is linear in the motion and a multiple of Q: a part of A, or of B if it is negative.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from synthesis.catalogue.box_bounds import BoxBound
from synthesis.catalogue.constraints import MotionBox, PointInequalities, PressureTerm
from synthesis.numerics.piecewise import Array

ROUNDING = 1e-13  # relative: a row is loosened by it, far above the rounding of its terms
CORNERS = np.array(list(product((False, True), repeat=3))).T  # (3, 8): upper end or lower
Convex = tuple[Array, Array]  # a function's values (n,) and its slopes by X, u and e (3, n)


@dataclass(frozen=True)
class CurvatureBound(BoxBound):
    """side · κ ≤ most, most > 0, on the pitch curve; with a pressure term, less than that.

    Attributes:
        side: +1 or −1. most: [1/length].
        pressure_term: Λ of (most − side · κ) φ cos α ≥ Λ; None stands for Λ = 0.
    """

    side: int
    most: float
    pressure_term: PressureTerm | None = None

    @property
    def needs_motion_bounds(self) -> bool:
        return self.pressure_term is not None

    @property
    def varies_with_angle(self) -> bool:
        return self.pressure_term is not None  # as the load does

    @property
    def known_orders(self) -> int:
        return 2 if self.pressure_term is None else 3

    def linear_relaxation(
        self, low: Array, high: Array, about: Array | None, moving: MotionBox | None = None
    ) -> tuple[PointInequalities, ...]:
        if not (np.all(low[0] > 0.0) and np.all(np.isfinite(low)) and np.all(np.isfinite(high))):
            return ()
        # The bound reads σ X'' ≥ A − B with A and B convex. Where the box reaches X ≤ 0 neither is.
        middle = 0.5 * (low + high)
        at = middle if about is None else np.clip(about, low, high)
        # The product with the squares from below: Λ Q ≥ weight Q + square (Λ − weight).
        weight, one = np.zeros(low.shape[1]), np.ones(low.shape[1])
        square, constant, factors = weight, weight, np.zeros((3, 1))
        friction = np.stack([one, weight])
        if self.pressure_term is not None:
            if moving is None or not np.all(np.isfinite(moving.low + moving.high)):
                return ()
            coefficients, constant = self.pressure_term.linear_form(moving.theta)
            factors = coefficients[:, None]
            friction = np.stack(self.pressure_term.friction_bound(low, high, moving))
            # Ranges of Λ, by interval arithmetic, and of Q over the box.
            ends = np.sort(np.stack([factors * moving.low, factors * moving.high]), axis=0)
            weak, strong = np.sum(ends, axis=1) + constant
            small, large = _square_range(low, high, friction)
            # Of McCormick's two minorants of the product the larger one where rows shall be tight.
            here = _square(at, friction)[0]
            place = 0.5 * (moving.low + moving.high) if moving.about is None else moving.about[0]
            force = np.clip(np.sum(factors * place, axis=0) + constant, weak, strong)
            lower = (force - weak) * (here - small) <= (strong - force) * (large - here)
            weight, square = np.where(lower, weak, strong), np.where(lower, small, large)
        convex, concave = _speed_term, _offset_term
        if self.side < 0:
            convex, concave = concave, convex

        def minuend(x: Array) -> Convex:
            """A: what the convex terms demand of σ X''."""
            return _add_multiple(*convex(x), x, np.maximum(weight, 0.0), friction)

        def subtrahend(x: Array) -> Convex:
            """B: convex terms that are subtracted from it."""
            (bend, bends), (rest, rests) = _sharpness_term(x), concave(x)
            value, slopes = rest + self.most * bend, rests + self.most * bends
            return _add_multiple(value, slopes, x, np.maximum(-weight, 0.0), friction)

        # A is nowhere below its tangent at a point.
        value, slopes = minuend(at)
        # B is nowhere above the plane with B's slope in the middle that is raised until it is above
        # B at every corner: B less a linear function is convex, hence largest at a corner.
        _, other = subtrahend(middle)
        corners = _corners(low, high)
        most = np.max(subtrahend(corners)[0] - np.sum(other[:, None] * corners, axis=0), axis=0)
        # side X'' ≥ least + by · (X, u, e) + square (Λ − weight) all over the box
        by = slopes - other
        least = value - np.sum(slopes * at, axis=0) - most + square * (constant - weight)
        terms = np.abs(value) + np.abs(most) + np.sum(np.abs(slopes * at), axis=0)
        least -= ROUNDING * (terms + square * (np.abs(constant) + np.abs(weight)))
        # Back from (X, u, e) to motion and size, which they are affine in.
        sign = self.coordinates.sign
        rows = np.stack([sign * by[0], sign * by[1], -self.side * sign * one, 0.0 * one])
        rows[:3] += square * factors
        known = np.array(self.coordinates.constants) @ by
        size = np.array(self.coordinates.size_factors).T @ by
        return (PointInequalities(rows, size, -least - known),)


def _corners(low: Array, high: Array) -> Array:
    """The corners of boxes: (3, 8, n)."""
    return np.where(CORNERS[:, :, None], high[:, None], low[:, None])


def _add_multiple(value: Array, slopes: Array, at: Array, weight: Array, friction: Array) -> Convex:
    """A convex function plus a multiple of Q."""
    if not np.any(weight):
        return value, slopes
    square, steps = _square(at, friction)
    return value + weight * square, slopes + weight * steps


def _square(at: Array, friction: Array) -> Convex:
    """Q = (X + u²/X)²/(a + b u/X)."""
    x, u, e = at
    q = u / x
    root, left = x + q * u, friction[0] + friction[1] * q
    value, lost = root**2 / left, friction[1] * root**2 / (x * left**2)
    by_x, by_u = 2.0 * root * (1.0 - q * q) / left + lost * q, 4.0 * root * q / left - lost
    return value, np.stack([by_x, by_u, 0.0 * e])


def _square_range(low: Array, high: Array, friction: Array) -> tuple[Array, Array]:
    """Least and largest Q over boxes."""
    corners = _corners(low, high)
    # X + u²/X grows with |u|, and with X from |u| on
    slow = np.maximum(np.maximum(low[1], -high[1]), 0.0)
    x = np.clip(slow, low[0], high[0])
    most = np.max(friction[0] + friction[1] * corners[1] / corners[0], axis=0)
    return (x + slow**2 / x) ** 2 / most, np.max(_square(corners, friction)[0], axis=0)


def _speed_term(at: Array) -> Convex:
    """X + 2 (u + e/4)²/X."""
    x, u, e = at
    q = (u + 0.25 * e) / x
    return x + 2.0 * q * q * x, np.stack([1.0 - 2.0 * q * q, 4.0 * q, q])


def _offset_term(at: Array) -> Convex:
    """e²/(8X)."""
    x, u, e = at
    q = e / x
    return 0.125 * q * e, np.stack([-0.125 * q * q, 0.0 * u, 0.25 * q])


def _sharpness_term(at: Array) -> Convex:
    """(X² + u²)^{3/2}/X."""
    x, u, e = at
    w = np.hypot(x, u)
    return w**3 / x, np.stack([3.0 * w - w**3 / x**2, 3.0 * w * u / x, 0.0 * e])
