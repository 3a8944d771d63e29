"""Linkages: machines of rigid links. A new one is a folder and its name here."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from synthesis.linkages import arm, shaper
from synthesis.linkages.linkage import Linkage

LINKAGES: Mapping[str, Linkage] = MappingProxyType(
    {each.name: each for each in (shaper.LINKAGE, arm.LINKAGE)}
)

__all__ = ["LINKAGES", "Linkage"]
