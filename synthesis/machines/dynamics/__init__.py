"""Dynamics: elastic follower trains (masses, springs, dampers) driven by a cam, and files of them.

In: a TrainSpec (cam, train, speeds) and the cam's design. Out: a TrainResponse. Open ``chain``
first: the equations of motion and their modes; ``response`` is the exact response mode by mode,
``floating`` the motion after loss of contact, ``spectrum`` the residual vibration of a motion,
``polydyne`` the cam motion for a given output; ``report`` puts the answer together.
``studies.train_response`` designs the cam first where its spec leaves something free.
"""

from synthesis.machines.dynamics.report import TrainResponse
from synthesis.machines.dynamics.train import TrainSpec

__all__ = ["TrainResponse", "TrainSpec"]
