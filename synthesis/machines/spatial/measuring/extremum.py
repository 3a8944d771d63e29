"""Quantities, their extrema and bounds, and the form of an extremum on the wire."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from synthesis.machines.spatial.cam import Wall
from synthesis.machines.spatial.design import SpatialExtreme
from synthesis.units import DEGREE


@dataclass(frozen=True)
class Bound:
    """An allowed value.

    Attributes:
        value: in the quantity's unit on the wire. field: of the spec, that sets it; "": none.
    """

    value: float
    field: str = ""


Bounds = Mapping[str, Bound]


@dataclass(frozen=True)
class Quantity:
    """A quantity and which of its extremes is measured.

    Attributes:
        name, unit: on the wire. largest: whether its maximum is measured, otherwise its minimum.
        to_wire: from the core's value to the wire's. from_wire: the inverse.
        required: bound that every cam must keep, whatever the spec says.
    """

    name: str
    unit: str
    largest: bool
    to_wire: Callable[[float], float] = float
    from_wire: Callable[[float], float] = float
    required: Bound | None = None


@dataclass(frozen=True)
class Extremum:
    """An extreme value [core units].

    Attributes:
        value: infinite where there is none.
        limit: the true extreme does not lie beyond it, as far as the evidence goes.
        evidence: how that is known.
        theta: where [rad]. wall, rho: on which wall, and where on the roller's axis [mm]; None: the
            quantity does not belong to a wall.
    """

    value: float
    limit: float
    evidence: str
    theta: float | None = None
    wall: Wall | None = None
    rho: float | None = None


def rounded(value: float) -> float:
    """A value to twelve digits: of two that differ by rounding only, the first one is chosen."""
    return float(f"{value:.11e}")


def to_wire(quantity: Quantity, extremum: Extremum, bounds: Bounds) -> SpatialExtreme:
    """An extremum on the wire, against its bound."""
    value, limit = quantity.to_wire(extremum.value), quantity.to_wire(extremum.limit)
    finite = math.isfinite(value)
    width = abs(limit - value) if finite and math.isfinite(limit) else 0.0
    bound = bounds.get(quantity.name, quantity.required)
    margin = None
    if bound is not None and finite:
        margin = bound.value - value if quantity.largest else value - bound.value
    if bound is None:
        holds = True
    elif margin is None:  # the minimum of nothing is +∞ and keeps every bound, the maximum −∞
        holds = value == (-math.inf if quantity.largest else math.inf)
    else:
        holds = margin >= width
    wall = extremum.wall
    return SpatialExtreme(
        quantity=quantity.name,
        value=value if finite else None,
        unit=quantity.unit,
        angle_deg=None if extremum.theta is None else extremum.theta / DEGREE,
        roller=None if wall is None else wall.seat.number,
        side=None if wall is None else wall.letter,
        rho_mm=extremum.rho,
        bound=None if bound is None else bound.value,
        margin=margin,
        width=width,
        holds=holds,
        evidence=extremum.evidence,
        field="" if bound is None else bound.field,
    )
