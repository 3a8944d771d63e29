"""The six-bar shaper: crank, rocking or turning guide, coupler and ram."""

from __future__ import annotations

from synthesis.linkages.linkage import Linkage
from synthesis.linkages.shaper.found import SixBarShaper
from synthesis.linkages.shaper.sizing import sized
from synthesis.linkages.shaper.spec import ShaperSpec
from synthesis.linkages.shaper.telling import told

__all__ = ["LINKAGE", "ShaperSpec", "SixBarShaper", "shaped"]


def shaped(spec: ShaperSpec, deadline: float | None = None) -> SixBarShaper:
    """What a shaper does, its free lengths chosen for the wishes.

    Raises:
        InputError: it cannot turn all the way round, or its crank stops.
        TimeBudgetExceeded: before lengths were found or excluded.
    """
    if spec.free:
        return sized(spec, deadline)
    return told(spec, {name: low for name, (low, _) in spec.given().items()})


def _told(found: SixBarShaper) -> dict[str, float]:
    if found.stroke_mm is None or found.quick_return is None:
        return {}
    return {"stroke_mm": found.stroke_mm, "quick_return_ratio": found.quick_return.ratio}


LINKAGE = Linkage(
    name="six-bar-shapers",
    noun="six-bar shaper",
    title="Analyse or size a six-bar shaper",
    purpose="Dead centres in closed form, stroke, quick-return ratio, transmission angle and the "
    "extremes of velocities and accelerations with proven enclosures. Lengths left free as "
    "`{min, max}` are chosen for a stroke and a quick-return ratio that are wanted.",
    spec=ShaperSpec,
    found=SixBarShaper,
    work=shaped,
    told=_told,
)
