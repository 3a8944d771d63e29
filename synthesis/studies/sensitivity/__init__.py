"""Sensitivity: how the optimum changes with each number of the spec that limits it.

In: a finished design. Out: ``Sensitivities``, the derivative of the first objective by every limit
and range, on both sides where they differ. Open ``sensitivities`` first. ``perturbation`` is the
design as the optimum of its problem: its value under a changed spec, estimated by multipliers or
solved again; ``derivatives`` compares the two; ``spec_numbers`` finds the numbers; ``fixed_knots``
holds the laws that are compared, splines on the design's own knots.
"""

from synthesis.studies.sensitivity.sensitivities import sensitivities

__all__ = ["sensitivities"]
