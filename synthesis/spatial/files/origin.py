"""What every file that can hold it says of the cam that it is of."""

from __future__ import annotations

from typing import Any

from synthesis.spatial.design import SpatialDesign


def origin(design: SpatialDesign) -> dict[str, Any]:
    """Which cam a file is of, and what it is worth."""
    return {
        "id": design.id,
        "name": design.name,
        "engine_version": design.engine_version,
        "status": design.status,
        "machine": design.machine,
        "dimensions": design.dimensions,
        "rotation": design.rotation,
        "speed_rpm": design.speed_rpm,
    }
