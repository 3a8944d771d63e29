"""The straight line, and straight lines entered and left by pulses outside the SCCA family."""

from __future__ import annotations

from math import pi
from typing import ClassVar, Literal

from synthesis.catalogue.laws.base import LawEntry, RestToRest
from synthesis.numerics.piecewise import Piecewise

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
