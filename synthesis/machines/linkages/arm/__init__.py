"""The palletising arm: two parallelograms keep its tool upright.

In: an ArmSpec (lengths, joint limits, masses, poses). Out: a PalletisingArm: workspace, postures of
every pose, holding torques, singular arm angles. Open ``geometry`` first: kinematics, statics, the
joint limits and the regions that the tool reaches within them; ``report`` puts the answer together.
"""

from synthesis.machines.linkages.arm.report import PalletisingArm, analyse_arm
from synthesis.machines.linkages.arm.spec import ArmSpec

__all__ = ["ArmSpec", "PalletisingArm", "analyse_arm"]
