"""An extreme as it was found, and how it is told."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from synthesis.spatial.cam import Wall
from synthesis.spatial.design import SpatialExtreme
from synthesis.units import DEGREE


@dataclass(frozen=True)
class Bound:
    """What a quantity may not pass.

    Attributes:
        value: in the quantity's unit on the wire. field: of the spec, that sets it.
    """

    value: float
    field: str = ""


Bounds = Mapping[str, Bound]


@dataclass(frozen=True)
class Kind:
    """A quantity: what it is called, and which of its extremes counts.

    Attributes:
        name, unit: on the wire. largest: whether its largest is looked for.
        told: the core's value on the wire. core: the wire's in the core.
        must: what every cam has to keep, whoever asks.
    """

    name: str
    unit: str
    largest: bool
    told: Callable[[float], float] = float
    core: Callable[[float], float] = float
    must: Bound | None = None


@dataclass(frozen=True)
class Found:
    """An extreme [core units].

    Attributes:
        value: infinite where there is none. limit: beyond which it is known not to be, as far as
            the evidence goes. evidence: how that is known.
        theta: where [rad]; wall, rho: whose, and where on the roller [mm]; None: nobody's.
    """

    value: float
    limit: float
    evidence: str
    theta: float | None = None
    wall: Wall | None = None
    rho: float | None = None


def leading(value: float) -> float:
    """A value to twelve digits: of two that differ by roundings only, the first one counts."""
    return float(f"{value:.11e}")


def told(kind: Kind, found: Found, bounds: Bounds) -> SpatialExtreme:
    """On the wire, against its bound."""
    value, limit = kind.told(found.value), kind.told(found.limit)
    known = math.isfinite(value)
    width = abs(limit - value) if known and math.isfinite(limit) else 0.0
    bound = bounds.get(kind.name, kind.must)
    margin = None
    if bound is not None and known:
        margin = bound.value - value if kind.largest else value - bound.value
    wall = found.wall
    return SpatialExtreme(
        quantity=kind.name,
        value=value if known else None,
        unit=kind.unit,
        angle_deg=None if found.theta is None else found.theta / DEGREE,
        roller=None if wall is None else wall.seat.number,
        side=None if wall is None else wall.letter,
        rho_mm=found.rho,
        bound=None if bound is None else bound.value,
        margin=margin,
        width=width,
        holds=_holds(kind, bound, value, margin, width),
        evidence=found.evidence,
        field="" if bound is None else bound.field,
    )


def _holds(
    kind: Kind, bound: Bound | None, value: float, margin: float | None, width: float
) -> bool:
    """A least of nothing is infinite, and so keeps every bound; so does a largest of nothing."""
    if bound is None:
        return True
    if margin is None:
        return value == (-math.inf if kind.largest else math.inf)
    return margin >= width
