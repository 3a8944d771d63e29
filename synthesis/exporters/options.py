"""What a caller may choose about a file, and what makes sense."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args

from synthesis.errors import InputError
from synthesis.exporters.theme import THEMES, Theme
from synthesis.findings import Sensitivities

CurveName = Literal["profile", "pitch", "inner", "outer", "main", "counter", "counter_pitch"]

MAX_POINTS_PER_DEGREE = 1000.0
CURVES: tuple[CurveName, ...] = get_args(CurveName)


def _check_density(points_per_degree: float) -> None:
    if not 0.0 < points_per_degree <= MAX_POINTS_PER_DEGREE:
        raise InputError(
            "/points_per_degree",
            points_per_degree,
            f"The density must be above 0 and at most {MAX_POINTS_PER_DEGREE:g} points per degree.",
            "Leave it out, or give a number such as 4.",
        )


def _check_theme(theme: str) -> None:
    if theme not in THEMES:
        raise InputError(
            "/theme", theme, f"The theme must be one of {', '.join(THEMES)}.", "Leave it out."
        )


@dataclass(frozen=True)
class ProfileOptions:
    """How the cam's curve is sampled.

    Attributes:
        points_per_degree: density, uniform in cam angle; not below one point in 10°.
        tolerance_um: if given, it decides instead of the density: no chord between neighbouring
            points departs further than this from the true curve [µm].
        curve: the profile, or the pitch curve (path of the roller's centre). A groove has an inner
            and an outer profile, conjugate cams a main and a counter one; of these `profile` is
            the first.
        turn_deg: angle by which points are turned about the cam's axis, counter-clockwise
            positive: the cam as it sits on a shaft with others.
        z_mm: position along that axis; None leaves tables without z, and is 0 in point files.
        theme: colours of the drawing.
    """

    points_per_degree: float = 4.0
    tolerance_um: float | None = None
    curve: CurveName = "profile"
    turn_deg: float = 0.0
    z_mm: float | None = None
    theme: Theme = "auto"

    def __post_init__(self) -> None:
        _check_density(self.points_per_degree)
        if self.tolerance_um is not None and not 0.0 < self.tolerance_um < math.inf:
            raise InputError(
                "/tolerance_um",
                self.tolerance_um,
                "The chord tolerance must be a positive number of micrometres.",
                "Leave it out to sample by points_per_degree, or give a number such as 1.",
            )
        if self.curve not in CURVES:
            raise InputError(
                "/curve",
                self.curve,
                f"The curve must be one of {', '.join(CURVES)}.",
                "Leave it out for the profile.",
            )
        for field, value in (("/turn_deg", self.turn_deg), ("/z_mm", self.z_mm or 0.0)):
            if not math.isfinite(value):
                raise InputError(field, value, "This must be a finite number.", "Leave it out.")
        _check_theme(self.theme)


@dataclass(frozen=True)
class MotionOptions:
    """How the motion is sampled.

    Attributes:
        points_per_degree: density, uniform in cam angle; not below one point in 10°.
        theme: colours of the diagrams.
    """

    points_per_degree: float = 1.0
    theme: Theme = "auto"

    def __post_init__(self) -> None:
        _check_density(self.points_per_degree)
        _check_theme(self.theme)


@dataclass(frozen=True)
class PictureOptions:
    """How a picture looks.

    Attributes:
        theme: its colours.
        sensitivities: what each limit costs, for a report that tells it.
    """

    theme: Theme = "auto"
    sensitivities: Sensitivities | None = None

    def __post_init__(self) -> None:
        _check_theme(self.theme)
