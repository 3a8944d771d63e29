"""Measured: the motion that a measured profile gives a follower.

    points -> outline (smooth curve) -> contact (follower on it) -> motion (spline) -> report

In: a MeasuredCam, points of a profile and a follower given in full. Out: a ProfileAnalysis: motion,
extremes with their uncertainty, dwells, and what the follower does not touch. Open ``report``
first: the steps in order, motion and answer; ``follower_path`` is outline and contact.
"""

from synthesis.studies.measured.bodies import MeasuredCam, ProfileAnalysis
from synthesis.studies.measured.report import read_back

__all__ = ["MeasuredCam", "ProfileAnalysis", "read_back"]
