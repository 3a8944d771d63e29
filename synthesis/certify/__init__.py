"""The judge: measures a finished cam at every cam angle and proves every limit, or refuses it.

In: a motion, a machine (follower, speed, load), the follower's size, and the spec's limits. Out:
the lines of the certificate (``Extreme``), each with value, bound, proven width and verdict; values
of objectives; what the forces come to. Nothing here imports the optimiser. Contact, pressure angle
and curvature come from the path of the traced point alone, by no formula of the optimiser's. Shared
with it are formulas of the catalogue: the dimensions of a size, the norm that stands for a radius,
and how a load becomes a force.

Open ``certificate.py`` first; ``quantities.py`` has the measured quantities, ``motion_checks.py``
what every motion must satisfy, ``self_intersection.py`` and ``roller_interference.py`` the proof
that the profile is simple. ``second/`` is a second judge in ball arithmetic.
"""

from synthesis.certify.cam_geometry import summarise_geometry
from synthesis.certify.certificate import certify
from synthesis.certify.force_report import report_forces
from synthesis.certify.motion_checks import certify_size
from synthesis.certify.motion_summary import summarise_motion
from synthesis.certify.objectives import measure_objective
from synthesis.certify.self_intersection import SELF_CROSSING
from synthesis.numerics.enclosure import Enclosure

__all__ = [
    "SELF_CROSSING",
    "Enclosure",
    "certify",
    "certify_size",
    "measure_objective",
    "report_forces",
    "summarise_geometry",
    "summarise_motion",
]
