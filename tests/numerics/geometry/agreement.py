"""Saying where and by how much two ways to the same number disagree."""

import numpy as np


def agree(
    what: str, theta: np.ndarray, reported: np.ndarray, measured: np.ndarray, allowed: np.ndarray
) -> None:
    """Each reported value is within ``allowed`` of the measured one."""
    reported, measured, allowed = np.broadcast_arrays(reported, measured, allowed)
    excess = abs(reported - measured) - allowed
    worst = int(np.argmax(excess))
    assert np.all(excess <= 0.0), (
        f"{what} at {np.degrees(theta[worst]):.6f}°: reported {reported[worst]}, "
        f"measured {measured[worst]} (allowed {allowed[worst]:.1e})"
    )
