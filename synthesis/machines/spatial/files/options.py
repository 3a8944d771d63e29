"""Options of files with points on a spatial cam's flanks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from synthesis.exporters.options import Decimals, Options

MAX_ROWS = 200_000

Density = Annotated[float, Field(gt=0.0, le=100.0, description="Points per degree of cam angle.")]
Count = Annotated[
    int | None,
    Field(
        ge=2,
        le=36_001,
        description="Points of every curve, evenly over the cam angle; overrides "
        "points_per_degree.",
    ),
]
Depths = Annotated[
    int,
    Field(
        ge=2,
        le=200,
        description="Curves of a flank, evenly over the roller's width; the first and the last "
        "are its edges.",
    ),
]
Flank = Annotated[
    str,
    Field(
        max_length=8,
        description="Name of one flank, as in `2R`: of roller 2, on the side towards which the "
        "follower moves as its travel grows. Left out: all flanks.",
    ),
]


@dataclass(frozen=True, kw_only=True)
class FlankOptions(Options):
    """The flanks and the sampling of their points.

    Attributes:
        flank: a wall's name; "": all. points_per_degree: over the cam angle.
        points: of a curve, instead of the density. depths: curves over the roller's width.
    """

    flank: Flank = ""
    points_per_degree: Density = 1.0
    points: Count = None
    depths: Depths = 2


@dataclass(frozen=True, kw_only=True)
class WrittenFlankOptions(FlankOptions):
    """As ``FlankOptions``, and the decimals of a point file."""

    decimals: Decimals = 10
