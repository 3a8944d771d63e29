"""Taylor models: what a function does on a small box, with a proven remainder.

On the box θ = c + r t, t in [−1, 1], a model says

    f = c0 + c1 t + c2 t² + something not larger than rem,

and it says so for many boxes at once. Sums, products, quotients, roots and angles of models are
models again (Makino & Berz, Int. J. Pure Appl. Math. 4 (2003) 379), so a formula written for
numbers encloses its own range. The remainder shrinks with the cube of the box, which is why a
few subdivisions prove nine digits.

Rounding: ``mag`` bounds |f|, and |c0| + |c1| + |c2|, and all that was added up to make them. An
operation commits at most about 15 roundings of terms not larger than the mag of its result, and
adds ``ROUNDING`` · mag (32 of those roundings) to the remainder. Underflow is not covered:
quantities below 1e-290 do not occur in cams.

What does not move is a number, not a model: a model times 0 is the number 0, so that constant
parts of a formula cost next to nothing. (Functions are finite even where their models say nothing.)

Where a model cannot be formed (a divisor that may vanish on the box) the remainder is inf or nan;
evaluate under ``np.errstate(all="ignore")``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from operator import methodcaller, neg
from types import MappingProxyType
from typing import Any, ClassVar, Final

import numpy as np

from synthesis.numerics.piecewise import Array, Indices, Piecewise, horner

ROUNDING: Final = 2.0**-48  # of the magnitude: 32 unit roundoffs


UfuncRules = Mapping[np.ufunc, Callable[..., Any]]
ARITHMETIC: UfuncRules = MappingProxyType(
    {
        np.add: lambda a, b: b.__radd__(a),
        np.subtract: lambda a, b: b.__rsub__(a),
        np.multiply: lambda a, b: b.__rmul__(a),
        np.divide: lambda a, b: b.__rtruediv__(a),
        np.negative: neg,
        np.absolute: abs,
        np.sqrt: methodcaller("sqrt"),
    }
)


class UfuncDispatch:
    """NumPy's functions on models of functions: np.sqrt(f) and np.float64(2) * f are models again.

    ``rules`` have NumPy's names for what models do.
    """

    __slots__ = ()
    rules: ClassVar[UfuncRules] = ARITHMETIC

    def __radd__(self, other: Any) -> Any:
        return self + other

    def __rmul__(self, other: Any) -> Any:
        return self * other

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        rule = self.rules.get(ufunc)
        if rule is None or method != "__call__" or kwargs:
            return NotImplemented
        return rule(*inputs)


class Taylor(UfuncDispatch):
    """A quadratic Taylor model on each of n boxes; see the module's text.

    ``rem``: (n,) bound of the remainder; ``mag``: (n,) bound of |f| and of |c0| + |c1| + |c2|.
    """

    __slots__ = ("c0", "c1", "c2", "mag", "rem")
    rules: ClassVar[UfuncRules] = {
        **ARITHMETIC,
        np.sin: methodcaller("sin"),
        np.cos: methodcaller("cos"),
        np.arctan2: lambda y, x: _angle(y, x),
        np.hypot: lambda x, y: _distance(x, y),
    }

    def __init__(self, c0: Array, c1: Array, c2: Array, rem: Array, mag: Array) -> None:
        self.c0, self.c1, self.c2, self.rem, self.mag = c0, c1, c2, rem, mag

    @property
    def parts(self) -> tuple[Array, Array, Array, Array, Array]:
        """Coefficients, remainder and magnitude, as they are given to make one."""
        return self.c0, self.c1, self.c2, self.rem, self.mag

    @classmethod
    def of(cls, c0: Array, c1: Array, c2: Array, rem: Array) -> Taylor:
        """A model from its coefficients and remainder."""
        return cls(c0, c1, c2, rem, np.abs(c0) + np.abs(c1) + np.abs(c2) + rem)

    def __add__(self, other: Taylor | Array | float) -> Taylor:
        if isinstance(other, Taylor):
            mag = self.mag + other.mag
            rem = self.rem + other.rem + ROUNDING * mag
            return Taylor(self.c0 + other.c0, self.c1 + other.c1, self.c2 + other.c2, rem, mag)
        if isinstance(other, float) and other == 0.0:
            return self
        mag = self.mag + np.abs(other)
        return Taylor(self.c0 + other, self.c1, self.c2, self.rem + ROUNDING * mag, mag)

    def __sub__(self, other: Taylor | Array | float) -> Taylor:
        if isinstance(other, Taylor):
            mag = self.mag + other.mag
            rem = self.rem + other.rem + ROUNDING * mag
            return Taylor(self.c0 - other.c0, self.c1 - other.c1, self.c2 - other.c2, rem, mag)
        return self + (-other)

    def __neg__(self) -> Taylor:
        return Taylor(-self.c0, -self.c1, -self.c2, self.rem, self.mag)

    def __mul__(self, other: Taylor | Array | float) -> Any:
        if not isinstance(other, Taylor):
            return self._times(other)
        if other is self:
            return self._squared()
        a0, a1, a2, b0, b1, b2 = self.c0, self.c1, self.c2, other.c0, other.c1, other.c2
        mag = self.mag * other.mag
        dropped = np.abs(a1 * b2 + a2 * b1) + np.abs(a2 * b2)  # t³ and t⁴
        rem = dropped + self.rem * other.mag + other.rem * self.mag + ROUNDING * mag
        return Taylor(a0 * b0, a0 * b1 + a1 * b0, a0 * b2 + a1 * b1 + a2 * b0, rem, mag)

    def _times(self, other: Array | float) -> Any:
        """The product with numbers: a number itself if they are 0."""
        if isinstance(other, float):
            if other == 1.0:
                return self
            if other == 0.0:
                return 0.0
        size = np.abs(other)
        mag = self.mag * size
        rem = self.rem * size + ROUNDING * mag
        return Taylor(self.c0 * other, self.c1 * other, self.c2 * other, rem, mag)

    def _squared(self) -> Taylor:
        """f²: the product with itself in fewer steps."""
        a0, a1, a2, mag = self.c0, self.c1, self.c2, self.mag * self.mag
        twice, square = a0 + a0, a2 * a2
        rem = 2.0 * (np.abs(a1 * a2) + self.rem * self.mag) + square + ROUNDING * mag
        return Taylor(a0 * a0, twice * a1, twice * a2 + a1 * a1, rem, mag)

    def __truediv__(self, other: Taylor | Array | float) -> Any:
        if not isinstance(other, Taylor):
            return self._times(1.0 / other)
        b0, b1, b2 = other.c0, other.c1, other.c2
        c0 = self.c0 / b0
        c1 = (self.c1 - c0 * b1) / b0
        c2 = (self.c2 - c0 * b2 - c1 * b1) / b0
        size, blur = np.abs(c0) + np.abs(c1) + np.abs(c2), other.rem + ROUNDING * other.mag
        # a/b − c = (a − c b)/b, and a − c b holds no term below t³ but roundings
        residual = np.abs(c1 * b2 + c2 * b1) + np.abs(c2 * b2) + self.rem + size * blur
        residual = residual + ROUNDING * self.mag
        rem = residual / _positive(np.abs(b0) - np.abs(b1) - np.abs(b2) - blur)
        return Taylor(c0, c1, c2, rem, size + rem)

    def __rsub__(self, other: Array | float) -> Taylor:
        return -self + other

    def __rtruediv__(self, other: Array | float) -> Taylor:
        quotient: Taylor = self.constant(other) / self
        return quotient

    def constant(self, value: Array | float) -> Taylor:
        """A number as a model on the same boxes."""
        zero = np.zeros_like(self.c0)
        return Taylor.of(zero + value, zero, zero, zero)

    def mignitude(self) -> Array:
        """A lower bound of |f| on each box; not positive where f may vanish."""
        return np.abs(self.c0) - np.abs(self.c1) - np.abs(self.c2) - self.rem

    def __abs__(self) -> Taylor:
        """|f|: where its sign is not known on a box, no more than how large it can be."""
        sign = np.where(self.mignitude() - ROUNDING * self.mag > 0.0, np.sign(self.c0), 0.0)
        half = np.where(sign == 0.0, 0.5 * self.mag, 0.0)
        rem = np.where(sign == 0.0, half, self.rem)
        return Taylor(sign * self.c0 + half, sign * self.c1, sign * self.c2, rem, self.mag)

    def sqrt(self) -> Taylor:
        """√f, for f > 0 on the whole box."""
        c0 = np.sqrt(self.c0)
        twice = c0 + c0
        c1 = self.c1 / twice
        c2 = (self.c2 - c1 * c1) / twice
        spread = np.abs(c1) + np.abs(c2)
        size = c0 + spread
        # √a − c = (a − c²)/(√a + c), where a > 0 as c² is more than what a lacks of it
        residual = 2.0 * np.abs(c1 * c2) + c2 * c2 + self.rem
        residual = residual + ROUNDING * (self.mag + size * size)
        least = _positive(c0 - spread - ROUNDING * size)
        rem = residual / np.where(least * least > residual, least, 0.0)
        return Taylor(c0, c1, c2, rem, size + rem)

    def sin(self) -> Taylor:
        """The sine of f [rad]."""
        return self._wave(np.sin(self.c0), np.cos(self.c0))

    def cos(self) -> Taylor:
        """The cosine of f [rad]."""
        return self._wave(np.cos(self.c0), -np.sin(self.c0))

    def _wave(self, here: Array, slope: Array) -> Taylor:
        """g(f) for g'' = −g, of which g(c0) and g'(c0) are given."""
        a1, a2 = self.c1, self.c2
        step = np.abs(a1) + np.abs(a2) + self.rem  # |f − c0|
        # g(c0 + d) = g (1 − d²/2) + g' d + a cubic remainder, |g'''| ≤ 1
        square = 2.0 * np.abs(a1 * a2) + a2 * a2 + 2.0 * step * self.rem
        rem = np.abs(slope) * self.rem + 0.5 * np.abs(here) * square + step**3 / 6.0
        rem = rem + ROUNDING * (1.0 + self.mag + step * step)
        return Taylor.of(here, slope * a1, slope * a2 - 0.5 * here * a1 * a1, rem)

    def take(self, *which: Indices) -> Taylor:
        """Some of the models."""
        return Taylor(*(part[which] for part in self.parts))

    def range(self) -> tuple[Array, Array]:
        """Largest and smallest value of the quadratic over t in [−1, 1].

        Both are off by less than ``rem`` (roundings of this evaluation are in its allowance). Call
        it under ``np.errstate(all="ignore")``.
        """
        there = self._at_vertex()[1]
        middle, slope = self.c0 + self.c2, np.abs(self.c1)
        return np.maximum(middle + slope, there), np.minimum(middle - slope, there)

    def extreme_places(self) -> tuple[Array, Array]:
        """The t in [−1, 1] of the quadratic's largest and of its smallest value."""
        vertex, there = self._at_vertex()
        middle, slope = self.c0 + self.c2, np.abs(self.c1)
        side = np.where(self.c1 >= 0.0, 1.0, -1.0)
        high = np.where(there > middle + slope, vertex, side)
        return high, np.where(there < middle - slope, vertex, -side)

    def _at_vertex(self) -> tuple[Array, Array]:
        """The t of the parabola's vertex, or the end next to it, and the value there."""
        vertex = np.fmin(np.fmax(-0.5 * self.c1 / self.c2, -1.0), 1.0)  # of 0/0, an end
        return vertex, self.c0 + vertex * (self.c1 + vertex * self.c2)


def _angle(y: Taylor | float, x: Taylor | float) -> Taylor:
    """The angle of (x, y), of which one may be a number."""
    (y0, y1, y2, y_rem, y_mag), (x0, x1, x2, x_rem, x_mag) = _parts(y), _parts(x)
    # tangent of the angle from (x0, y0): q = n/d, n = y x0 − x y0, d = x x0 + y y0; 0 at t = 0
    d0, d1, d2 = x0 * x0 + y0 * y0, x1 * x0 + y1 * y0, x2 * x0 + y2 * y0
    width, height = np.abs(x0), np.abs(y0)
    n_rem, d_rem = y_rem * width + x_rem * height, x_rem * width + y_rem * height
    mag = (x_mag + y_mag) * (width + height)  # of n and of d
    q1 = (y1 * x0 - x1 * y0) / d0
    q2 = (y2 * x0 - x2 * y0 - q1 * d1) / d0
    size = np.abs(q1) + np.abs(q2)
    residual = np.abs(q1 * d2 + q2 * d1) + np.abs(q2 * d2) + n_rem + size * d_rem
    rounding = ROUNDING * mag
    least = d0 - np.abs(d1) - np.abs(d2) - d_rem - rounding
    rem = (residual + (1.0 + size) * rounding) / _positive(least)
    q_mag, angle = size + rem, np.arctan2(y0, x0)
    mag = np.abs(angle) + q_mag
    rem = rem + q_mag * q_mag * q_mag / 3.0 + ROUNDING * mag  # |atan q − q| ≤ |q|³/3
    return Taylor(angle, q1, q2, rem, mag + rem)


def _distance(x: Taylor | float, y: Taylor | float) -> Taylor:
    """The distance of (x, y) from 0, of which one may be a number.

    Where it may vanish on a box it has no quadratic: it lies between 0 and the farthest corner.
    """
    square: Any = x * x + y * y
    root = square.sqrt()
    farthest = [
        np.abs(a0) + np.abs(a1) + np.abs(a2) + rem for a0, a1, a2, rem, _ in map(_parts, (x, y))
    ]
    half = 0.5 * (1.0 + ROUNDING) * np.hypot(*farthest)
    coarse = ~(root.rem <= half)
    c0, c1, c2 = (
        np.where(coarse, each, own)
        for each, own in zip((half, 0.0, 0.0), root.parts[:3], strict=True)
    )
    return Taylor.of(c0, c1, c2, np.where(coarse, half, root.rem))


def _parts(value: Taylor | float) -> tuple[Any, Any, Any, Any, Any]:
    """Those of a model; a number is one that does not move."""
    return value.parts if isinstance(value, Taylor) else (value, 0.0, 0.0, 0.0, abs(value))


def _positive(value: Array) -> Array:
    """The value where it is positive, else 0: dividing by it leaves no remainder standing."""
    return np.fmax(value, 0.0)


UNIT: Final = 2.0**-53  # unit roundoff
HIGHEST: Final = 3  # models of f to f''' are on offer


class Jets:
    """Models of f, f', f'', f''' of one piecewise function; tables are made once.

    The Taylor series about a box's centre is exact for a polynomial: what a quadratic model drops
    is bounded by the higher coefficients there; of a sinusoid, by its amplitude.
    """

    def __init__(self, curve: Piecewise) -> None:
        self.curve = curve
        degree, waves = curve.poly.shape[1] - 1, curve.waves.shape[1] > 0
        self.rows = (max(degree, HIGHEST + 2) if waves else degree) + 1  # that do not vanish
        self._falling = np.stack([curve.descending, np.abs(curve.descending)], axis=1)
        self._horner_ulps = (4.0 * degree + 8.0) * UNIT
        amplitude, frequency, self._phase = curve.waves.transpose(2, 0, 1)
        self._frequency = frequency
        powers = np.arange(self.rows + 1)[:, None, None]
        self._amplitudes = amplitude * frequency**powers

    def derivatives(self, piece: Indices, x: Array) -> tuple[Array, Array]:
        """Values of f^(k)(x) by each piece's own formula, and bounds of their roundings.

        Two arrays (k, n) of all rows that do not vanish, of f to f^(5) at the least.
        """
        t = x - self.curve.origins[piece]
        count = max(self.rows, HIGHEST + 3)
        both = horner(self._falling.take(piece, axis=-1), np.stack([t, np.abs(t)]), count - 1)
        exact, error = both[:, 0], self._horner_ulps * both[:, 1]
        if self.curve.waves.shape[1]:
            turn, phase = self._frequency[piece] * t[:, None], self._phase[piece]
            angle = turn + phase
            sine, cosine = np.sin(angle), np.cos(angle)
            amplitude = self._amplitudes[: self.rows, piece]
            turns = np.stack([(sine, cosine, -sine, -cosine)[k % 4] for k in range(self.rows)])
            exact = exact + np.sum(amplitude * turns, axis=-1)
            spread = 16.0 * UNIT * (1.0 + np.abs(turn) + np.abs(phase))
            error = error + np.sum(np.abs(amplitude) * spread, axis=-1)
        return exact, error

    def models(self, piece: Indices, lo: Array, hi: Array, highest: int) -> tuple[Taylor, ...]:
        """f, f', …, f^(highest), at most f^(3), on boxes [lo, hi], each in its closed piece."""
        centre = 0.5 * (lo + hi)
        # so much wider that the roundings of the centre, and of its distance to the origin, fit in
        r = 0.5 * (hi - lo) + 8.0 * UNIT * (np.abs(centre) + np.abs(self.curve.origins[piece]))
        exact, error = self.derivatives(piece, centre)
        # 1. r^j/j!, by which the derivatives at the centre become coefficients
        power = [np.ones_like(r), r]
        for j in range(2, max(self.rows, 2) + 1):
            power.append(power[-1] * (r / j))
        # 2. quadratic part, and roundings of its coefficients; row k is that of f^(k)
        count = highest + 1
        head = (exact[:count], exact[1 : count + 1] * power[1], exact[2 : count + 2] * power[2])
        rem = error[:count] + error[1 : count + 1] * power[1] + error[2 : count + 2] * power[2]
        # 3. what the quadratic drops; polynomials end, a sinusoid is bounded by its amplitude
        for j in range(3, self.rows):
            rest = min(count, self.rows - j)
            rem[:rest] += (np.abs(exact[j : j + rest]) + error[j : j + rest]) * power[j]
        if self.curve.waves.shape[1]:
            amplitude = np.sum(np.abs(self._amplitudes[self.rows, piece]), axis=-1)
            for k in range(count):
                rem[k] += amplitude * power[self.rows - k]
        rem *= 1.0 + 64.0 * UNIT
        mag = np.abs(head[0]) + np.abs(head[1]) + np.abs(head[2]) + rem
        return tuple(map(Taylor, *head, rem, mag))
