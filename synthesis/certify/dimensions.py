"""The cam's dimensions: a follower that is driven outwards, and the ranges of the spec."""

from __future__ import annotations

import math
from typing import Final

from synthesis.catalogue.followers import Follower
from synthesis.catalogue.followers.base import paths, prime_radius
from synthesis.catalogue.followers.flank import labelled
from synthesis.catalogue.followers.kinematics import TracePoint
from synthesis.catalogue.ranges import ends
from synthesis.certify.quantities import MeasuredCam, Size, TracedPoint, pressure_angle
from synthesis.design.design import Extreme
from synthesis.spec.design_spec import DesignSpec
from synthesis.units import DEGREE

# Rounding error of a dimension computed from the size variables: a share of the prime radius, of
# 180° for an angle, of the dimension itself for one that follows from another part.
DIMENSION_ROUNDING: Final = 1e-12


def check_follower(cam: MeasuredCam) -> list[Extreme]:
    """A positive base radius, and a follower that the cam drives outwards from the prime circle.

    The pressure angle at rest on the prime circle must be below 90°. For a translating follower
    this means that its offset is less than the prime radius, with the roller above the axis; for
    one on an arm, that the arm is not in line with the centres.
    """
    follower, size, stroke = cam.machine.follower, cam.size, cam.motion.stroke
    base = follower.dimensions(size)["base_radius_mm"]
    return [
        Extreme(
            limit="base_radius_positive", value=base, unit="mm", angle_deg=0.0, bound=0.0,
            margin=base, width=0.0, holds=base > 0.0, evidence="computed from the size",
            field="base_radius_mm",
        ),
        *(
            _prime_circle_angle(labelled("prime_circle_angle", path), trace, size, stroke)
            for path, trace in paths(follower).items()
        ),
    ]  # fmt: skip


def _prime_circle_angle(limit: str, trace: TracePoint, size: Size, stroke: float) -> Extreme:
    """The pressure angle at rest where the traced curve is nearest to the axis."""
    at_rest = (trace.nearest_displacement(stroke), 0.0, 0.0, 0.0)
    alpha = abs(float(pressure_angle(TracedPoint(trace, size, at_rest)))) / DEGREE
    return Extreme(
        limit=limit, value=alpha, unit="deg", angle_deg=0.0, bound=90.0,
        margin=90.0 - alpha, width=0.0, holds=alpha < 90.0,
        evidence="pressure angle at rest on the prime circle: below 90° the cam drives the "
        "follower outwards", field="follower",
    )  # fmt: skip


def certify_size(
    spec: DesignSpec, size: tuple[float, ...], built: Follower | None = None
) -> list[Extreme]:
    """Every dimension that the spec names, against its range.

    Args:
        spec: its ``base_radius_mm`` and the ranges of its follower's dimensions.
        size: the follower's size variables [mm].
        built: the follower as built, with values chosen after the size; None: the spec's own.
    """
    dimensions = (built or spec.follower).dimensions(size)
    scales = {"mm": prime_radius(spec.follower, size), "deg": 180.0}
    owners = [(one, type(one).model_fields) for one in (spec, spec.follower)]
    found = []
    for name, value in dimensions.items():
        for (owner, fields), prefix in zip(owners, ("", "follower/"), strict=True):
            if name in fields:
                rounding = DIMENSION_ROUNDING * scales[name.rpartition("_")[2]]
                found += _in_range(name, value, ends(getattr(owner, name)), rounding, prefix + name)
    for field, (name, wanted) in spec.follower.active_closure.counter_dimensions().items():
        rounding = DIMENSION_ROUNDING * dimensions[name]
        found += _in_range(name, dimensions[name], ends(wanted), rounding, f"follower/{field}")
    return found


def _in_range(
    name: str, value: float, limits: tuple[float, float], rounding: float, field: str
) -> list[Extreme]:
    """A dimension against the nearer end of its range; no line if both ends are open."""
    low, high = limits
    limit, _, unit = name.rpartition("_")
    margin, bound = min((value - low, low), (high - value, high))
    if math.isinf(bound):
        return []
    return [
        Extreme(
            limit=limit, value=value, unit=unit, angle_deg=0.0, bound=bound,
            margin=margin, width=0.0, holds=margin >= -rounding,
            evidence=f"computed from the size; allowance for rounding {rounding:.3g} {unit}",
            field=field,
        )
    ]  # fmt: skip
