"""The six-bar shaper: crank, rocking or turning guide, coupler and ram."""

from __future__ import annotations

from synthesis.linkages.shaper.found import SixBarShaper
from synthesis.linkages.shaper.spec import ShaperSpec
from synthesis.linkages.shaper.telling import told

__all__ = ["ShaperSpec", "SixBarShaper", "shaped"]


def shaped(spec: ShaperSpec, deadline: float | None = None) -> SixBarShaper:
    """What a shaper does, its free lengths chosen for the wishes.

    Raises:
        InputError: it cannot turn all the way round, or its crank stops.
    """
    return told(spec, {name: low for name, (low, _) in spec.given().items()})
