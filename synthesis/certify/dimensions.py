"""The cam's dimensions: physical, and inside the ranges that were asked for."""

from __future__ import annotations

import math

from synthesis.certify.course import Course
from synthesis.certify.quantities import Sight, Size, pressure_angle
from synthesis.design import Extreme
from synthesis.followers import Follower
from synthesis.followers.flank import labelled
from synthesis.followers.trace import Trace
from synthesis.limits.base import Claim, Machine, where
from synthesis.motion import Motion
from synthesis.ranges import ends
from synthesis.spec import DesignSpec
from synthesis.units import DEGREE

ALLOWANCE = 1e-12  # of the prime radius, or of 180°: roundings on the way from the size


def stands(course: Course, machine: Machine, size: Size) -> list[Extreme]:
    """A positive base radius, and a follower that the prime circle drives outwards.

    A translating follower does so where its offset lies inside the prime radius, with the roller
    above the axis; one on an arm, where the arm is not stretched along the line of centres. Then
    the pressure angle at rest on the prime circle is below 90°.
    """
    base = machine.follower.dimensions(size)["base_radius_mm"]
    return [
        Extreme(
            limit="base_radius_positive", value=base, unit="mm", angle_deg=0.0, bound=0.0,
            margin=base, width=0.0, holds=base > 0.0, evidence="from the size",
            field="base_radius_mm",
        ),
        *(
            _at_rest(labelled("prime_circle_angle", path), trace, size, course.stroke)
            for path, trace in machine.follower.paths.items()
        ),
    ]  # fmt: skip


def _at_rest(limit: str, trace: Trace, size: Size, stroke: float) -> Extreme:
    """The pressure angle at rest where the traced curve is nearest to the axis."""
    still = (trace.nearest(stroke), 0.0, 0.0, 0.0)
    alpha = abs(float(pressure_angle(Sight(trace, size, still)))) / DEGREE
    return Extreme(
        limit=limit, value=alpha, unit="deg", angle_deg=0.0, bound=90.0,
        margin=90.0 - alpha, width=0.0, holds=alpha < 90.0,
        evidence="pressure angle at rest on the prime circle: below 90° the cam drives the "
        "follower outwards", field="follower",
    )  # fmt: skip


def standing(motion: Motion, machine: Machine, size: Size) -> list[Claim]:
    """That the follower can stand at every displacement, where that is not so by itself."""
    found = machine.follower.displacement_measure(size)
    if found is None:
        return []
    return [
        Claim(
            "reach", found.quantity, where(motion.stretches), found.lower, found.upper,
            found.unit, found.to_wire, "follower",
        )
    ]  # fmt: skip


def certify_size(
    spec: DesignSpec, size: tuple[float, ...], built: Follower | None = None
) -> list[Extreme]:
    """Every dimension that the spec names, against its range.

    Args:
        spec: what was asked; its ``base_radius_mm`` and the follower's dimensions.
        size: the follower's size variables [mm].
        built: the follower with what was settled after the size; None: the spec's own.
    """
    dimensions = (built or spec.follower).dimensions(size)
    sizes = {"mm": spec.follower.radius(size), "deg": 180.0}
    owners = [(one, type(one).model_fields) for one in (spec, spec.follower)]
    found = []
    for name, value in dimensions.items():
        for (owner, fields), prefix in zip(owners, ("", "follower/"), strict=True):
            if name in fields:
                asked = ends(getattr(owner, name))
                allowance = ALLOWANCE * sizes[name.rpartition("_")[2]]
                found += _within(name, value, asked, allowance, prefix + name)
    for field, (name, wanted) in spec.follower.companion_ranges().items():
        allowance = ALLOWANCE * dimensions[name]
        found += _within(name, dimensions[name], ends(wanted), allowance, f"follower/{field}")
    return found


def _within(
    name: str, value: float, asked: tuple[float, float], allowance: float, field: str
) -> list[Extreme]:
    """A dimension against the nearer end of its range; nothing where both are open."""
    low, high = asked
    named, _, unit = name.rpartition("_")
    margin, bound = min((value - low, low), (high - value, high))
    if math.isinf(bound):
        return []
    return [
        Extreme(
            limit=named, value=value, unit=unit, angle_deg=0.0, bound=bound,
            margin=margin, width=0.0, holds=margin >= -allowance,
            evidence=f"from the size; rounding allowance {allowance:.3g} {unit}", field=field,
        )
    ]  # fmt: skip
