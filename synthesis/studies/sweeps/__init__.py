"""Sweeps: many specs from one base spec, and the Pareto front of their designs.

In: a SweepSpec: base, axes (which fields take which values) and a plan (how the axes combine). Out:
the design spec of every item; nothing is solved here, the service does. Open ``spec`` first;
``pareto`` finds the non-dominated designs.
"""

from synthesis.studies.sweeps.spec import SweepSpec

__all__ = ["SweepSpec"]
