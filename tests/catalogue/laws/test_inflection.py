"""Laws whose inflection is moved off the middle."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from synthesis.catalogue.laws import LAWS, MotionLaw
from synthesis.catalogue.laws.base import characteristics
from synthesis.catalogue.motion import Motion
from synthesis.spec.program import Return
from synthesis.units import CORE_UNITS

REST = sorted(kind for kind, law in LAWS.items() if "inflection" in type(law).model_fields)
X = np.array([0.0123, 0.0987, 0.1234567, 0.2345, 0.3141593, 0.4567, 0.55, 0.6789, 0.8765, 0.9876])

lambdas = pytest.mark.parametrize("inflection", [0.05, 0.3, 0.4321, 0.7, 0.95])
every_rest_law = pytest.mark.parametrize("kind", REST)


def asymmetric(kind: str, inflection: float) -> MotionLaw:
    return type(LAWS[kind]).model_validate({"kind": kind, "inflection": inflection})


@every_rest_law
@lambdas
def test_follows_the_formula(kind: str, inflection: float) -> None:
    """s = 2λ f(x/2λ) for x ≤ λ, else 1 − 2(1−λ) f((1−x)/2(1−λ)), and its derivatives."""
    f = LAWS[kind].curve("rise")
    curve = asymmetric(kind, inflection).curve("rise")
    before = inflection >= X
    a, b = 2 * inflection, 2 * (1 - inflection)
    for order in range(4):
        first = a ** (1 - order) * f(np.minimum(X / a, 0.5), order, "left")
        last = (
            b ** (1 - order) * (-1) ** (order + 1) * f(np.minimum((1 - X) / b, 0.5), order, "left")
        )
        expected = np.where(before, first, last + (order == 0))
        scale = np.abs(f(np.linspace(0, 1, 999), order)).max() * min(a, b) ** (1 - order)
        assert np.abs(curve(X, order) - expected).max() <= 1e-12 * max(scale, 1.0)


@every_rest_law
@lambdas
def test_one_smooth_move(kind: str, inflection: float) -> None:
    law = asymmetric(kind, inflection)
    curve = law.curve("rise")
    assert curve.breaks[0] == 0.0
    assert curve.breaks[-1] == 1.0
    assert inflection in curve.breaks
    assert abs(curve(0.0)) <= 1e-16
    assert abs(curve(1.0) - 1.0) <= 2.3e-16
    left, right = (curve.derivatives([inflection], 2, side)[:, 0] for side in ("left", "right"))
    assert np.abs(left[:2] - right[:2]).max() <= 1e-14
    if kind != "parabolic":
        assert abs(left[2] - right[2]) <= 1e-12
    assert curve(np.linspace(0, 1, 2001), 1).min() >= -1e-14


@every_rest_law
@lambdas
def test_peaks_scale(kind: str, inflection: float) -> None:
    even, odd = characteristics(LAWS[kind]), characteristics(asymmetric(kind, inflection))
    assert odd.Cv == pytest.approx(even.Cv, rel=1e-12)
    if even.Ca_max is None or even.Ca_min is None:
        assert odd.Ca_max is None
        assert odd.Ca_min is None
    else:
        assert odd.Ca_max == pytest.approx(even.Ca_max / (2 * inflection), rel=1e-12)
        assert odd.Ca_min == pytest.approx(even.Ca_min / (2 - 2 * inflection), rel=1e-12)
    assert (None in (odd.Cj_max, odd.Cj_min)) == (None in (even.Cj_max, even.Cj_min))


def test_a_return_counts_from_its_own_start() -> None:
    """The follower falls fastest at λ of the segment, 0.3 · 80° after the return begins."""
    law = asymmetric("cycloidal", 0.3)
    angle = np.deg2rad(80.0)
    fall = Return(angle_deg=80.0, lift_mm=12.0, law=law).place(0, 0.0, angle, 12.0, CORE_UNITS)
    theta = np.linspace(0.0, angle, 8001)
    s, v = Motion.of([fall]).derivatives(theta, 1)
    assert theta[np.argmin(v)] == pytest.approx(0.3 * angle, abs=1e-3)
    assert s[0] == 12.0
    assert abs(s[-1]) <= 1e-14


@given(st.floats(0.05, 0.95), st.sampled_from(REST))
def test_ends_are_exact_at_any_inflection(inflection: float, kind: str) -> None:
    curve = asymmetric(kind, inflection).curve("return")
    assert curve.breaks[0] == 0.0
    assert curve.breaks[-1] == 1.0
    assert np.all(np.diff(curve.breaks) > 0.0)
    assert abs(curve(0.0)) <= 1e-16
    assert abs(curve(1.0) - 1.0) <= 2.3e-16
    assert curve(inflection) == pytest.approx(inflection, abs=4e-16)
