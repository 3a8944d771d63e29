"""The judge: measures the finished cam at every angle; knows no solver and no formulation."""

from __future__ import annotations

from synthesis.certify.claims import certify
from synthesis.certify.dimensions import certify_size
from synthesis.certify.forces import forces
from synthesis.certify.objectives import measure
from synthesis.certify.simple import CROSSING
from synthesis.numerics.enclosure import Enclosed

__all__ = ["CROSSING", "Enclosed", "certify", "certify_size", "forces", "measure"]
