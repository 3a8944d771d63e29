"""The palletising arm: two parallelograms keep its tool upright.

In: an ArmSpec (lengths, joint limits, masses, poses). Out: a PalletisingArm: workspace, postures of
every pose, holding torques, singular arm angles. Open ``geometry`` first: kinematics and statics;
``workspace`` has the joint limits and the regions that the tool reaches within them, ``report``
puts the answer together.
"""

from __future__ import annotations

from synthesis.machines.linkages.arm.report import PalletisingArm, analyse_arm
from synthesis.machines.linkages.arm.spec import ArmSpec
from synthesis.machines.linkages.linkage import Linkage

__all__ = ["LINKAGE", "ArmSpec", "PalletisingArm", "analyse_arm"]

LINKAGE = Linkage(
    name="palletising-arms",
    noun="palletising arm",
    title="Analyse a palletising arm",
    purpose="The tool's workspace, with borders of exact arcs and their area; every posture for "
    "each of the poses, with the limits that it exceeds; the torques that hold the load; the "
    "singular arm angles. A place that cannot be reached is a result, not an error: its `note` "
    "says why.",
    spec=ArmSpec,
    answer=PalletisingArm,
    solve=analyse_arm,
    summary=lambda arm: {"reach_mm": arm.reach_mm},
)
