"""Sensitivity: how the optimum changes with each number of the spec that limits it.

In: a finished design. Out: ``Sensitivities``, the derivative of the first objective by every limit
and range, on both sides where they differ. Open ``sensitivities`` first: it has the numbers of a
spec and compares two methods. ``perturbation`` is the design as the optimum of its problem on its
own knots: its value under a changed spec, by multipliers or solved again.
"""

from synthesis.studies.sensitivity.sensitivities import sensitivities

__all__ = ["sensitivities"]
