"""Elastic follower trains: their modes, their response to a cam, and what is told of it."""

from synthesis.dynamics.report import TrainResponse
from synthesis.dynamics.train import TrainSpec

__all__ = ["TrainResponse", "TrainSpec"]
