"""Laws between two rests: polynomials, straight lines with pulses, and odd harmonics.

Each is given by its first half. The family of sine, constant and cosine parts is in ``scca``.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from math import comb, pi
from typing import ClassVar, Literal

from synthesis.catalogue.laws.base import LawEntry, RestToRest
from synthesis.numerics.piecewise import Piecewise

# -- polynomials ---------------------------------------------------------------------------------


def powers(first: int, *coefficients: int) -> Piecewise:
    """First half of s = c₀ x^first + c₁ x^(first+1) + …"""
    return about_both_ends([Fraction(c) for c in (*[0] * first, *coefficients)], Fraction(1, 2))


def about_both_ends(coefficients: list[Fraction], end: Fraction) -> Piecewise:
    """Σ c_k x^k on [0, end], the last half of it in powers of x − end.

    The terms of a law of degree 11 are a thousand times its value at the far end; written about
    that end, where the shift in fractions is exact, nothing is lost.
    """
    degree = len(coefficients)
    shifted = [
        float(sum(coefficients[k] * comb(k, j) * end ** (k - j) for k in range(j, degree)))
        for j in range(degree)
    ]
    about_zero = [float(coefficient) for coefficient in coefficients]
    breaks = [0.0, float(end / 2), float(end)]
    return Piecewise.of(breaks, [about_zero, shifted], origins=[0.0, float(end)])


# a = (16/3) 8x up to x = 1/8, then 16/3, then (16/3) 8(1/2 − x) from x = 3/8 on
TRAPEZOID = Piecewise.of(
    [0.0, 1 / 8, 3 / 8, 1 / 2],
    [[0.0, 0.0, 0.0, 64 / 9], [1 / 72, 1 / 3, 8 / 3], [1 / 2, 2.0, 0.0, -64 / 9]],
    origins=[0.0, 1 / 8, 1 / 2],
)


class Polynomial(RestToRest):
    """One polynomial over the whole segment, named after its powers; or pieces of polynomials.

    | kind | from | coefficients |
    |---|---|---|
    | `cubic_2_3` | x² | 3, −2 |
    | `polynomial_3_4_5` | x³ | 10, −15, 6 (least mean square jerk) |
    | `polynomial_4_5_6_7` | x⁴ | 35, −84, 70, −20 (jerk continuous) |
    | `polynomial_5_6_7_8_9` | x⁵ | 126, −420, 540, −315, 70 |
    | `polynomial_6_7_8_9_10_11` | x⁶ | 462, −1980, 3465, −3080, 1386, −252 |
    | `peisakh_11` | x⁵ | 336, −1890, 4740, −6615, 5320, −2310, 420 |
    | `trapezoidal_acceleration` | pieces | a grows over 1/8, stays over 1/4, falls over 1/8 |
    """

    kind: Literal[
        "cubic_2_3",
        "polynomial_3_4_5",
        "polynomial_4_5_6_7",
        "polynomial_5_6_7_8_9",
        "polynomial_6_7_8_9_10_11",
        "peisakh_11",
        "trapezoidal_acceleration",
    ]
    entries: ClassVar = {
        "cubic_2_3": LawEntry(
            "Cubic 2-3 (constant negative jerk)", "Rothbart, Cams (1956)", powers(2, 3, -2)
        ),
        "polynomial_3_4_5": LawEntry(
            "3-4-5 polynomial", "VDI 2143-1 (polynomial of degree 5)", powers(3, 10, -15, 6)
        ),
        "polynomial_4_5_6_7": LawEntry(
            "4-5-6-7 polynomial",
            "Norton, Cam Design and Manufacturing Handbook",
            powers(4, 35, -84, 70, -20),
        ),
        "polynomial_5_6_7_8_9": LawEntry(
            "5-6-7-8-9 polynomial",
            "Cam Design Handbook (Rothbart, ed., 2004), polynomial curves",
            powers(5, 126, -420, 540, -315, 70),
        ),
        "polynomial_6_7_8_9_10_11": LawEntry(
            "6-7-8-9-10-11 polynomial",
            "Cam Design Handbook (Rothbart, ed., 2004), polynomial curves",
            powers(6, 462, -1980, 3465, -3080, 1386, -252),
        ),
        "peisakh_11": LawEntry(
            "Peisakh, 11th degree",
            "Peisakh, Improving the polydyne cam design method, Russian Eng. J. 46 (1966)",
            powers(5, 336, -1890, 4740, -6615, 5320, -2310, 420),
        ),
        "trapezoidal_acceleration": LawEntry(
            "Trapezoidal acceleration (ramps of 1/8)",
            "Neklutin, Mechanisms and Cams for Automatic Machines (1969); Rothbart, Cams (1956)",
            TRAPEZOID,
        ),
    }


# -- straight lines with pulses -------------------------------------------------------------------

LINE = Piecewise.of([0.0, 0.5], [[0.0, 1.0]])
# a = 32 u(1 − u) with u = 4x up to x = 1/4, then the velocity is 4/3
PARABOLIC = Piecewise.of(
    [0.0, 0.25, 0.5], [[0.0, 0.0, 0.0, 64 / 3, -128 / 3], [0.5, 4 / 3]], origins=[0.0, 0.5]
)
# a = (32/3) sin²(4πx) = (16/3)(1 − cos 8πx) up to x = 1/4, then the velocity is 4/3
_HAVERSINE = 1.0 / (12.0 * pi**2)
HAVERSINE = Piecewise.of(
    [0.0, 0.25, 0.5],
    [[-_HAVERSINE, 0.0, 8 / 3], [0.5, 4 / 3]],
    [[(_HAVERSINE, 8.0 * pi, pi / 2.0)], []],
    [0.0, 0.5],
)


class ConstantVelocity(RestToRest):
    """Constant velocity: over the whole segment, or over its middle half (CV50).

    | kind | acceleration over the first quarter, u = 4x |
    |---|---|
    | `constant_velocity` | none: the velocity jumps at both ends, `inflection` has no effect |
    | `cv50_parabolic` | 32 u(1 − u) |
    | `cv50_haversine` | (32/3) sin²(πu): the jerk is continuous too |

    `cv50_half_sine`, `cv50_modified_trapezoid` and `mcv50_makino` are members of the SCCA family.
    """

    kind: Literal["constant_velocity", "cv50_parabolic", "cv50_haversine"]
    entries: ClassVar = {
        "constant_velocity": LawEntry("Constant velocity", "VDI 2143-1 (straight line)", LINE),
        "cv50_parabolic": LawEntry(
            "Constant velocity 50 %, parabolic pulses", "Practice of indexing cams", PARABOLIC
        ),
        "cv50_haversine": LawEntry(
            "Constant velocity 50 %, haversine pulses", "Practice of indexing cams", HAVERSINE
        ),
    }


# -- odd harmonics -------------------------------------------------------------------------------

M = 1125 / 1192  # makes the mean velocity 1 with Freudenstein's ratios 1 : 1/54 : 1/1250


def harmonics(weights: Mapping[int, float]) -> Piecewise:
    """First half of s = x − (1/2π) Σ_k weight_k sin(2πkx)."""
    waves = [(-weight / (2.0 * pi), 2.0 * pi * k, 0.0) for k, weight in weights.items()]
    return Piecewise.of([0.0, 0.5], [[0.0, 1.0]], [waves])


class HarmonicSeries(RestToRest):
    """s = x − (1/2π) Σ m_k sin(2πkx): the cycloidal law with third and fifth harmonics.

    They lower the peak acceleration of the cycloidal law and keep the spectrum of the motion
    narrow, so that the follower train is little excited at high speed.

    | kind | m₁ | m₃ | m₅ |
    |---|---|---|---|
    | `gutman_1_3` | 15/16 | 1/48 | |
    | `freudenstein_1_3` | 27/28 | 1/84 | |
    | `freudenstein_1_3_5` | 1125/1192 | m₁/54 | m₁/1250 |
    """

    kind: Literal["gutman_1_3", "freudenstein_1_3", "freudenstein_1_3_5"]
    entries: ClassVar = {
        "gutman_1_3": LawEntry(
            "Gutman 1-3",
            "Gutman, To avoid vibration try this new cam profile, Product Engineering (1961)",
            harmonics({1: 15 / 16, 3: 1 / 48}),
        ),
        "freudenstein_1_3": LawEntry(
            "Freudenstein 1-3",
            "Freudenstein, On the dynamics of high-speed cam profiles, Int. J. Mech. Sci. 1 (1960)",
            harmonics({1: 27 / 28, 3: 1 / 84}),
        ),
        "freudenstein_1_3_5": LawEntry(
            "Freudenstein 1-3-5",
            "Freudenstein, On the dynamics of high-speed cam profiles, Int. J. Mech. Sci. 1 (1960)",
            harmonics({1: M, 3: M / 54, 5: M / 1250}),
        ),
    }
