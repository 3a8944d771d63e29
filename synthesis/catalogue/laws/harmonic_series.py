"""Laws that are a straight line and a few odd harmonics."""

from __future__ import annotations

from collections.abc import Mapping
from math import pi
from typing import ClassVar, Literal

from synthesis.catalogue.laws.base import LawEntry, RestToRest
from synthesis.numerics.piecewise import Piecewise

M = 1125 / 1192  # makes the mean velocity 1 with Freudenstein's ratios 1 : 1/54 : 1/1250


def harmonics(weights: Mapping[int, float]) -> Piecewise:
    """First half of s = x − (1/2π) Σ_k weight_k sin(2πkx)."""
    waves = [(-weight / (2.0 * pi), 2.0 * pi * k, 0.0) for k, weight in weights.items()]
    return Piecewise.of([0.0, 0.5], [[0.0, 1.0]], [waves])


class HarmonicSeries(RestToRest):
    """s = x − (1/2π) Σ m_k sin(2πkx): the cycloidal law with third and fifth harmonics.

    They lower the peak acceleration of the cycloidal law and keep the spectrum of the motion
    narrow, so that the follower train is little excited at high speed.

    | kind | m₁ | m₃ | m₅ |
    |---|---|---|---|
    | `gutman_1_3` | 15/16 | 1/48 | |
    | `freudenstein_1_3` | 27/28 | 1/84 | |
    | `freudenstein_1_3_5` | 1125/1192 | m₁/54 | m₁/1250 |
    """

    kind: Literal["gutman_1_3", "freudenstein_1_3", "freudenstein_1_3_5"]
    entries: ClassVar = {
        "gutman_1_3": LawEntry(
            "Gutman 1-3",
            "Gutman, To avoid vibration try this new cam profile, Product Engineering (1961)",
            harmonics({1: 15 / 16, 3: 1 / 48}),
        ),
        "freudenstein_1_3": LawEntry(
            "Freudenstein 1-3",
            "Freudenstein, On the dynamics of high-speed cam profiles, Int. J. Mech. Sci. 1 (1960)",
            harmonics({1: 27 / 28, 3: 1 / 84}),
        ),
        "freudenstein_1_3_5": LawEntry(
            "Freudenstein 1-3-5",
            "Freudenstein, On the dynamics of high-speed cam profiles, Int. J. Mech. Sci. 1 (1960)",
            harmonics({1: M, 3: M / 54, 5: M / 1250}),
        ),
    }
