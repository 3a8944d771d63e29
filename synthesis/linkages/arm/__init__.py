"""The palletising arm: two parallelograms that keep the tool upright."""

from __future__ import annotations

from synthesis.linkages.arm.found import PalletisingArm
from synthesis.linkages.arm.spec import ArmSpec
from synthesis.linkages.arm.telling import told

__all__ = ["ArmSpec", "PalletisingArm", "posed"]


def posed(spec: ArmSpec, deadline: float | None = None) -> PalletisingArm:
    """Where an arm gets, how, and what that takes; it never takes long.

    Raises:
        InputError: its limits exclude each other.
    """
    return told(spec)
