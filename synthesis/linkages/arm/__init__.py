"""The palletising arm: two parallelograms that keep the tool upright."""

from __future__ import annotations

from synthesis.linkages.arm.found import PalletisingArm
from synthesis.linkages.arm.spec import ArmSpec
from synthesis.linkages.arm.telling import told
from synthesis.linkages.linkage import Linkage

__all__ = ["LINKAGE", "ArmSpec", "PalletisingArm", "posed"]


def posed(spec: ArmSpec, deadline: float | None = None) -> PalletisingArm:
    """Where an arm gets, how, and what that takes; it never takes long.

    Raises:
        InputError: its limits exclude each other.
    """
    return told(spec)


LINKAGE = Linkage(
    name="palletising-arms",
    noun="palletising arm",
    title="Analyse a palletising arm",
    purpose="Where its tool gets, with borders of exact arcs and their area; every way of being at "
    "each of the poses, with what it exceeds; the torques that hold its load; where it is "
    "singular. A place that cannot be reached is a result, not an error: its `note` says why.",
    spec=ArmSpec,
    found=PalletisingArm,
    work=posed,
    told=lambda found: {"reach_mm": found.reach_mm},
)
