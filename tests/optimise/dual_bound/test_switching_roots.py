"""A root of ψ next to the end of the law."""

from __future__ import annotations

import numpy as np

from synthesis.optimise.dual_bound.switching import Switching


def test_losses_have_one_number_for_each_interval_of_the_knots() -> None:
    """The middle between the last root and the end rounds to the end itself."""
    knots = np.linspace(0.0, 1.0, 7)
    for start in np.random.default_rng(4).uniform(0.01, 0.99, 2000):
        last = np.array([-(1.0 - 2.0**-53), 1.0])  # its root is the number next to 1
        psi = Switching(np.array([0.0, start, 1.0]), np.array([[0.5, 0.0], last]))
        losses = psi.losses(knots, np.zeros_like, 1.0, 0.0)
        assert len(losses) == len(knots) - 1
        assert np.all(losses >= 0.0)
