"""The cam's dimensions: physical, and inside the ranges that were asked for."""

from __future__ import annotations

import math

from synthesis.certify.quantities import Size, pressure_angle
from synthesis.design import Extreme
from synthesis.limits.base import Machine
from synthesis.ranges import ends
from synthesis.spec import DesignSpec
from synthesis.units import DEGREE

ALLOWANCE = 1e-12  # relative to the prime radius: roundings on the way from the size


def stands(machine: Machine, size: Size) -> list[Extreme]:
    """A positive base radius, and a follower that the prime circle drives outwards.

    A translating follower does so where its offset lies inside the prime radius, with the roller
    above the axis; then the pressure angle at rest on the prime circle is below 90°.
    """
    base = machine.follower.dimensions(size)["base_radius_mm"]
    alpha = abs(float(pressure_angle(machine.follower, size, (0.0, 0.0, 0.0, 0.0)))) / DEGREE
    return [
        Extreme(
            limit="base_radius_positive", value=base, unit="mm", angle_deg=0.0, bound=0.0,
            margin=base, width=0.0, holds=base > 0.0, evidence="from the size",
            field="base_radius_mm",
        ),
        Extreme(
            limit="prime_circle_angle", value=alpha, unit="deg", angle_deg=0.0, bound=90.0,
            margin=90.0 - alpha, width=0.0, holds=alpha < 90.0,
            evidence="pressure angle at rest on the prime circle: below 90° the offset lies "
            "inside the prime radius", field="follower",
        ),
    ]  # fmt: skip


def certify_size(spec: DesignSpec, size: tuple[float, ...]) -> list[Extreme]:
    """Every dimension that the spec names, against its range.

    Args:
        spec: what was asked; its ``base_radius_mm`` and the follower's dimensions.
        size: the follower's size variables [mm].
    """
    dimensions = spec.follower.dimensions(size)
    prime = spec.follower.prime_radius().value(size)
    found = []
    for name, value in dimensions.items():
        for owner, prefix in ((spec, ""), (spec.follower, "follower/")):
            if name in type(owner).model_fields:
                asked = ends(getattr(owner, name))
                found += _within(name, value, asked, ALLOWANCE * prime, prefix + name)
    return found


def _within(
    name: str, value: float, asked: tuple[float, float], allowance: float, field: str
) -> list[Extreme]:
    """A dimension against the nearer end of its range; nothing where both are open."""
    low, high = asked
    margin, bound = min((value - low, low), (high - value, high))
    if math.isinf(bound):
        return []
    return [
        Extreme(
            limit=name.removesuffix("_mm"), value=value, unit="mm", angle_deg=0.0, bound=bound,
            margin=margin, width=0.0, holds=margin >= -allowance,
            evidence=f"from the size; rounding allowance {allowance:.3g} mm", field=field,
        )
    ]  # fmt: skip
