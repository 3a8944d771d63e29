"""What each limit costs."""

from synthesis.sensitivity.costs import sensitivities

__all__ = ["sensitivities"]
