"""Taylor models hold the truth: every operation against forty-digit decimals."""

from decimal import Decimal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from synthesis.numerics.taylor import Taylor
from tests.forty_digits import cos, sin

T = [Decimal(t) for t in ("-1", "-0.73", "-0.2", "0", "0.31", "0.9", "1")]
WIDTHS = st.sampled_from([0.0, 1e-9, 1e-3, 0.2])
Exact = list[Decimal]


@st.composite
def models(draw: st.DrawFn, positive: bool = False) -> tuple[Taylor, Exact]:
    """A model, and at every t of T a value that it allows."""
    c0 = draw(st.floats(0.3, 30.0)) * (1.0 if positive else draw(st.sampled_from([-1.0, 1.0])))
    width = draw(WIDTHS)
    parts = [abs(c0) * width * draw(st.floats(low, 1.0)) for low in (-1.0, -1.0, 0.0)]
    c1, c2, rem = (part if abs(part) > 1e-20 else 0.0 for part in parts)  # fifty digits suffice
    off = Decimal(rem) * Decimal(draw(st.sampled_from(["-0.999999999", "0", "0.999999999"])))
    exact = [Decimal(c0) + Decimal(c1) * t + Decimal(c2) * t * t + off for t in T]
    return Taylor.of(*(np.array([c]) for c in (c0, c1, c2, rem))), exact


def finite(model: Taylor) -> bool:
    """Whether the model says something."""
    return bool(np.isfinite(model.c0 + model.c1 + model.c2 + model.rem)[0])


def holds(model: Taylor, exact: Exact) -> bool:
    """Whether the model allows these values; a model that says nothing allows all."""
    if not finite(model):
        return True
    c0, c1, c2, rem = (Decimal(float(c[0])) for c in (model.c0, model.c1, model.c2, model.rem))
    mag = Decimal(float(model.mag[0])) * (1 + Decimal("1e-14"))
    close = all(
        abs(c0 + c1 * t + c2 * t * t - value) <= rem for t, value in zip(T, exact, strict=True)
    )
    return close and abs(c0) + abs(c1) + abs(c2) <= mag and max(map(abs, exact)) <= mag


@given(models(), models())
def test_sums_and_products(a, b):
    (f, u), (g, v) = a, b
    assert holds(f + g, [p + q for p, q in zip(u, v, strict=True)])
    assert holds(f - g, [p - q for p, q in zip(u, v, strict=True)])
    assert holds(f * g, [p * q for p, q in zip(u, v, strict=True)])
    assert holds(f * f, [p * p for p in u])
    assert holds(-f, [-p for p in u])


@given(models(), models())
def test_quotients(a, b):
    (f, u), (g, v) = a, b
    if all(v):
        assert holds(f / g, [p / q for p, q in zip(u, v, strict=True)])


@given(models(), st.floats(-7.0, 7.0).filter(lambda k: abs(k) > 1e-3))
def test_numbers_on_either_side(a, k):
    f, u = a
    c = Decimal(k)
    pairs = [
        (f + k, [p + c for p in u]), (k + f, [p + c for p in u]),
        (f - k, [p - c for p in u]), (k - f, [c - p for p in u]),
        (f * k, [p * c for p in u]), (k * f, [p * c for p in u]),
        (f / k, [p / c for p in u]), (np.float64(k) * f, [p * c for p in u]),
        (np.float64(k) - f, [c - p for p in u]), (np.float64(k) + f, [p + c for p in u]),
    ]  # fmt: skip
    assert all(holds(model, exact) for model, exact in pairs)
    if all(u):
        assert holds(k / f, [c / p for p in u])
        assert holds(np.float64(k) / f, [c / p for p in u])


@given(models(), st.floats(-7.0, 7.0).filter(lambda k: abs(k) > 1e-3))
def test_an_angle_of_a_model_and_a_number(a, k):
    f, u = a
    c = Decimal(k)
    with np.errstate(all="ignore"):
        above, beside = np.arctan2(f, k), np.arctan2(k, f)
    turned_back(above, [(p, c) for p in u])
    turned_back(beside, [(c, p) for p in u])


def test_what_does_not_move_is_a_number():
    f = Taylor.of(*(np.array([c]) for c in (0.7, 0.2, -0.1, 1e-3)))
    assert type(f * 0.0) is float
    assert 0.0 * f + 2.5 == 2.5
    assert (f + 0.0) is f
    assert (1.0 * f) is f


@given(models(positive=True))
def test_roots(a):
    f, u = a
    if all(p > 0 for p in u):
        with np.errstate(all="ignore"):
            assert holds(np.sqrt(f), [p.sqrt() for p in u])


@given(models())
def test_sines_and_cosines(a):
    f, u = a
    assert holds(np.sin(f), [sin(p) for p in u])
    assert holds(np.cos(f), [cos(p) for p in u])


@given(models(), models())
def test_angles(a, b):
    (y, v), (x, u) = a, b
    with np.errstate(all="ignore"):
        turned_back(np.arctan2(y, x), list(zip(v, u, strict=True)))


def turned_back(model: Taylor, pairs: list[tuple[Decimal, Decimal]]) -> None:
    """Turned back by what the model says, each point (y, x) must lie near the x axis."""
    if not finite(model):
        return
    c0, c1, c2, rem = (Decimal(float(c[0])) for c in (model.c0, model.c1, model.c2, model.rem))
    if rem >= 1:
        return
    for t, (q, p) in zip(T, pairs, strict=True):
        said = c0 + c1 * t + c2 * t * t
        across, along = q * cos(said) - p * sin(said), p * cos(said) + q * sin(said)
        assert along > 0
        assert abs(across) <= sin(rem) * (p * p + q * q).sqrt()


@given(models(), models(), st.sampled_from([0.0, 0.999, 1.0]))
def test_distances(a, b, near):
    """From 0, which the path may come near to or pass through: never without a bound."""
    (f, u), (g, v) = a, b
    k, m = near * float(f.c0[0]), near * float(g.c0[0])
    exact = [
        ((p - Decimal(k)) ** 2 + (q - Decimal(m)) ** 2).sqrt() for p, q in zip(u, v, strict=True)
    ]
    with np.errstate(all="ignore"):
        distance = np.hypot(f - k, g - m)
    assert finite(distance)
    assert holds(distance, exact)
    assert holds(np.hypot(f, k), [(p * p + Decimal(k) ** 2).sqrt() for p in u])


def test_the_remainder_shrinks_with_the_cube():
    def rem_of(r: float) -> float:
        one, zero = np.ones(1), np.zeros(1)
        x = Taylor.of(0.7 * one, r * one, zero, zero)
        y = np.sin(x) / np.sqrt(x * x + 1.0)
        return float(np.arctan2(y, 2.0 + np.cos(x)).rem[0])

    assert 0.8e-3 < rem_of(1e-3) / rem_of(1e-2) < 1.3e-3


def test_a_divisor_that_may_vanish_says_nothing():
    one, zero = np.ones(1), np.zeros(1)
    crosses = Taylor.of(0.5 * one, one, zero, zero)
    with np.errstate(all="ignore"):
        assert not finite(1.0 / crosses)
        assert not finite(np.sqrt(crosses))
        assert not finite(crosses / Taylor.of(zero, zero, zero, zero))


def test_extremes_of_the_quadratic():
    rng = np.random.default_rng(5)
    c0, c1, c2 = rng.standard_normal((3, 400))
    c2[::7] = 0.0
    model = Taylor.of(c0, c1, c2, np.zeros(400))
    t = np.linspace(-1.0, 1.0, 2001)[:, None]
    values = c0 + c1 * t + c2 * t**2
    with np.errstate(all="ignore"):
        (high, low), (t_high, t_low) = model.range(), model.extreme_places()
    assert np.all(values.max(axis=0) <= high + 1e-15)
    assert np.all(values.min(axis=0) >= low - 1e-15)
    np.testing.assert_allclose(c0 + t_high * (c1 + t_high * c2), high, atol=1e-15)
    np.testing.assert_allclose(c0 + t_low * (c1 + t_low * c2), low, atol=1e-15)


def test_a_function_without_a_rule_is_refused():
    one = np.ones(1)
    with pytest.raises(TypeError):
        np.exp(Taylor.of(one, one, one, one))
