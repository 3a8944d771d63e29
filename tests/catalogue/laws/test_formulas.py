"""The curves against formulas typed again from the literature, at unspecial points.

Derivatives of the references come from Cauchy's integral (a complex step for every order), from
exact fractions, or from integrating the reference's acceleration: never from the code under test.
"""

from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise
from math import factorial, pi, tau

import numpy as np
import pytest

from synthesis.catalogue.laws import LAWS

POINTS = np.array(
    [0.0012345, 0.0543, 0.0876543, 0.1234567, 0.1765432, 0.2345678, 0.2718281, 0.3141593, 0.3876,
     0.4321, 0.4987, 0.5123, 0.6180339, 0.6543, 0.7320508, 0.8123, 0.8765432, 0.93, 0.98765]
)  # fmt: skip
RELATIVE = 1e-12  # of the derivative's peak

# A branch formula: complex z, and the real x that chooses the branch.
Branch = Callable[[np.ndarray, float], np.ndarray]


def library(kind: str) -> np.ndarray:
    return LAWS[kind].curve("rise").derivatives(POINTS)


def assert_close(kind: str, order: int, expected: np.ndarray) -> None:
    peak = np.abs(LAWS[kind].curve("rise")(np.linspace(0, 1, 2001), order)).max()
    peak = max(peak, 1.0)  # where the derivative vanishes altogether
    worst = np.abs(library(kind)[order] - expected).max()
    assert worst <= RELATIVE * peak, f"{kind}, derivative {order}: off by {worst:.2e} of {peak:g}"


def cauchy(f: Branch, x: float, order: int, radius: float = 0.2, count: int = 64) -> float:
    turn = np.exp(1j * tau * np.arange(count) / count)
    mean = np.mean(f(x + radius * turn, x) / turn**order)
    return float(factorial(order) * mean.real / radius**order)


# --- sinusoids: displacements as in Norton's handbook, every zone measured from x = 0 -----------


def norton_scca(b: float, c: float, d: float) -> Branch:
    Ca = 4 * pi**2 / ((pi**2 - 8) * (b**2 - d**2) - 2 * pi * (pi - 2) * b + pi**2)

    def s(z: np.ndarray, x: float) -> np.ndarray:
        if x <= b / 2:
            return Ca * (b / pi * z - (b / pi) ** 2 * np.sin(pi * z / b))
        if x <= (1 - d) / 2:
            return Ca * (z**2 / 2 + b * (1 / pi - 1 / 2) * z + b**2 * (1 / 8 - 1 / pi**2))
        if x <= (1 + d) / 2:
            return Ca * (
                (b / pi + c / 2) * z + (d / pi) ** 2 + b**2 * (1 / 8 - 1 / pi**2)
                - (1 - d) ** 2 / 8 - (d / pi) ** 2 * np.cos(pi / d * (z - (1 - d) / 2))
            )  # fmt: skip
        if x <= 1 - b / 2:
            return Ca * (
                -(z**2) / 2 + (b / pi + 1 - b / 2) * z
                + (2 * d**2 - b**2) * (1 / pi**2 - 1 / 8) - 1 / 4
            )  # fmt: skip
        return Ca * (
            b / pi * z + 2 * (d**2 - b**2) / pi**2 + ((1 - b) ** 2 - d**2) / 4
            - (b / pi) ** 2 * np.sin(pi / b * (z - 1))
        )  # fmt: skip

    return s


M = 1125 / 1192
DISPLACEMENTS: dict[str, Branch] = {
    "constant_velocity": lambda z, x: z,
    "parabolic": lambda z, x: 2 * z**2 if x <= 0.5 else 1 - 2 * (1 - z) ** 2,
    "simple_harmonic": lambda z, x: (1 - np.cos(pi * z)) / 2,
    "cycloidal": lambda z, x: z - np.sin(2 * pi * z) / (2 * pi),
    "modified_trapezoid": norton_scca(0.25, 0.5, 0.25),
    "modified_sine": norton_scca(0.25, 0.0, 0.75),
    "scca": norton_scca(0.25, 0.5, 0.25),
    "gutman_1_3": lambda z, x: (
        z - 15 / (32 * pi) * np.sin(2 * pi * z) - np.sin(6 * pi * z) / (96 * pi)
    ),
    "freudenstein_1_3": lambda z, x: (
        z - (27 / 28 * np.sin(2 * pi * z) + np.sin(6 * pi * z) / 84) / (2 * pi)
    ),
    "freudenstein_1_3_5": lambda z, x: (
        z - M / tau * (np.sin(tau * z) + np.sin(3 * tau * z) / 54 + np.sin(5 * tau * z) / 1250)
    ),
    "double_harmonic": lambda z, x: ((1 - np.cos(pi * z)) - (1 - np.cos(2 * pi * z)) / 4) / 2,
}


@pytest.mark.parametrize("order", range(4))
@pytest.mark.parametrize("kind", DISPLACEMENTS)
def test_sinusoids(kind: str, order: int) -> None:
    expected = np.array([cauchy(DISPLACEMENTS[kind], x, order) for x in POINTS])
    assert_close(kind, order, expected)


def test_published_decimals_of_modified_trapezoid_and_modified_sine() -> None:
    """Displacements with the decimals that handbooks print (Norton; Erdman and Sandor)."""
    sine, trapezoid = (LAWS[kind].curve("rise") for kind in ("modified_sine", "modified_trapezoid"))
    x = 0.0876543
    assert trapezoid([x])[0] == pytest.approx(
        0.38898448 * x - 0.0309544 * np.sin(4 * pi * x), abs=2e-8
    )
    assert sine([x])[0] == pytest.approx(0.43990085 * x - 0.0350062 * np.sin(4 * pi * x), abs=2e-8)
    x = 0.6180339
    assert trapezoid([x])[0] == pytest.approx(
        1.6110154 * x - 0.0309544 * np.sin(4 * pi * x - pi) - 0.3055077, abs=2e-7
    )
    expected = 0.28004957 + 0.43990085 * x - 0.31505577 * np.cos(4 * pi * x / 3 - pi / 6)
    assert sine([x])[0] == pytest.approx(expected, abs=2e-8)


# --- polynomials: exact fractions ---------------------------------------------------------------

POLYNOMIALS: dict[str, dict[int, int | str]] = {
    "cubic_2_3": {2: 3, 3: -2},
    "polynomial_3_4_5": {3: 10, 4: -15, 5: 6},
    "polynomial_4_5_6_7": {4: 35, 5: -84, 6: 70, 7: -20},
    "polynomial_5": {3: 10, 4: -15, 5: 6},  # between rests; other ends: test_boundary_values
    "polynomial_7": {4: 35, 5: -84, 6: 70, 7: -20},
    "polynomial_5_6_7_8_9": {5: 126, 6: -420, 7: 540, 8: -315, 9: 70},
    "polynomial_6_7_8_9_10_11": {6: 462, 7: -1980, 8: 3465, 9: -3080, 10: 1386, 11: -252},
    "peisakh_11": {5: 336, 6: -1890, 7: 4740, 8: -6615, 9: 5320, 10: -2310, 11: 420},
    "polynomial_3_4_5_6": {3: 8, 4: -12, 5: 6, 6: -1},
    "kloomok_muffley_8": {
        3: "6.09755", 5: "-20.78040", 6: "26.73155", 7: "-13.60965", 8: "2.56095",
    },
}  # fmt: skip


@pytest.mark.parametrize("order", range(4))
@pytest.mark.parametrize("kind", POLYNOMIALS)
def test_polynomials(kind: str, order: int) -> None:
    terms = {k: Fraction(value) for k, value in POLYNOMIALS[kind].items() if k >= order}
    expected = [
        float(
            sum(
                value * Fraction(factorial(k), factorial(k - order)) * Fraction(x) ** (k - order)
                for k, value in terms.items()
            )
        )
        for x in POINTS.tolist()
    ]
    assert_close(kind, order, np.array(expected))


# --- constant velocity in the middle: accelerations over the first half, integrated -------------


def half_wave(ends: list[float], *formulas: Callable[[np.ndarray], np.ndarray]) -> Branch:
    """a(x) from formulas on [0, ends[0]], [ends[0], ends[1]], …, then 0; a(1 − x) = −a(x)."""

    def a(z: np.ndarray, x: float) -> np.ndarray:
        if x > 0.5:
            return -a(1 - z, 1 - x)
        for end, formula in zip(ends, formulas, strict=True):
            if x <= end:
                return formula(z)
        return 0 * z

    return a


PULSES: dict[str, tuple[list[float], Branch]] = {
    kind: (ends, half_wave(ends, *formulas))
    for kind, ends, formulas in [
        ("mcv50_makino", [1 / 16, 1 / 4],
         [lambda x: np.sin(8 * pi * x), lambda x: np.cos(8 * pi / 3 * (x - 1 / 16))]),
        ("cv50_half_sine", [1 / 4], [lambda x: np.sin(4 * pi * x)]),
        ("cv50_modified_trapezoid", [1 / 16, 3 / 16, 1 / 4],
         [lambda x: np.sin(8 * pi * x), lambda x: 1 + 0 * x,
          lambda x: np.sin(8 * pi * (1 / 4 - x))]),
        ("cv50_parabolic", [1 / 4], [lambda x: 4 * (4 * x) * (1 - 4 * x)]),
        ("cv50_haversine", [1 / 4], [lambda x: np.sin(4 * pi * x) ** 2]),
        ("scca_cv20", [0.1, 0.3, 0.4],
         [lambda x: np.sin(5 * pi * x), lambda x: 1 + 0 * x,
          lambda x: np.cos(5 * pi * (x - 0.3))]),
        ("trapezoidal_acceleration", [1 / 8, 3 / 8, 1 / 2],
         [lambda x: 8 * x, lambda x: 1 + 0 * x, lambda x: 8 * (1 / 2 - x)]),
        ("modified_trapezoid", [1 / 8, 3 / 8, 1 / 2],
         [lambda x: np.sin(4 * pi * x), lambda x: 1 + 0 * x,
          lambda x: np.cos(4 * pi * (x - 3 / 8))]),
        ("modified_sine", [1 / 8, 1 / 2],
         [lambda x: np.sin(4 * pi * x), lambda x: np.cos(4 * pi / 3 * (x - 1 / 8))]),
    ]
}  # fmt: skip


def integrals(kind: str, x: float) -> tuple[float, float]:
    """∫₀ˣ a and ∫₀ˣ (x − u) a(u) du, Gauss–Legendre with 40 points on each smooth part."""
    ends, a = PULSES[kind]
    nodes, weights = np.polynomial.legendre.leggauss(40)
    breaks = sorted({0.0, *ends, 0.5, *(1 - end for end in ends), 1.0})
    single = double = 0.0
    for low, high in pairwise(breaks):
        top = min(high, x)
        if top > low:
            u = low + (nodes + 1) * (top - low) / 2
            values = a(u, (low + high) / 2) * weights * (top - low) / 2
            single, double = single + values.sum(), double + ((x - u) * values).sum()
    return single, double


@pytest.mark.parametrize("kind", PULSES)
def test_pulses(kind: str) -> None:
    scale = 1.0 / integrals(kind, 1.0)[1]
    parts = np.array([integrals(kind, x) for x in POINTS.tolist()])
    a = PULSES[kind][1]
    assert_close(kind, 0, scale * parts[:, 1])
    assert_close(kind, 1, scale * parts[:, 0])
    assert_close(kind, 2, scale * np.array([float(a(np.array(x), x)) for x in POINTS]))
    assert_close(kind, 3, scale * np.array([cauchy(a, x, 1) for x in POINTS]))


def test_every_law_has_a_reference() -> None:
    assert set(DISPLACEMENTS) | set(POLYNOMIALS) | set(PULSES) == set(LAWS)
