"""Motion laws: families, and each law an entry in the table of its family.

A law is normalised: g(x) from 0 to 1 over x in [0, 1]. Named laws (VDI 2143, Rothbart, Norton)
have a closed form; the spline is the optimiser's. Open ``base`` first. A new law is an entry in the
table of its family and its name in the ``kind`` above it; a new family is a file and its name in
``AnyLaw``.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, get_args

from pydantic import Field

from synthesis.catalogue.laws.base import MotionLaw
from synthesis.catalogue.laws.boundary_polynomial import BoundaryPolynomial
from synthesis.catalogue.laws.dwell_turn import DwellTurn
from synthesis.catalogue.laws.rest_to_rest import (
    ConstantVelocity,
    GeneralScca,
    HarmonicSeries,
    Polynomial,
    Scca,
)
from synthesis.catalogue.laws.spline import SplineLaw

AnyLaw = Annotated[
    ConstantVelocity
    | Scca
    | GeneralScca
    | HarmonicSeries
    | Polynomial
    | BoundaryPolynomial
    | DwellTurn
    | SplineLaw,
    Field(discriminator="kind"),
]

FAMILIES: tuple[type[MotionLaw], ...] = tuple(
    law for law in get_args(get_args(AnyLaw)[0]) if issubclass(law, MotionLaw)
)
"""The families of named laws: all but the spline, which is chosen."""

LAWS: Mapping[str, MotionLaw] = MappingProxyType(
    {kind: family(kind=kind) for family in FAMILIES for kind in family.entries}
)
"""Every named law by its kind, as published (inflection in the middle, turn at the top)."""

__all__ = ["LAWS", "AnyLaw", "MotionLaw", "SplineLaw"]
