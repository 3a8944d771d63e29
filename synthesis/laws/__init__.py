"""Motion laws: one family a file, one law a row of its table.

A new law is a row (and its name in the ``kind`` above it); a new family is a file and its name in
the two lists here.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated

from pydantic import Field

from synthesis.laws.base import TASKS, Ends, MotionLaw
from synthesis.laws.boundary_polynomial import BoundaryPolynomial
from synthesis.laws.characteristics import Characteristics, characteristics
from synthesis.laws.constant_velocity import ConstantVelocity
from synthesis.laws.dwell_turn import DwellTurn
from synthesis.laws.harmonic_series import HarmonicSeries
from synthesis.laws.polynomial import Polynomial
from synthesis.laws.scca import GeneralScca, Scca
from synthesis.laws.spline import SplineLaw

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

FAMILIES: tuple[type[MotionLaw], ...] = (
    ConstantVelocity,
    Scca,
    GeneralScca,
    HarmonicSeries,
    Polynomial,
    BoundaryPolynomial,
    DwellTurn,
)

LAWS: Mapping[str, MotionLaw] = MappingProxyType(
    {kind: family(kind=kind) for family in FAMILIES for kind in family.rows}
)
"""Every named law by its kind, as published (inflection in the middle, turn at the top)."""

__all__ = [
    "LAWS",
    "TASKS",
    "AnyLaw",
    "Characteristics",
    "Ends",
    "MotionLaw",
    "SplineLaw",
    "characteristics",
]
