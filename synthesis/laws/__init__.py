"""Motion laws: one family a file. A new one is a file and its name in the two lists here."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from synthesis.laws.base import MotionLaw
from synthesis.laws.cycloidal import Cycloidal
from synthesis.laws.spline import SplineLaw

AnyLaw = Annotated[Cycloidal | SplineLaw, Field(discriminator="kind")]

LAWS: tuple[type[MotionLaw], ...] = (Cycloidal,)

__all__ = ["LAWS", "AnyLaw", "MotionLaw", "SplineLaw"]
