"""All machines around spatial cams: a new one is its file and its name here."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from synthesis.spatial.cylindrical_indexer import CylindricalIndexer
from synthesis.spatial.cylindrical_oscillating import CylindricalOscillating
from synthesis.spatial.cylindrical_translating import CylindricalTranslating
from synthesis.spatial.globoidal_indexer import GloboidalIndexer

MACHINES = (GloboidalIndexer, CylindricalTranslating, CylindricalOscillating, CylindricalIndexer)
AnyMachine = Annotated[
    GloboidalIndexer | CylindricalTranslating | CylindricalOscillating | CylindricalIndexer,
    Field(discriminator="kind"),
]
