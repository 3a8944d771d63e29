"""Dynamics: elastic follower trains (masses, springs, dampers) driven by a cam, and files of them.

In: a TrainSpec (``train``: cam, train, speeds) and the cam's design. Out: a TrainResponse. Open
``chain`` first: the equations of motion and their modes; ``response`` is the exact response mode by
mode and the residual spectrum, ``floating`` the motion after loss of contact, ``polydyne`` the cam
motion for a given output; ``report`` designs the cam where its spec leaves something free and puts
the answer together, ``files`` writes tables and diagrams.
"""

from synthesis.machines.dynamics.report import TrainResponse
from synthesis.machines.dynamics.train import TrainSpec

__all__ = ["TrainResponse", "TrainSpec"]
