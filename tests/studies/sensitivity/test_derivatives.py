"""Derivatives of functions that are known: what is smooth, what has a corner, what disagrees."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from types import SimpleNamespace
from typing import Any

import pytest

from synthesis.studies.sensitivity.sensitivities import Derivatives, Number, describe, differentiate

AT = 3.7


@dataclass(frozen=True)
class Known:
    """A function in place of a cam; ``tangent``: what multipliers say of its slope."""

    best: Callable[[float], float | None]
    tangent: float
    method = "known"
    noise = 1e-12

    @property
    def value(self) -> float:
        found = self.best(AT)
        assert found is not None
        return found

    def estimate(self, spec: Any) -> float:
        return self.value + self.tangent * (spec.at - AT)

    def remains_optimal(self, spec: Any) -> bool:
        return self.best(spec.at) == self.value

    def solve(self, spec: Any, deadline: float) -> float | None:
        return self.best(spec.at)


NUMBER = Number("/number", AT, AT, lambda value: SimpleNamespace(at=value))


@pytest.mark.parametrize(
    ("best", "tangent", "expected"),
    [
        (lambda p: 50.0 - 2.0 * p + 0.3 * p * p, -2.0 + 0.6 * AT, (0.22, 0.22)),
        (lambda p: 50.0, 0.0, (0.0, 0.0)),
        (lambda p: 50.0 - min(p, AT), -0.4, (0.0, -1.0)),  # a corner: multipliers between
        (lambda p: 50.0 - 3.0 * p if p >= AT else None, -3.0, (-3.0, None)),
        (lambda p: 50.0 - 2.0 * p, -1.9, None),  # smooth, and multipliers say otherwise
        (lambda p: 50.0 - min(p, AT), -1.2, None),  # a corner, and multipliers outside
        (lambda p: 50.0 if p == AT else None, 1.0, None),
    ],
)
def test_slopes_of_known_functions(
    best: Callable[[float], float | None], tangent: float, expected: tuple[float, ...] | None
) -> None:
    found = differentiate(Known(best, tangent), NUMBER, inf)
    if expected is None:
        assert found is None
        return
    assert isinstance(found, Derivatives)
    for side, wanted in zip((found.more, found.less), expected, strict=True):
        assert side == (None if wanted is None else pytest.approx(wanted, rel=0.02, abs=1e-9))


def test_curvature_is_no_corner() -> None:
    # bent so that a thousandth tells the sides 5 % apart: a fifth of that step decides
    bend = 0.05 / (2e-3 * AT)
    found = differentiate(
        Known(lambda p: 50.0 + (p - AT) + 0.5 * bend * (p - AT) ** 2, 1.0), NUMBER, inf
    )
    assert found == Derivatives(pytest.approx(1.0), pytest.approx(1.0))


@pytest.mark.parametrize(("pointer", "objective", "sentence"), [
    ("/limits/0/max_n", "peak_drive_force_n",
     "1 N more in /limits/0/max_n makes peak_drive_force 2.5 N larger"),
    ("/load/moving_mass_kg", "base_radius_mm",
     "1 kg more in /load/moving_mass_kg makes base_radius 2.5 mm larger"),
    ("/load/speeds/max_rpm", "peak_drive_moment_n_m",
     "1 rpm more in /load/speeds/max_rpm makes peak_drive_moment 2.5 N m larger"),
    ("/limits/0/max_mm_per_s3", "peak_jerk_mm_per_s3",
     "1 mm/s³ more in /limits/0/max_mm_per_s3 makes peak_jerk 2.5 mm/s³ larger"),
    ("/limits/0/damping", "ratio", "1 more in /limits/0/damping makes ratio 2.5 larger"),
])  # fmt: skip
def test_units_stand_once_in_a_sentence(pointer: str, objective: str, sentence: str) -> None:
    number = Number(pointer, AT, AT, lambda _: None)
    assert describe(number, Derivatives(2.5, 2.5), objective) == sentence
