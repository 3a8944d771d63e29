"""All machines around spatial cams. A new one is a file and its name here."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from synthesis.machines.spatial.cylindrical_indexer import CylindricalIndexer
from synthesis.machines.spatial.cylindrical_oscillating import CylindricalOscillating
from synthesis.machines.spatial.cylindrical_translating import CylindricalTranslating
from synthesis.machines.spatial.globoidal_indexer import GloboidalIndexer

MACHINES = (GloboidalIndexer, CylindricalTranslating, CylindricalOscillating, CylindricalIndexer)
AnyMachine = Annotated[
    GloboidalIndexer | CylindricalTranslating | CylindricalOscillating | CylindricalIndexer,
    Field(discriminator="kind"),
]
