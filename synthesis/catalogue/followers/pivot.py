"""Fields that all followers on a pivot have."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated

from pydantic import Field

SENSES: Mapping[str, float] = MappingProxyType({"opposite": 1.0, "same": -1.0})
"""σ: +1 where the lifting follower turns against a ccw cam, −1 where it turns with it."""

PivotDirection = Annotated[
    float,
    Field(
        ge=-360.0,
        le=360.0,
        description="Direction of the pivot as seen from the cam's axis, 0 to the right, "
        "counter-clockwise (on a cw cam mirrored, as everything is).",
    ),
]
