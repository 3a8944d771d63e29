"""What keeps a roller on its cam: one closure a file; a new one is a file and its name here."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from synthesis.catalogue.followers.closures.base import MIN_PRIME_RADIUS_RATIO, Closure
from synthesis.catalogue.followers.closures.conjugate import ConjugateArm, ConjugateSlide
from synthesis.catalogue.followers.closures.force import Force
from synthesis.catalogue.followers.closures.groove import Groove

SlideClosure = Annotated[
    Force | Groove | ConjugateSlide,
    Field(discriminator="kind", description="What keeps the roller on the cam."),
]
ArmClosure = Annotated[
    Force | Groove | ConjugateArm,
    Field(discriminator="kind", description="What keeps the roller on the cam."),
]

__all__ = [
    "MIN_PRIME_RADIUS_RATIO",
    "ArmClosure",
    "Closure",
    "ConjugateArm",
    "ConjugateSlide",
    "Force",
    "Groove",
    "SlideClosure",
]
