"""Polynomial laws between two rests."""

from __future__ import annotations

from fractions import Fraction
from math import comb
from typing import ClassVar, Literal

from synthesis.catalogue.laws.base import LawEntry, RestToRest
from synthesis.numerics.piecewise import Piecewise


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
