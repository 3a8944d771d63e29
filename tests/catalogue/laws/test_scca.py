"""The SCCA law with parts of one's own."""

from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from synthesis.catalogue.laws import LAWS
from synthesis.catalogue.laws.base import characteristics
from synthesis.catalogue.laws.rest_to_rest import GeneralScca

PARTS = {
    "parabolic": (0, 1, 0),
    "simple_harmonic": (0, 0, 1),
    "cycloidal": (1 / 2, 0, 1 / 2),
    "modified_trapezoid": (1 / 4, 1 / 2, 1 / 4),
    "modified_sine": (1 / 4, 0, 3 / 4),
    "mcv50_makino": (1 / 8, 0, 3 / 8),
    "cv50_half_sine": (1 / 4, 0, 1 / 4),
    "cv50_modified_trapezoid": (1 / 8, 1 / 4, 1 / 8),
    "scca_cv20": (0.2, 0.4, 0.2),
}
part = st.one_of(st.just(0.0), st.floats(0.01, 1.0))


@pytest.mark.parametrize("kind", PARTS)
def test_named_members(kind: str) -> None:
    b, c, d = PARTS[kind]
    mine = GeneralScca(b=b, c=c, d=d)
    assert mine.curve("rise") is LAWS[kind].curve("rise")
    assert characteristics(mine) == characteristics(LAWS[kind])


@given(part, part, part, st.floats(0.05, 0.95))
def test_any_parts_give_a_law(b: float, c: float, d: float, inflection: float) -> None:
    total = b + c + d
    if total == 0.0 or min(x / total for x in (b, c, d) if x > 0) < 0.001:
        return
    if total > 1.0:
        b, c, d = b / total, c / total, d / total
    law = GeneralScca(b=b, c=c, d=d, inflection=inflection)
    curve = law.curve("rise")
    assert curve.breaks[-1] == 1.0
    assert np.all(np.diff(curve.breaks) > 0.0)
    assert abs(curve(0.0)) <= 1e-16
    assert abs(curve(1.0) - 1.0) <= 2.3e-16
    inner = curve.breaks[1:-1]
    jump = np.abs(curve.derivatives(inner, 1, "left") - curve.derivatives(inner, 1, "right"))
    assert jump.max() <= 1e-13
    assert curve(np.linspace(0, 1, 501), 1).min() >= -1e-13
    peak = characteristics(law)
    assert None not in (peak.Ca_max, peak.Ca_min)
    assert (None in (peak.Cj_max, peak.Cj_min)) == (b == 0.0 or d == 0.0)


@given(part, part, part)
def test_without_constant_velocity_the_published_peaks(b: float, c: float, d: float) -> None:
    total = b + c + d
    if total == 0.0 or min(x / total for x in (b, c, d) if x > 0) < 0.001:
        return
    b, c, d = b / total, c / total, d / total
    Ca = 4 * pi**2 / ((pi**2 - 8) * (b**2 - d**2) - 2 * pi * (pi - 2) * b + pi**2)
    peak = characteristics(GeneralScca(b=b, c=c, d=d))
    assert peak.Ca_max == pytest.approx(Ca, rel=1e-12)
    assert peak.Ca_min == pytest.approx(-Ca, rel=1e-12)
    assert peak.Cv == pytest.approx(Ca * ((b + d) / pi + c / 2), rel=1e-12)
    if b > 0.0 and d > 0.0:
        assert peak.Cj_max == pytest.approx(Ca * pi / b, rel=1e-12)
        assert peak.Cj_min == pytest.approx(-Ca * pi / d, rel=1e-12)


def test_thirds_written_as_decimals_leave_no_constant_velocity() -> None:
    third = 0.3333333
    short, full = GeneralScca(b=third, c=third, d=third), GeneralScca(b=1 / 3, c=1 / 3, d=1 / 3)
    assert short.curve("rise").breaks == pytest.approx(full.curve("rise").breaks, abs=1e-15)


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ({"b": 0.5, "c": 0.5, "d": 0.5}, "b \\+ c \\+ d = 1.5"),
        ({"b": 0.0, "c": 0.0, "d": 0.0}, "b \\+ c \\+ d = 0"),
        ({"b": 1e-9}, "b = 1e-09"),
        ({"d": -0.25}, "at least 0"),
    ],
)
def test_parts_that_do_not_fit_are_refused(parts: dict[str, float], words: str) -> None:
    with pytest.raises(ValidationError, match=words):
        GeneralScca(**parts)
