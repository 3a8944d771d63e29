"""What keeps a roller on its cam: one closure a file; a new one is a file and its name here."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from synthesis.followers.closures.base import LEAST, Closure
from synthesis.followers.closures.conjugate import ConjugateArm, ConjugateSlide
from synthesis.followers.closures.force import Force
from synthesis.followers.closures.groove import Groove

SlideClosure = Annotated[
    Force | Groove | ConjugateSlide,
    Field(discriminator="kind", description="What keeps the roller on the cam."),
]
ArmClosure = Annotated[
    Force | Groove | ConjugateArm,
    Field(discriminator="kind", description="What keeps the roller on the cam."),
]

__all__ = [
    "LEAST",
    "ArmClosure",
    "Closure",
    "ConjugateArm",
    "ConjugateSlide",
    "Force",
    "Groove",
    "SlideClosure",
]
