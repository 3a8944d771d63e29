"""Linkages: machines of rigid links, analysed or sized.

In: the spec of one kind of linkage. Out: its answer, and files made from it (``files``).
    ``LINKAGES``
lists the kinds: a new one is a folder and its name here. Open ``linkage`` for what a kind has to
provide; ``shaper`` is the six-bar quick-return mechanism (analysis in closed form and by proven
enclosures, sizing by global search), ``arm`` the palletising arm with two parallelograms (inverse
kinematics, workspace, statics).
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from synthesis.machines.linkages import arm, shaper
from synthesis.machines.linkages.linkage import Linkage

LINKAGES: Mapping[str, Linkage] = MappingProxyType(
    {each.name: each for each in (shaper.LINKAGE, arm.LINKAGE)}
)

__all__ = ["LINKAGES", "Linkage"]
