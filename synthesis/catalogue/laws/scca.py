"""The sine – constant – cosine – acceleration family (SCCA)."""

from __future__ import annotations

from functools import lru_cache
from math import pi
from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.laws.base import Inflection, LawEntry, RestToRest, SymmetricLaw
from synthesis.numerics.piecewise import Piecewise

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
            "Parabolic (constant acceleration)", "VDI 2143-1; Rothbart, Cams (1956)", scca(0, 1, 0)
        ),
        "simple_harmonic": LawEntry(
            "Simple harmonic", "VDI 2143-1; Rothbart, Cams (1956)", scca(0, 0, 1)
        ),
        "cycloidal": LawEntry(
            "Cycloidal (inclined sine, Bestehorn)",
            "VDI 2143-1; Norton, Cam Design and Manufacturing Handbook",
            scca(1 / 2, 0, 1 / 2),
        ),
        "modified_trapezoid": LawEntry(
            "Modified trapezoid",
            "Neklutin, Mechanisms and Cams for Automatic Machines (1969); VDI 2143-1",
            scca(1 / 4, 1 / 2, 1 / 4),
        ),
        "modified_sine": LawEntry(
            "Modified sine",
            "Schmidt, Continuous cam curves, Machine Design (1960); VDI 2143-1",
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
            "Practice of indexing cams; pulse after Neklutin (1969)",
            scca(1 / 8, 1 / 4, 1 / 8),
        ),
        "scca_cv20": LawEntry(
            "SCCA with 20 % constant velocity",
            "Practice of indexing cams; family in Norton, Cam Design and Manufacturing Handbook",
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
        "scca": LawEntry(
            "SCCA with parts b, c, d",
            "Norton, Cam Design and Manufacturing Handbook",
            scca(1 / 4, 1 / 2, 1 / 4),
        )
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
