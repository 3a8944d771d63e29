"""Laws between two rests, each given by its first half.

Polynomials; straight lines with pulses; odd harmonics; sine, constant and cosine parts (SCCA).
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from functools import lru_cache
from math import comb, pi
from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.laws.base import Inflection, LawEntry, RestToRest, SymmetricLaw
from synthesis.numerics.piecewise import Piecewise

VDI = "VDI 2143-1"
ROTHBART = "Rothbart, Cams (1956)"
NORTON = "Norton, Cam Design and Manufacturing Handbook"
NEKLUTIN = "Neklutin, Mechanisms and Cams for Automatic Machines (1969)"
HANDBOOK = "Cam Design Handbook (Rothbart, ed., 2004), polynomial curves"
FREUDENSTEIN = (
    "Freudenstein, On the dynamics of high-speed cam profiles, Int. J. Mech. Sci. 1 (1960)"
)
INDEXING = "Practice of indexing cams"


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
        "cubic_2_3": LawEntry("Cubic 2-3 (constant negative jerk)", ROTHBART, powers(2, 3, -2)),
        "polynomial_3_4_5": LawEntry(
            "3-4-5 polynomial", "VDI 2143-1 (polynomial of degree 5)", powers(3, 10, -15, 6)
        ),
        "polynomial_4_5_6_7": LawEntry("4-5-6-7 polynomial", NORTON, powers(4, 35, -84, 70, -20)),
        "polynomial_5_6_7_8_9": LawEntry(
            "5-6-7-8-9 polynomial", HANDBOOK, powers(5, 126, -420, 540, -315, 70)
        ),
        "polynomial_6_7_8_9_10_11": LawEntry(
            "6-7-8-9-10-11 polynomial", HANDBOOK, powers(6, 462, -1980, 3465, -3080, 1386, -252)
        ),
        "peisakh_11": LawEntry(
            "Peisakh, 11th degree",
            "Peisakh, Improving the polydyne cam design method, Russian Eng. J. 46 (1966)",
            powers(5, 336, -1890, 4740, -6615, 5320, -2310, 420),
        ),
        "trapezoidal_acceleration": LawEntry(
            "Trapezoidal acceleration (ramps of 1/8)", f"{NEKLUTIN}; {ROTHBART}", TRAPEZOID
        ),
    }


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
        "cv50_parabolic": LawEntry("Constant velocity 50 %, parabolic pulses", INDEXING, PARABOLIC),
        "cv50_haversine": LawEntry("Constant velocity 50 %, haversine pulses", INDEXING, HAVERSINE),
    }


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
            "Freudenstein 1-3", FREUDENSTEIN, harmonics({1: 27 / 28, 3: 1 / 84})
        ),
        "freudenstein_1_3_5": LawEntry(
            "Freudenstein 1-3-5", FREUDENSTEIN, harmonics({1: M, 3: M / 54, 5: M / 1250})
        ),
    }


LEAST_PART = 1e-3  # of the segment: a shorter part would be a jump for every machine
WHOLE_TOLERANCE = 1e-6  # of the segment: parts given as decimals fill it up to this


@lru_cache(maxsize=256)
def scca(b: float, c: float, d: float) -> Piecewise:
    """First half of the law whose acceleration runs b/2 sine, c/2 constant, d/2 cosine, then 0.

    Each piece is written about the point where its sinusoid vanishes, so no phase is needed and
    zero accelerations and jerks come out as exact zeros.
    """
    if b + c + d > 1.0 - WHOLE_TOLERANCE:  # thirds written as decimals leave no constant velocity
        b, c, d = (part / (b + c + d) for part in (b, c, d))
        flat, zero = 0.0, 0.5
    else:
        flat, zero = 1.0 - b - c - d, (b + c + d) / 2.0
    # displacement and velocity at the ends of the pieces, under unit acceleration
    s1, v1 = (b / pi) ** 2 * (pi / 2.0 - 1.0), b / pi
    s2, v2 = s1 + v1 * c / 2.0 + c**2 / 8.0, v1 + c / 2.0
    s3, v3 = s2 + v2 * d / 2.0 + (d / pi) ** 2, v2 + d / pi
    peak = 0.5 / (s3 + v3 * flat / 2.0)
    pieces = [
        (b / 2.0, 0.0, [0.0, peak * v1], [(-peak * (b / pi) ** 2, pi / b)] if b else []),
        ((b + c) / 2.0, b / 2.0, [peak * s1, peak * v1, peak / 2.0], []),
        (zero, zero, [peak * s3, peak * v2], [(peak * (d / pi) ** 2, pi / d)] if d else []),
        (0.5, 0.5, [0.5, peak * v3], []),
    ]
    kept = [piece for piece, part in zip(pieces, (b, c, d, flat), strict=True) if part > 0.0]
    return Piecewise.of(
        [0.0, *(end for end, *_ in kept[:-1]), 0.5],
        [poly for _, _, poly, _ in kept],
        [[(amplitude, w, 0.0) for amplitude, w in waves] for *_, waves in kept],
        [origin for _, origin, _, _ in kept],
    )


class Scca(RestToRest):
    """Acceleration of sine, constant and cosine parts (the SCCA family).

    The acceleration rises as a quarter of a sine over b/2 of the segment, stays constant over
    c/2, falls as a quarter of a cosine over d/2, and the second half of the segment mirrors the
    first. What is left, 1 − b − c − d, runs at constant velocity in the middle.

    | kind | b | c | d |
    |---|---|---|---|
    | `parabolic` | 0 | 1 | 0 |
    | `simple_harmonic` | 0 | 0 | 1 |
    | `cycloidal` | 1/2 | 0 | 1/2 |
    | `modified_trapezoid` | 1/4 | 1/2 | 1/4 |
    | `modified_sine` | 1/4 | 0 | 3/4 |
    | `mcv50_makino` | 1/8 | 0 | 3/8 |
    | `cv50_half_sine` | 1/4 | 0 | 1/4 |
    | `cv50_modified_trapezoid` | 1/8 | 1/4 | 1/8 |
    | `scca_cv20` | 0.2 | 0.4 | 0.2 |

    Several different laws are sold as "CV50" or "modified constant velocity": compare the peak
    values in `/v1/motion-laws` before replacing an existing cam.
    """

    kind: Literal[
        "parabolic",
        "simple_harmonic",
        "cycloidal",
        "modified_trapezoid",
        "modified_sine",
        "mcv50_makino",
        "cv50_half_sine",
        "cv50_modified_trapezoid",
        "scca_cv20",
    ]
    entries: ClassVar = {
        "parabolic": LawEntry(
            "Parabolic (constant acceleration)", f"{VDI}; {ROTHBART}", scca(0, 1, 0)
        ),
        "simple_harmonic": LawEntry("Simple harmonic", f"{VDI}; {ROTHBART}", scca(0, 0, 1)),
        "cycloidal": LawEntry(
            "Cycloidal (inclined sine, Bestehorn)", f"{VDI}; {NORTON}", scca(1 / 2, 0, 1 / 2)
        ),
        "modified_trapezoid": LawEntry(
            "Modified trapezoid", f"{NEKLUTIN}; {VDI}", scca(1 / 4, 1 / 2, 1 / 4)
        ),
        "modified_sine": LawEntry(
            "Modified sine",
            f"Schmidt, Continuous cam curves, Machine Design (1960); {VDI}",
            scca(1 / 4, 0, 3 / 4),
        ),
        "mcv50_makino": LawEntry(
            "Modified constant velocity 50 % (Makino MCV50)",
            "Makino, Kinematics of Automatic Machinery (1976)",
            scca(1 / 8, 0, 3 / 8),
        ),
        "cv50_half_sine": LawEntry(
            "Constant velocity 50 %, half-sine pulses",
            "Practice of cylindrical and globoidal indexing cams",
            scca(1 / 4, 0, 1 / 4),
        ),
        "cv50_modified_trapezoid": LawEntry(
            "Constant velocity 50 %, modified-trapezoid pulses",
            f"{INDEXING}; pulse after Neklutin (1969)",
            scca(1 / 8, 1 / 4, 1 / 8),
        ),
        "scca_cv20": LawEntry(
            "SCCA with 20 % constant velocity",
            f"{INDEXING}; family in Norton, Cam Design and Manufacturing Handbook",
            scca(0.2, 0.4, 0.2),
        ),
    }


Part = Annotated[float, Field(ge=0.0, le=1.0)]


class GeneralScca(SymmetricLaw):
    """SCCA law with parts of your own: sine b, constant c, cosine d; the rest constant velocity.

    Every part is a fraction of the segment, half of it on either side of the middle:
    b + c + d ≤ 1. b = 0 or d = 0 makes the acceleration jump, which an infinite jerk reports.
    """

    kind: Literal["scca"] = "scca"
    b: Part = Field(0.25, description="Sine part, where the jerk is large: 0 or ≥ 0.001.")
    c: Part = Field(0.5, description="Constant-acceleration part: 0 or ≥ 0.001.")
    d: Part = Field(0.25, description="Cosine part around the middle: 0 or ≥ 0.001.")
    inflection: Inflection = 0.5

    entries: ClassVar = {
        "scca": LawEntry("SCCA with parts b, c, d", NORTON, scca(1 / 4, 1 / 2, 1 / 4))
    }

    @model_validator(mode="after")
    def _parts_fit(self) -> GeneralScca:
        for name, part in (("b", self.b), ("c", self.c), ("d", self.d)):
            if 0.0 < part < LEAST_PART:
                raise PydanticCustomError(
                    "scca_part_too_small",
                    "{name} = {part} is shorter than {least} of the segment. "
                    "Make it 0, or at least {least}.",
                    {"name": name, "part": part, "least": LEAST_PART},
                )
        total = self.b + self.c + self.d
        if not 0.0 < total <= 1.0 + WHOLE_TOLERANCE:
            raise PydanticCustomError(
                "scca_parts",
                "b + c + d = {total} is not above 0 and at most 1. "
                "Scale the parts down; what they leave runs at constant velocity.",
                {"total": total},
            )
        return self

    @property
    def half(self) -> Piecewise:
        return scca(self.b, self.c, self.d)
